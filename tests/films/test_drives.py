"""The film of a drive holds the drive's poses, landmarks, ellipses and measurements."""

import numpy as np
import pytest

from nao_course import films
from nao_course.films.film import frames_of
from nao_course.geometry import Pose
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement, measured_points

RNG = np.random.default_rng(4)
HALF = 0.0005 + 1e-9  # m and rad
STEPS = 5


def estimate(landmarks):
    spreads = [np.diag(RNG.uniform(0.001, 0.1, 2)) for _ in range(landmarks)]
    return Estimate(
        Pose(*RNG.uniform(-1, 1, 3)),
        np.diag(RNG.uniform(0.001, 0.1, 3)),
        RNG.uniform(-2, 2, (landmarks, 2)),
        np.array(spreads).reshape(-1, 2, 2),
        tuple("post" if number % 2 else "corner" for number in range(landmarks)),
    )


@pytest.fixture(scope="module")
def drive():
    truth = [Pose(*RNG.uniform(-1, 1, 3)) for _ in range(STEPS)]
    found = {
        "odometry": [estimate(0) for _ in range(STEPS)],
        "ekf": [estimate(number) for number in range(STEPS)],
        "graph": [estimate(2) for _ in range(STEPS)],
    }
    seen = [[Measurement(0.3, 1.0 + number)] * (number % 3) for number in range(STEPS)]
    return truth, found, seen, films.drive_film("A drive", Field(), truth, found, seen)


def layer(film, kind, label):
    data = film.data()
    [number] = [n for n, each in enumerate(data["layers"]) if (each["kind"], each["label"]) == (kind, label)]
    return frames_of(data, number)


def test_paths_landmarks_ellipses_and_rays_are_those_of_the_drive_and_its_estimates(drive):
    truth, found, seen, film = drive
    names = {"odometry": "odometry", "EKF": "ekf", "graph": "graph"}
    paths = {name: [each.pose for each in found[source]] for name, source in names.items()}
    paths["true path"] = truth
    for name, poses in paths.items():
        shown = np.vstack(layer(film, "path", name))
        assert np.abs(shown - [pose.as_array() for pose in poses]).max() <= HALF
    for name, source in (("EKF", "ekf"), ("graph", "graph")):
        marks = layer(film, "landmarks", f"{name}: landmark")
        ellipses = layer(film, "ellipses", f"{name}, 95 %")
        for each, mark, ellipse in zip(found[source], marks, ellipses, strict=True):
            assert np.abs(mark[:, :2] - each.landmarks).max(initial=0) <= HALF
            assert [("corner", "post")[int(kind)] for kind in mark[:, 2]] == list(each.kinds)
            assert len(ellipse) == 1 + len(each.landmarks)
            roots = np.array([[(a, b), (b, d)] for _, _, a, b, d in ellipse])
            covariances = np.concatenate([each.covariance[None, :2, :2], each.landmark_covariances])
            assert roots @ roots / (-2 * np.log(0.05)) == pytest.approx(covariances, abs=3e-4)
    for each, measured, rays in zip(found["graph"], seen, layer(film, "lines", "measured"), strict=True):
        ends = measured_points(measured, each.pose)
        assert len(rays) == len(measured)
        assert np.abs(rays[:, 2:] - ends).max(initial=0) <= HALF
        assert np.abs(rays[:, :2] - [each.pose.x, each.pose.y]).max(initial=0) <= HALF


def test_a_caption_says_how_far_off_each_position_is(drive):
    truth, found, _, film = drive
    off = 100 * np.hypot(found["ekf"][2].pose.x - truth[2].x, found["ekf"][2].pose.y - truth[2].y)
    assert film.captions[2].startswith("After 3 pictures. ")
    assert off > 10 and f"EKF {off:.0f} cm" in film.captions[2]
    near = Estimate(Pose(0.003, 0.0, 0.0), np.eye(3), np.empty((0, 2)), np.empty((0, 2, 2)))
    film = films.drive_film("A drive", Field(), [Pose()], {"ekf": [near]}, [[]])
    assert film.captions == ["After 1 picture. Position off: EKF 0.3 cm."]
