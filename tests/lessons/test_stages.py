"""The stages that lessons add to the robot: errors are named, and what is computed is true.

The stages of lessons 03, 08, 10, 11 and 12 have more to test, each in its lesson's folder.
"""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.goalposts.measuring import Feet, match_feet
from nao_course.lessons.goalposts.stage import GREEN, YELLOW
from nao_course.lessons.localization.stage import START_COVARIANCE, START_ERROR
from nao_course.metrics import total
from nao_course.sim import Field, SimulatedNao, TorsoTilt, Truth
from nao_course.widgets.control_panel import ControlPanel, Overlay, Stage
from tests.lessons.driven import POSE, STAGES, functions_of, look, off, pipeline, robot
from tests.lessons.every import own, text

# Stages that search or run a whole filter are broken in their lessons' own tests.
BROKEN = [
    (stage.name, used)
    for stage in STAGES.values()
    for used in stage.uses
    if stage.lesson[:2] not in ("08", "10", "11") and used != "choose_move"
]


@pytest.mark.parametrize(("name", "used"), BROKEN)
def test_what_fails_is_named_and_tried_again_and_nonsense_stops_nothing(name, used):
    function, errors = used.rpartition(":")[2], [ZeroDivisionError("no")]
    right = functions_of(STAGES[name])[function]

    def broken(*given, **named):
        if errors:
            raise errors[0]
        return right(*given, **named)

    def drive(changed):
        """Yield what a pipeline complains about after each of three pictures."""
        nao = robot()
        live = pipeline(name, nao, **{function: changed})
        for _ in range(3):
            nao.walk(0.05)
            yield live.process(nao.take_picture("bottom")).complaints
            live.retry()

    for_an_error = drive(broken)
    next(for_an_error)
    assert next(for_an_error)[0].startswith(f"Without {name}: ZeroDivisionError in {function}()")
    errors.clear()
    assert next(for_an_error) == ()
    assert [*drive(lambda *given, **named: None)][1][0].startswith(f"Without {name}: ")


@pytest.mark.parametrize(
    ("name", "pose", "said"),
    [
        ("goal posts", Pose(1.0, 0.0, np.pi), "0 found"),
        ("points on the map", POSE, "lessons 02 and 03"),
        ("dead reckoning", POSE, "standard deviation 0.00 m and 0°"),
    ],
)
def test_a_picture_in_which_nothing_is_found_says_so(name, pose, said):
    assert said in look(name, robot(pose)).overlays[name].text


# --- lesson 01 ---


def panel_of(name, nao):
    return ControlPanel(nao, Truth(nao), pipeline=pipeline(name, nao))


@pytest.mark.parametrize("pose", [POSE, Pose(1.2, -0.5, 0.6)])
def test_labels_are_mostly_true_and_other_pixels_of_the_picture_stay_as_they_are(pose):
    panel = panel_of("labels", robot(pose))
    labels = panel._own.latest.overlays["labels"].result
    truth = panel.cockpit.picture_truth("bottom").labels
    assert np.mean(labels[truth == 1] == 1) > 0.85 and np.mean(labels[truth == 3] == 3) > 0.9
    assert f"green {np.mean(labels == 1):.0%}" in panel.summary()
    pixels, (shown, _) = panel.cockpit.pictures["bottom"].pixels, panel._screen.shown("bottom")
    assert np.array_equal(shown[labels == 0], pixels[labels == 0])
    assert not np.array_equal(shown[labels == 1], pixels[labels == 1])


@pytest.mark.slow
def test_a_field_without_a_yellow_goal_says_so():
    assert "no yellow goal" in panel_of("labels", SimulatedNao(Field(2025), rng=3)).summary()


# --- lesson 02 ---


def test_the_feet_in_the_picture_are_those_of_the_posts():
    nao = robot()
    found = look("goal posts", nao, STAGES["labels"], **functions_of(STAGES["labels"])).overlays["goal posts"]
    true = [mark.pixel for mark in Truth(nao).picture.landmarks if mark.landmark.kind == "post"]
    assert len(found.pixels) == len(true) == 2
    assert np.allclose(sorted(map(tuple, found.pixels)), sorted(true), atol=4.0)
    assert found.text == "2 found" and found.result is not None


def test_posts_are_found_with_the_lessons_limits_and_much_more_often_than_with_narrow_ones(rng):
    assert f"GREEN, YELLOW = {GREEN}, {YELLOW}" in text("02")
    live = pipeline("goal posts", robot(), STAGES["labels"], **functions_of(STAGES["labels"]))
    found, narrow = [], []
    for _ in range(16):
        x, y = rng.uniform((0.0, -1.5), (2.2, 1.5))
        nao = robot(Pose(x, y, float(np.arctan2(0.7 - y, 3.0 - x))))
        seen = live.process(nao.take_picture("bottom"))
        feet = Feet.of(Truth(nao).picture, nao.field)
        found.append(match_feet(seen.overlays["goal posts"].pixels, feet))
        narrow.append(match_feet(own("02")["find_goalposts"](seen.overlays["labels"].result), feet))
    assert total(found).recall >= 0.7 and total(found).false <= 1
    assert total(found).hits >= 1.5 * total(narrow).hits


# --- lesson 04 ---


def test_posts_and_corners_stand_where_the_field_has_them_and_the_sky_is_left_out():
    def finding(name, pixels):
        return Stage(name, "02", (), lambda student, nao: lambda frame: Overlay(pixels, pixels=pixels))

    nao = robot(tilt=TorsoTilt(0.0, 0.0))
    nao.take_picture("bottom")
    marks = Truth(nao).picture.landmarks
    posts, corners = (
        [(mark.pixel, (mark.landmark.x, mark.landmark.y)) for mark in marks if mark.landmark.kind == kind]
        for kind in ("post", "corner")
    )
    pixels, there = (np.array(each) for each in zip(*posts, *corners, strict=True))
    stages = finding("goal posts", pixels[: len(posts)]), finding("corners", pixels[len(posts) :])
    (found,) = [look("points on the map", nao, *stages).overlays["points on the map"]]
    assert POSE.to_parent(found.points) == pytest.approx(there, abs=1e-4)
    sky = finding("goal posts", np.vstack([pixels[: len(posts)], [[100.0, 1.0]]]))
    found = look("points on the map", nao, sky).overlays["points on the map"]
    assert len(found.points) == len(posts) and found.text == "goal posts: 2.7 m, 2.4 m"


# --- lesson 05 ---


def test_the_ellipse_of_dead_reckoning_grows_and_holds_the_robot_and_an_answer_of_another_shape_is_reported():
    nao, sizes = robot(), []
    live = pipeline("dead reckoning", nao)
    for _ in range(6):
        overlay = live.process(nao.take_picture()).overlays["dead reckoning"]
        pose, covariance = overlay.result
        sizes.append(float(np.trace(covariance[:2, :2])))
        error = off(nao, pose)[:2]
        nao.walk(0.2)
        nao.turn(0.4)
    assert sizes[0] == 0.0 and np.all(np.diff(sizes) > 0)
    assert error @ np.linalg.inv(covariance[:2, :2]) @ error < 13.8  # 99.9 %
    assert overlay.estimate.pose.as_array() == pytest.approx(pose)
    nao = robot()
    live = pipeline("dead reckoning", nao, predict_pose=lambda pose, control: pose[:2])
    nao.walk(0.2)
    seen = live.process(nao.take_picture())
    assert not seen.overlays and "shape (2,)" in seen.complaints[0] and "(3,)" in seen.complaints[0]


# --- lesson 06 ---


def test_the_first_picture_shows_the_estimate_at_the_start_and_the_second_corrects_it():
    nao = robot()
    live = pipeline("pose", nao)
    seen = live.process(nao.take_picture())
    assert np.hypot(*START_ERROR[:2]) == pytest.approx(0.5)
    assert np.degrees(START_ERROR[2]) == pytest.approx(12)
    assert np.hypot(*off(nao, seen.estimate.pose.as_array())[:2]) == pytest.approx(0.5)
    assert np.array_equal(seen.estimate.covariance, START_COVARIANCE) and "start" in seen.lines()[0]
    seen = live.process(nao.take_picture())
    assert np.hypot(*off(nao, seen.estimate.pose.as_array())[:2]) < 0.2
    assert len(seen.overlays["pose"].pixels) == 3
    assert seen.lines()[0].startswith("pose: 3 landmarks, σ 0.1")
    for _ in range(4):
        nao.walk(0.2)
        nao.turn(0.1)
        seen = live.process(nao.take_picture())
    pose, covariance = seen.overlays["pose"].result
    error = off(nao, pose)
    assert np.hypot(*error[:2]) < 0.1 and error @ np.linalg.inv(covariance) @ error < 16.3  # 99.9 %


def test_without_landmarks_the_covariance_grows_and_the_panel_has_a_place_for_the_estimate_on_its_map():
    nao = robot(Pose(0.3, 0.0, np.pi))
    live = pipeline("pose", nao)
    live.process(nao.take_picture())
    first = live.process(nao.take_picture()).overlays["pose"]
    nao.walk(0.5)
    second = live.process(nao.take_picture()).overlays["pose"]
    assert first.text.startswith("0 landmarks")
    assert np.linalg.det(second.result[1]) > np.linalg.det(first.result[1])
    panel = panel_of("pose", robot())
    contents = panel._screen.contents()
    assert contents.observer == "ekf" and contents.paths["ekf"] == (contents.estimate.pose,)
    assert np.hypot(contents.estimate.pose.x - 0.6, contents.estimate.pose.y - 0.5) == pytest.approx(0.5)
    panel.view = "beside"  # as my_nao does
    assert panel._screen.contents().estimate.pose == contents.estimate.pose
    assert panel.drawing().alt.startswith("Control panel")
