"""Figures, room and drivers of lesson 11, and its challenge."""

import json

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.slam_on_the_field import RoomPanel, figures
from nao_course.lessons.slam_on_the_field.associating import shares
from nao_course.lessons.slam_on_the_field.challenge import judge, make_case
from nao_course.lessons.slam_on_the_field.drivers import on_taken_picture, taken_from, whole_numbers
from nao_course.lessons.slam_on_the_field.figures import draw_drives, draw_measurements, draw_one_tilt
from nao_course.lessons.slam_on_the_field.ideas import RECORDED, draw_ideas
from nao_course.lessons.slam_on_the_field.one_drive import the_drive
from nao_course.lessons.slam_on_the_field.panel import draw_problem
from nao_course.lessons.slam_on_the_field.worlds import LANDMARKS, association_problem
from nao_course.slam import DeadReckoning
from tests.lessons.every import text


def test_the_figure_of_one_tilt_states_its_correlation_and_right_and_wrong_associations_are_counted():
    assert "correlation is 0.9" in draw_one_tilt().alt
    each = association_problem(4, 0.1, 0.1)
    wrong = list(each.origins)
    wrong[0] = -1
    assert each.right(each.origins) == len(each.origins) and each.right(wrong) == len(each.origins) - 1
    said = f"{len(each.origins) - 1} of them are matched with the right landmark"
    assert said in draw_problem(each, np.array(wrong)).alt
    with pytest.raises(ValueError, match="need as many numbers"):
        shares(lambda *given: [0], [association_problem(4, 0.1, 0.1)])


def test_answers_that_are_no_measurements_are_rejected_in_words():
    for answer in (None, [(0.1, 1.0)]):
        with pytest.raises(TypeError, match="measure must return a list of Measurement"):
            draw_measurements(lambda picture, view, answer=answer: answer)


def test_the_payoff_is_what_the_pictures_show(monkeypatch):
    """Who measures nothing knows no more than odometry: nothing but `measure` tells where landmarks are."""
    monkeypatch.setattr(figures, "PAYOFF_MOVES", 1)
    looked = []

    class Blind(DeadReckoning):
        def __init__(self, start, odometry):
            super().__init__(start)

    drawing = draw_drives(lambda picture, view: looked.append(picture.shape) or [], Blind, Blind)
    assert looked == [(240, 320, 3)] * 6
    assert "map has 0 landmarks" in drawing.alt


def test_the_ideas_say_where_a_better_noise_alone_is_worse():
    """What the lesson's text says of its figure, held against the recorded numbers."""
    rows = {row["idea"]: row for row in json.loads(RECORDED.read_text(encoding="utf-8"))}
    constant, whole, jointly = (rows[name] for name in ("constant R", "the whole R", "the whole R, jointly"))
    assert np.median(whole["nees"]) > 10 * np.median(constant["nees"])
    assert max(whole["off"]) > 3 * max(constant["off"])
    words, tilt = text("11"), rows["tilt in R"]
    before, after = (100 * np.median(row["off"]) for row in (constant, tilt))
    assert f"lowers the median error from {before:.1f} to {after:.1f} cm" in words
    ends = [f"{100 * max(row['off']):.0f} cm" for row in (tilt, constant)]
    assert f"the worst drive ends {ends[0]} off instead of {ends[1]}" in words
    assert np.median(jointly["off"]) < np.median(constant["off"]) / 2
    assert all(0.03 < rows[name]["wrong"] < 0.07 for name in ("constant R", "tilt in R", "the whole R"))
    assert jointly["wrong"] < 0.01 < 0.03 < rows["constant R, jointly"]["wrong"]
    assert "constant R, jointly" in draw_ideas().alt


def test_a_picture_is_taken_where_it_is_asked_for():
    picture = taken_from(Pose(0.6, 0.5, -0.25), 0.0)
    assert on_taken_picture(lambda pixels, view: (pixels.shape, view.size), Pose(0.6, 0.5, -0.25), 0.0) == (
        picture.pixels.shape,
        (320, 240),
    )
    darker = taken_from(Pose(0.6, 0.5, -0.25), 0.0, 0.5)
    assert darker.pixels.mean() == pytest.approx(picture.pixels.mean() / 2, abs=1)


def test_the_filter_drives_beside_the_true_robot(own):
    panel = RoomPanel(own["EkfSlam"])
    last = len(the_drive().log) - 1
    panel.set(step=last)
    contents = panel.world.contents
    assert contents.truth.as_array() == pytest.approx(the_drive().poses[last])
    apart = np.hypot(*(contents.estimate.pose.as_array() - contents.truth.as_array())[:2])
    assert apart < 0.1 and f"Off by {100 * apart:.0f} cm" in panel.summary()
    assert [len(contents.paths[source]) for source in ("truth", "ekf")] == [last + 1] * 2
    ends = {
        source: [ray.point[:2] for ray in contents.rays if ray.source == source]
        for source in ("truth", "ekf")
    }
    assert len(ends["truth"]) == len(ends["ekf"]) > 0
    for end in ends["truth"]:
        assert np.linalg.norm(LANDMARKS - end, axis=1).min() < 1e-9
    # Each measurement lies within a metre of one of the landmarks.
    for end in ends["ekf"]:
        assert np.linalg.norm(LANDMARKS - end, axis=1).min() < 1.0


@pytest.mark.parametrize(
    "answer", [np.array([0, -1]), np.array([2], dtype=np.int32), np.zeros(0), np.zeros((0, 1))]
)
def test_integers_and_empty_answers_are_right_and_floats_are_rejected(answer):
    assert whole_numbers((), {}, answer) == "" and "floats" in whole_numbers((), {}, np.array([0.0, -1.0]))


def test_odometry_is_worth_nothing_and_an_overconfident_winner_loses():
    case = make_case(2)
    assert judge((case.odometry, case.odometry_covariance), case).score == pytest.approx(0.0, abs=1e-6)
    near = case.drive.poses[-1] + (0.03, 0.0, 0.0)
    consistent, overconfident = judge((near, 0.001 * np.eye(3)), case), judge((near, 1e-7 * np.eye(3)), case)
    assert consistent.score > 3 and overconfident.score < 0
