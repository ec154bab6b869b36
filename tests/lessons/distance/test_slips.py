"""Slips that students make in lesson 04: each gets its message, and two at once get both messages."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.exercises.checking import grade_public
from tests.lessons.distance.own import own
from tests.lessons.every import public_exercise


def messages(name, function):
    return " ".join(grade_public(public_exercise("04_distance", name), function).lines)


def rays_of(pixels, view):
    u, v = ((pixels - view.centre) / view.focal).T
    return np.column_stack([np.ones(len(u)), -u, -v]) @ view.rotation.T


def to_ground(*, lens=True, horizon=True, offset=True, sign=1, loop=False):
    """Return a student's `pixel_to_ground`, perhaps with slips."""

    def pixel_to_ground(pixels, view):
        rays = rays_of(view.undistort(pixels) if lens else pixels, view)
        down = np.where(rays[:, 2] < 0, -rays[:, 2], np.nan) if horizon else -rays[:, 2]
        points = view.height * rays[:, :2] / (sign * down[:, None]) + (view.offset if offset else 0)
        return np.array(list(points)) if loop else points

    return pixel_to_ground


LENS, OFFSET, HORIZON = "Remove it first", "the camera is at view.offset, so add it", "Return NaN there."
SIGN, EMPTY = "on the opposite side of the camera", "add .reshape(-1, 2)"


@pytest.mark.parametrize(
    ("slips", "said"),
    [
        ({"lens": False}, [LENS]),
        ({"sign": -1}, [SIGN]),
        ({"loop": True}, [EMPTY]),
        ({"lens": False, "offset": False}, [LENS, OFFSET]),
        ({"lens": False, "horizon": False}, [LENS, HORIZON]),
        ({"offset": False, "horizon": False}, [OFFSET, HORIZON]),
        ({"sign": -1, "horizon": False}, [SIGN, HORIZON]),
        ({"lens": False, "loop": True}, [LENS, EMPTY]),
    ],
)
def test_slips_of_the_ground_get_their_messages_alone_and_two_together(slips, said):
    found = messages("pixel_to_ground", to_ground(**slips))
    assert all(each in found for each in said), found


def covariance(*, product=np.outer, blocks=2, step=2e-4, shift=(0.01, 0), add=True):
    """Return a student's `measurement_covariance`, perhaps with slips."""
    geometry = own()

    def measurement_covariance(pixels, view, pixel_sigma, tilt_sigma):
        def measured(shift, tilt):
            tilted = replace(view, pitch=view.pitch + tilt)
            return geometry["ground_to_measurement"](
                geometry["pixel_to_ground"](pixels + shift, tilted)
            ).ravel()

        by_u = (measured(shift, 0) - measured(np.negative(shift), 0)) / 0.02
        by_v = (measured((0, 0.01), 0) - measured((0, -0.01), 0)) / 0.02
        g = (measured((0, 0), 1e-4) - measured((0, 0), -1e-4)) / step
        R = tilt_sigma**2 * product(g, g.T)
        for i in range(0, len(g) * blocks // 2, blocks):
            J = np.column_stack([by_u[i : i + 2], by_v[i : i + 2]])
            R[i : i + 2, i : i + 2] = (R[i : i + 2, i : i + 2] if add else 0) + pixel_sigma**2 * J @ J.T
        return R

    return measurement_covariance


@pytest.mark.parametrize(
    ("slips", "said"),
    [
        ({"product": np.multiply}, "g.T is the same as g"),
        ({"blocks": 1}, "Your blocks overlap."),
        ({"step": 1e-4}, "Your g is twice as large"),
        ({"shift": 0.01}, "(0.01, 0) moves u alone"),
        ({"add": False}, "Add them to it."),
    ],
)
def test_slips_of_the_covariance_get_their_messages(slips, said):
    assert said in messages("measurement_covariance", covariance(**slips))


def searched(unit=1.0, few=None, power=2, ground=False):
    """Return a student's `estimate_pitch`, a search on a grid, perhaps with slips."""

    def estimate_pitch(pixels, ground_points, view):
        pixels, ground_points = pixels[:few], ground_points[:few]
        grid = np.radians(np.arange(-10, 10.01, 0.05))
        costs = []
        for offset in grid:
            tilted = replace(view, pitch=view.pitch + offset)
            misses = (
                to_ground()(pixels, tilted) - ground_points
                if ground
                else tilted.project(ground_points) - pixels
            )
            costs.append(np.nansum(np.abs(misses) ** power))
        return unit * grid[np.argmin(costs)]

    return estimate_pitch


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


@pytest.mark.parametrize(
    ("name", "function", "said"),
    [
        (
            "paper_distance",
            lambda pixels, view: np.abs(own()["paper_distance"](pixels, view)),
            "You return absolute values",
        ),
        ("range_sigma", lambda r, h, s: (h + r**2) * s, "a length and an area"),
        ("range_sigma", lambda r, h, s: -(r**2) / h * s, "You leave out h squared"),
        ("range_sigma", lambda r, h, s: -(r**2) / h * s, "a standard deviation is not"),
        (
            "paper_bearing",
            lambda pixels, view: own()["paper_bearing"](pixels, replace(view, size=view.size[::-1])),
            "You use the height of the picture",
        ),
    ],
)
def test_slips_of_the_formulas_get_their_messages(name, function, said):
    assert said in messages(name, function)
