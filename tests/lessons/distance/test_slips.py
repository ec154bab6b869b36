"""Slips that students make in lesson 04: each gets its message, and two at once get both messages."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.exercises.checking import grade_public
from tests.lessons.every import public_exercise


def messages(name, function):
    return " ".join(grade_public(public_exercise("04_distance", name), function).lines)


def rays_of(pixels, view):
    u, v = ((pixels - view.centre) / view.focal).T
    return np.column_stack([np.ones(len(u)), -u, -v]) @ view.rotation.T


def to_ground(*, horizon=True, sign=1, loop=False):
    """Return a student's `pixel_to_ground`, perhaps with slips."""

    def pixel_to_ground(pixels, view):
        rays = rays_of(view.undistort(pixels), view)
        down = np.where(rays[:, 2] < 0, -rays[:, 2], np.nan) if horizon else -rays[:, 2]
        points = view.height * rays[:, :2] / (sign * down[:, None]) + view.offset
        return np.array(list(points)) if loop else points

    return pixel_to_ground


HORIZON, SIGN, EMPTY = "Return NaN there.", "on the opposite side of the camera", "add .reshape(-1, 2)"


@pytest.mark.parametrize(
    ("slips", "said"), [({"loop": True}, [EMPTY]), ({"sign": -1, "horizon": False}, [SIGN, HORIZON])]
)
def test_slips_of_the_ground_get_their_messages_alone_and_two_together(slips, said):
    found = messages("pixel_to_ground", to_ground(**slips))
    assert all(each in found for each in said), found


def searched(unit=1.0, few=None, ground=False):
    """Return a student's `estimate_pitch`, a search on a grid, perhaps with slips."""

    def estimate_pitch(pixels, ground_points, view):
        pixels, ground_points = pixels[:few], ground_points[:few]
        grid = np.radians(np.arange(-10, 10.01, 0.05))
        costs = []
        for offset in grid:
            tilted = replace(view, pitch=view.pitch + offset)
            on_the_ground = to_ground()(pixels, tilted) - ground_points
            misses = on_the_ground if ground else tilted.project(ground_points) - pixels
            costs.append(np.nansum(np.square(misses)))
        return unit * grid[np.argmin(costs)]

    return estimate_pitch


@pytest.mark.slow
@pytest.mark.parametrize(
    ("slips", "said"),
    [
        ({"unit": 180 / np.pi}, "Is it in rad"),
        ({"few": 1}, "use all points"),
        ({"few": 3}, "use all points"),
        ({"ground": True}, "Compare in the picture with view.project"),
    ],
)
def test_slips_of_the_calibration_get_their_messages_and_a_search_on_a_grid_is_right(slips, said):
    assert grade_public(public_exercise("04_distance", "estimate_pitch"), searched())
    found = grade_public(public_exercise("04_distance", "estimate_pitch"), searched(**slips))
    assert not found and said in " ".join(found.lines), found
