"""On a real robot's pictures, points fall where the library's field and camera say."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.simulator import reality
from benchmarks.simulator.reality import Case, Freedom, errors_of, fit_residuals, fit_set, run_case, summary
from nao_course.datasets import AnnotatedPoint, RealPicture, read_pictures
from nao_course.geometry import Pose
from nao_course.sim.camera import NAO_V4

LARGEST_MEDIAN, LARGEST_95 = 2.2, 8.0  # pixels at 320 x 240


@pytest.fixture(scope="module")
def scenes(data_dir: Path) -> Case:
    return run_case("scenes", read_pictures("scenes", data_dir))


@pytest.fixture(scope="module")
def walk(data_dir: Path) -> Case:
    return run_case("straightwalk", reality.corrected_walk(read_pictures("straightwalk", data_dir)))


@pytest.mark.parametrize("name", [pytest.param("scenes", marks=pytest.mark.slow), "walk"])
def test_every_point_is_predicted_from_the_others_within_the_required_pixels(name, request):
    case: Case = request.getfixturevalue(name)
    found = summary(errors_of(case.predictions))
    assert found["median"] <= LARGEST_MEDIAN
    assert found["95%"] <= LARGEST_95


@pytest.mark.slow
def test_the_fitted_camera_is_the_makers_with_a_barrel_lens_at_a_walking_robots_height(scenes):
    height, hfov, vfov, k1, offset = scenes.fit.values
    assert height == pytest.approx(0.479, abs=0.015)
    assert hfov == pytest.approx(NAO_V4.hfov, abs=np.radians(2))
    assert vfov == pytest.approx(NAO_V4.vfov, abs=np.radians(2))
    assert -0.15 < k1 < -0.03
    assert 4 < np.degrees(offset) < 8
    assert np.degrees(np.abs(scenes.fit.corrections[:, :2]).max()) < 3


@pytest.mark.slow
def test_no_marked_point_is_left_out(scenes, walk, data_dir):
    for case, name in ((scenes, "scenes"), (walk, "straightwalk")):
        enough = [p for p in read_pictures(name, data_dir) if len(p.points) >= 4]  # type: ignore[arg-type]
        assert len(case.predictions) == sum(len(picture.points) for picture in enough)
        assert np.isfinite(errors_of(case.predictions)).all()
        assert all(item.used.all() for item in case.fit.matched)
    assert (len(scenes.fit.matched), len(walk.fit.matched)) == (29, 19)


@pytest.mark.slow
def test_no_kind_of_point_is_marked_a_pixel_too_high_or_low(scenes, walk):
    for case in (scenes, walk):
        for kind, residuals in fit_residuals(case.fit).items():
            assert abs(np.median(residuals[:, 1])) < 1.0, kind


@pytest.mark.slow
def test_both_sets_agree_on_one_robot_when_its_pixels_are_square(data_dir):
    walk = reality.corrected_walk(read_pictures("straightwalk", data_dir))
    sets = read_pictures("scenes", data_dir), walk
    heights, hfovs = np.array([fit_set(pictures, Freedom(square=True)).values[:2] for pictures in sets]).T
    assert np.ptp(heights) < 0.005
    assert np.abs(heights - 0.479).max() < 0.005
    assert np.ptp(hfovs) < np.radians(1.0)


@pytest.mark.slow
def test_the_walks_first_seven_poses_are_one_stop_ahead_of_their_pictures(walk, data_dir):
    """Where positions may move, the pictures themselves say so: by a stop at the eighth, by little after."""
    given = fit_set(read_pictures("straightwalk", data_dir), Freedom(position_sd=0.5))
    along = given.corrections[:, 3]
    before, after = along[: reality.WALK_BEFORE_THE_GAP], along[reality.WALK_BEFORE_THE_GAP :]
    assert np.median(after[:5]) - np.median(before) == pytest.approx(reality.WALK_STOP, abs=0.04)
    as_given = run_case("as given", read_pictures("straightwalk", data_dir))
    wrong, right = (summary(errors_of(case.predictions))["median"] for case in (as_given, walk))
    assert wrong > 1.5 * right


def made_pictures(values: np.ndarray, corrections: np.ndarray) -> tuple[RealPicture, ...]:
    """Pictures whose points lie exactly where these values put the landmarks."""
    made = []
    poses = [Pose(x, y, h) for x, y in ((-2.0, 0.3), (-1.2, -0.8)) for h in (0.0, 0.3, -0.3)]
    for number, (pose, correction) in enumerate(zip(poses, corrections, strict=True)):
        blank = RealPicture(f"made_{number}.png", Path(), pose, 0.05, -0.54, ())
        view, _ = reality.fitted_view(blank, values, correction)
        points = []
        for kind in reality.KINDS:
            pixels = reality.predict(blank, values, correction, reality.landmarks_of(kind))
            points += [AnnotatedPoint(kind, u, v) for u, v in pixels[view.contains(pixels)].tolist()]
        made.append(replace(blank, points=tuple(points)))
    return tuple(made)


@pytest.fixture
def truth(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    values = np.array([0.48, np.radians(59.5), np.radians(46.5), -0.06, np.radians(5.5)])
    corrections = np.radians(rng.normal(0, [0.8, 0.7, 2.0], (6, 3)))
    corrections[:, 0] -= corrections[:, 0].mean()
    return values, corrections


@pytest.mark.slow
def test_points_without_noise_give_back_the_truth_and_one_wild_point_does_not_spoil_it(truth):
    values, corrections = truth
    made = made_pictures(values, corrections)
    assert all(len(picture.points) >= reality.FEWEST_POINTS for picture in made)
    case = run_case("made", made)
    np.testing.assert_allclose(case.fit.values, values, atol=1e-4)
    np.testing.assert_allclose(case.fit.corrections, corrections, atol=1e-4)
    assert errors_of(case.predictions).max() < 0.02
    first = made[0].points[0]
    wild = replace(made[0], points=(replace(first, u=first.u + 60, v=first.v - 40), *made[0].points[1:]))
    errors = errors_of(run_case("made", (wild, *made[1:])).predictions)
    assert errors[0] > 50
    assert np.quantile(errors[1:], 0.95) < 0.5


def test_the_fit_starts_from_the_makers_angles_without_any_lens():
    picture = RealPicture("made.png", Path(), Pose(), 0.1, -0.5, ())
    view, pose = reality.fitted_view(picture, reality.START, np.zeros(3))
    specified = NAO_V4.view("bottom", 0.1, -0.5)
    assert (view.yaw, view.roll, view.offset) == (specified.yaw, specified.roll, specified.offset)
    assert (view.hfov, view.vfov, view.k1) == (NAO_V4.hfov, NAO_V4.vfov, 0.0)
    assert pose == picture.pose


def test_a_matched_landmark_is_of_the_points_kind_and_given_to_no_other_point(truth):
    values, corrections = truth
    for picture, correction in zip(made_pictures(values, corrections), corrections, strict=True):
        found = reality.match(picture, values, correction, gate=20.0)
        for kind in {point.kind for point in picture.points}:
            rows = [i for i, point in enumerate(picture.points) if point.kind == kind]
            given = {tuple(row) for row in found.landmarks[rows].tolist()}
            assert len(given) == len(rows)
            assert given <= {tuple(row) for row in reality.landmarks_of(kind).tolist()}
