"""Drives and detectors on fields that are not the field of 2012."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from typer.testing import CliRunner

from nao_course.cli import app
from nao_course.field_slam.demo import drive, report
from nao_course.field_slam.drives import INSIDE, Driver, inside, start_of
from nao_course.field_slam.known_shapes.circle import find_circle
from nao_course.field_slam.known_shapes.white_posts import as_goal_colour
from nao_course.field_slam.lines import read_lines
from nao_course.geometry import Pose
from nao_course.instructor.authoring.plans import load_solution
from nao_course.sim import DIMENSIONS, NAO_V4, Field, Reality, render
from nao_course.sim.fields import SHIPPED
from nao_course.slam import DeadReckoning
from tests.paths import SOLUTIONS

VIEW = NAO_V4.view("bottom", 0.0, np.radians(-31))
RULES, LAB = DIMENSIONS[2025], Field.from_toml("lab")
OTHER, GREEN, GOAL, WHITE = range(4)


@cache
def solutions():
    """Return the functions that the demo uses, with a filter that only adds up the commanded motions."""
    uses = drive.USES
    names = {"01_hsl_filtering": uses[:2], "02_goalposts": uses[2:3], "11_slam_on_the_field": uses[3:]}
    found = {}
    for lesson, uses in names.items():
        solution = load_solution(SOLUTIONS / f"{lesson}.ipynb")
        found |= {use.partition(":")[2]: solution[use.partition(":")[2]] for use in uses}
    return found | {"EkfSlam": lambda start, *_: DeadReckoning(start)}


def test_the_area_of_a_drive_ends_inside_the_lines_and_the_circle_is_found_by_its_own_radius():
    assert INSIDE == ((0.25, -1.75), (2.75, 1.75))
    assert inside(LAB) == ((-2.0, -1.25), (2.0, 1.25))
    small = replace(LAB.dimensions, length=3.9)
    inside(Field(small, half=False))
    with pytest.raises(ValueError, match=r"at least 2 x 2 m between its lines, got 1\.95 x 3 m"):
        inside(Field(small))
    pose = Pose(1.3, 0.1, np.pi)
    picture, _ = render(LAB, pose, VIEW, Reality.clean())
    lines = read_lines(picture, VIEW)
    circle = find_circle(lines, VIEW, LAB.dimensions.circle_diameter / 2)
    assert circle is not None
    assert circle.centre == pytest.approx(pose.to_local([0.0, 0.0])[0], abs=0.03)
    assert find_circle(lines, VIEW, 0.0) is None


@pytest.mark.parametrize("name", SHIPPED)
def test_a_drive_stays_inside_the_lines_of_every_field_and_reaches_its_ends(name):
    field = Field.from_toml(name)
    (x0, x1), (y0, y1) = field.x_range, field.y_range
    path = []
    for seed in range(8):
        pose, driver = start_of(seed, field), Driver(np.random.default_rng([seed, 13]), inside(field))
        for _ in range(60):
            path.append(pose.as_array()[:2])
            pose = pose @ driver.next(pose).as_pose()
    low, high = np.min(path, axis=0), np.max(path, axis=0)
    assert x0 < low[0] < x0 + 1.0 and x1 > high[0] > x1 - 1.0
    assert y0 < low[1] < y0 + 1.0 and y1 > high[1] > y1 - 1.0


@pytest.mark.parametrize(("width", "found"), [(0.05, True), (0.01, False)])
def test_what_is_wider_than_the_fields_lines_is_no_line(width, found):
    picture, _ = render(LAB, Pose(0.0, -1.4, np.pi / 2), VIEW, Reality.clean())
    lines = read_lines(picture, VIEW, width)
    upright = np.abs(lines[:, 2] - lines[:, 0]) < 0.2 * np.abs(lines[:, 3] - lines[:, 1])  # the halfway line
    assert upright.any() == found


def pictures_with_posts():
    """Yield labels of clean pictures towards a goal of 2025, with the columns and rows of the posts' feet."""
    field = Field(2025)
    for x, y, turn in ((2.5, 0.2, 0.0), (3.0, -1.2, 0.3), (1.5, 0.6, -0.2), (3.3, 0.5, -0.3)):
        _, truth = render(field, Pose(x, y, turn), VIEW, Reality.clean())
        feet = [mark.pixel for mark in truth.landmarks if mark.landmark.kind == "post"]
        yield truth.labels, np.array(feet)


def test_white_posts_get_the_goals_label_and_lines_and_the_bar_keep_theirs():
    counted = 0
    for labels, feet in pictures_with_posts():
        marked = as_goal_colour(labels, VIEW, RULES)
        assert (labels[marked == GOAL] == WHITE).mean() > 0.98
        assert (marked == labels)[marked != GOAL].all()
        found = solutions()["find_goalposts"](marked)
        inside_picture = feet[(feet[:, 0] > 12) & (feet[:, 0] < 308)]
        for foot in inside_picture:
            assert np.linalg.norm(found - foot, axis=1).min() < 8
        assert len(found) <= len(feet)
        counted += len(inside_picture)
    assert counted >= 5


def test_yellow_things_are_no_posts_on_a_field_with_white_goals_nor_white_ones_without_a_horizon():
    labels, _ = next(pictures_with_posts())
    yellow = np.where(labels == WHITE, GOAL, labels).astype(np.uint8)
    assert not (as_goal_colour(yellow, VIEW, RULES) == GOAL).any()
    down = NAO_V4.view("bottom", 0.0, 0.0)
    assert not (as_goal_colour(labels, down, RULES) == GOAL).any()


def strip(foot, wide, carpet_until):
    """Return labels of an upright white strip that ends on a row, before a carpet that ends on another row."""
    labels = np.zeros((240, 320), np.uint8)
    labels[carpet_until:] = GREEN
    labels[:foot, 160 : 160 + wide] = WHITE
    return labels


@pytest.mark.parametrize(
    ("foot", "wide", "carpet_until", "is_post"),
    [
        (140, 13, 110, True),
        (140, 40, 110, False),  # a white board: too wide for its distance
        (140, 2, 110, False),  # the leg of a chair: too narrow
        (110, 7, 109, False),  # a white wall strip, which ends where the carpet ends
        (70, 5, 60, False),  # it ends above the horizon
    ],
)
def test_only_what_is_as_wide_as_a_post_and_stands_on_the_carpet_is_a_post(foot, wide, carpet_until, is_post):
    marked = as_goal_colour(strip(foot, wide, carpet_until), VIEW, RULES)
    assert (marked == GOAL).any() == is_post


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kinds"), [("2013", {"corner", "post"}), ("2025", {"corner", "post"}), ("lab", {"corner"})]
)
def test_the_demo_measures_what_a_field_has(name, kinds):
    field = Field.from_toml(name)
    frames = list(drive.simulated(4, 1, replace(field, half=True)))
    story = drive.run_demo(solutions(), frames, ["ekf"], rules=field.dimensions)
    assert {each.kind for seen in story.seen for each in seen} == kinds


def test_the_demo_says_what_differs_on_a_field_and_looks_for_posts_only_where_there_are_goals():
    def fail(*given):
        raise AssertionError("called")

    pixels = np.zeros((240, 320, 3), np.uint8)
    functions = solutions() | {"find_goalposts": fail}
    assert len(drive.see(functions, pixels, VIEW, rules=LAB.dimensions)) == 0
    with pytest.raises(AssertionError, match="called"):
        drive.see(functions, pixels, VIEW)
    assert report.field_in_words(Field(2012)) == []
    assert "white" in report.field_in_words(Field(2025))[0]
    assert "no goals" in report.field_in_words(LAB)[0]


@pytest.mark.slow
def test_the_command_refuses_a_field_that_is_not_there_and_a_field_for_a_real_walk(tmp_path):
    for given, message in (
        (["--field", str(tmp_path / "none.toml")], "none.toml: the field cannot be read"),
        (["--field", "lab", "--walk", str(tmp_path)], "--field is for simulated drives"),
    ):
        result = CliRunner().invoke(app, ["demo", "--out", str(tmp_path / "out"), *given])
        assert result.exit_code == 1
        assert message in " ".join(result.output.split()).replace("- ", "-")
