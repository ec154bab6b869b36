"""The numbers in the text of lesson 12: measured numbers are as recorded, and computed numbers are right."""

import json
import re
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.geometry import wrap_angle
from nao_course.lessons.beyond import recorded as figures_of
from nao_course.lessons.beyond.challenge import CHALLENGE
from nao_course.lessons.beyond.exploring import anywhere_known, explore, nearest_frontier
from nao_course.lessons.beyond.figures import FOUND, LOST_SEED, LOST_SHOWN, lap
from nao_course.lessons.beyond.particles import anywhere, find_itself
from nao_course.lessons.beyond.stage import MOST_SIGMA, RETURN
from tests.lessons.every import executed, quotes, text
from tests.paths import PROJECT

TEXT = text("12")


def section(heading):
    return re.split(r"^##+ ", TEXT.partition(f"# {heading}\n")[2], maxsplit=1, flags=re.MULTILINE)[0]


def recorded(name):
    path = PROJECT / "benchmarks" / "results" / f"beyond_{name}.json"
    found = json.loads(path.read_text(encoding="utf-8"))
    assert found == figures_of.read(getattr(figures_of, name.upper())), "the figures show another recording"
    return found


def test_the_text_says_what_was_measured_of_particles_rooms_and_moves():
    measured = recorded("particles")
    rows = {row["particles"]: row for row in measured["rows"]}
    off = {n: f"{100 * row['error'][150]:.1f} cm" for n, row in rows.items()}
    nees = {n: row["nees"][150] for n, row in rows.items()}
    quotes(
        section("Thirty moves in a circle"),
        *(f"{rows[n]['ancestors'].index(1)} moves" for n in (100, 1000)),
        f"| Kalman filter | {off[None]} | {nees[None]:.1f} |",
        f"| 10 particles | {off[10]} | above 100 |",
        *(f"| {n} particles | {off[n]} | {nees[n]:.0f} |" for n in (100, 300, 1000)),
        f"{rows[300]['nees'][10]:.1f} after ten moves",
        "fifty",
    )
    low, high = measured["band"]
    assert measured["drives"] == 30 and len(rows[None]["error"]) == 151 and nees[10] > 100
    assert low < rows[300]["nees"][10] < high and low < nees[None] < high
    assert high < min(nees[n] for n in (10, 100, 300, 1000))
    assert 35 < rows[100]["ms"] / rows[None]["ms"] < 65  # about fifty times as long
    rooms, ways = recorded("exploring"), ("nearest frontier", "at random", "lanes")
    known = [100 * np.array(rooms["variants"][way]["quartiles"][1]) for way in ways]
    after = [f"{each[moves]:.0f} %" for moves in (30, 60) for each in known]
    quotes(section("Exercise 12.6 (three stars)"), *after)
    assert rooms["rooms"] == 30
    moves = recorded("moves")
    variants = moves["variants"]
    names = ("smallest variance", "at random", "in a circle", "along the edge")
    chosen, chance, circle, edge = (
        [100 * np.median(variants[name][key]) for key in ("sigma", "error")] for name in names
    )
    saved, low, high = (f"{100 * each:.0f}" for each in moves["saved"])
    nees = np.mean(variants["smallest variance"]["nees"])
    half_way = 100 * np.array(variants["in a circle"]["sigmas"])[:, 1].max()
    quotes(
        section("The most informative move") + section("Exercise 12.7 (three stars)"),
        *(f"{each:.1f} cm" for each in (*chosen, *chance, circle[0])),
        f"{saved} % smaller (95 % interval from {low} to {high} %)",
        f"NEES is {nees:.1f}",
        f"{edge[0]:.0f} cm",
        f"{half_way:.0f} cm",
    )
    low, high = moves["band"]
    assert moves["drives"] == 30 and low < nees < high
    assert 1 - chosen[0] / chance[0] >= 0.25  # asked of the course
    back = recorded("moves")["back"]
    chosen, chance = (
        [np.median(back[name][key]) for key in ("sigma", "error")]
        for name in ("smallest variance", "at random")
    )
    twelve = np.median(back["at random"]["sigma"][:12])
    quotes(section("With its back to the goal"), *(f"{each:.2f} m" for each in (twelve, *chosen, *chance)))
    assert chosen[0] > chance[0] and chosen[1] > chance[1]
    assert np.mean(back["smallest variance"]["nees"]) > 10


def test_the_text_says_what_two_cameras_measured():
    rows = recorded("cameras")["rows"]
    at_two = {row["width"]: row for row in rows if row["distance"] == 2}
    (one,) = {f"{row['one']:.2f} m" for row in at_two.values()}
    both = [f"{at_two[width]['both']:.2f} m at {width}x{width * 3 // 4}" for width in (320, 640, 1280)]
    quotes(section("When are two cameras better?"), one, *both, f"{100 * at_two[320]['both']:.0f} cm at 2 m")
    # The answer to the question `when_both_pay`: no r in it
    ratios = {row["one"] / row["both"] for row in rows if row["width"] == 320}
    assert min(ratios) > 0.85 and max(ratios) < 1.0
    assert round(at_two[1280]["one"] / at_two[1280]["both"]) == 4


def test_the_text_says_by_how_much_an_entry_leads_the_next_and_at_which_limit_the_robot_returns():
    cases = {row.name: row.cases for row in CHALLENGE.rows}
    names = ("a better one", "the reference", "the paper's way, a fixed plan")
    for above, below in pairwise(names):
        lead = np.subtract(cases[above], cases[below])
        most = 2.093 * lead.std(ddof=1) / np.sqrt(20)  # Student's t for twenty robots
        assert f" {lead.mean() - most:.0f} to {lead.mean() + most:.0f} bits" in section("The challenge")
    told = section("My NAO, by itself")
    assert f"standard deviation of its position exceeds {100 * MOST_SIGMA:.0f} cm" in told
    assert "a metre" in told and round(RETURN) == 1


@pytest.mark.parametrize(
    ("q", "teeth", "kept"),
    [(0.6, "0.2, 0.533 and 0.867", [0, 1, 2]), (0.15, "0.05, 0.383 and 0.717", [0, 0, 2])],
)
def test_the_combs_of_the_worked_example_keep_what_the_text_says(own, q, teeth, kept):
    assert re.search(rf"With \$q = {q}\$ (the teeth|they) are at {teeth}", TEXT)
    at = [float(each) for each in re.findall(r"[\d.]+", teeth)]
    assert at == pytest.approx((q + np.arange(3)) / 3, abs=5e-4)
    shift = SimpleNamespace(random=lambda: q)
    assert list(own["resample"](np.array([0.5, 0.1, 0.4]), shift)) == kept
    assert "is lost in 37 % of all cases" in TEXT and round(100 * (1 - 1 / 2000) ** 2000) == 37


def test_the_worked_weight_landmark_and_rays_are_those_of_the_solution(own):
    log = own["weigh"](np.zeros((1, 3)), np.array([2.0, 0.0]), np.array([0.02, 2.1]), np.diag([0.0004, 0.01]))
    assert f"$\\log w = -1 + 4.377 = {log[0]:.3f}$" in TEXT
    mean, covariance, log = own["update_particle_landmark"](
        np.zeros(3), np.array([2.0, 0.0]), 0.03 * np.eye(2), np.array([0.0, 2.2]), np.diag([0.0025, 0.01])
    )
    assert np.allclose(mean, [2.15, 0]) and np.allclose(covariance, 0.0075 * np.eye(2))
    assert f"-0.5 + 2.074 = {log:.3f}$" in TEXT and f"diag(0.0075, 0.0075) and {log:.3f}." in TEXT
    rays = ((0.0, 0.0, 1.0), (0.8, 0.0, -0.6), (0.0, 0.2, 0.0), (1.0, 0.0, 0.0))
    point, gap = own["intersect_rays"](*map(np.array, rays))
    assert np.allclose(point, [4 / 3, 0.1, 0]) and np.isclose(gap, 0.2)
    assert "The closest points are $(1.333, 0, 0)$ and $(1.333, 0.2, 0)$, 0.2 m apart" in TEXT


def test_two_or_three_of_two_thousand_particles_begin_near_the_truth_but_none_of_the_lessons(own):
    many = anywhere(400_000, np.random.default_rng(0))
    width, height, turn = np.ptp(many, axis=0)
    assert f"{width:.1f} m by {height:.1f} m, or {width * height:.0f} m²" in TEXT and turn > 6.28
    near = (np.hypot(many[:, 0] - 1.4, many[:, 1] + 0.8) < 0.3) & (np.abs(many[:, 2]) < np.radians(10))
    assert 2 < 2000 * near.mean() < 3.5
    steps = lap(LOST_SEED, max(LOST_SHOWN) - 1)
    clouds = find_itself(own["weigh"], own["resample"], steps, np.random.default_rng(LOST_SEED), 2000)
    away = clouds[0] - steps[0].pose
    turned = np.abs(wrap_angle(away[:, 2]))
    assert not ((np.hypot(away[:, 0], away[:, 1]) < FOUND) & (turned < np.radians(10))).any()
    off = np.hypot(*(clouds[3] - steps[2].pose)[:, :2].T)
    assert off.min() > FOUND and 0.4 < np.median(off) < 0.6
    assert "no particle started within 30 cm and 10 degrees" in TEXT


@pytest.mark.slow
def test_the_text_says_how_often_particles_find_the_robot(own):
    steps = lap(LOST_SEED, max(LOST_SHOWN) - 1)

    def found(n):
        ends = (
            find_itself(own["weigh"], own["resample"], steps, np.random.default_rng(seed), n)[-1]
            for seed in range(20)
        )
        return sum(np.median(np.hypot(*(end[:, :2] - steps[-1].pose[:2]).T)) < FOUND for end in ends)

    assert [found(n) for n in (2000, 500, 5000)] == [18, 16, 20]
    assert "18 find the robot; with 500 particles 16 do, and with 5000 all twenty" in TEXT
    assert "13 of 40 end within 30 cm of the robot" in TEXT  # counted in test_figures.py


def drawn(heading):
    """Return the grids of a section's drawing, each as rows of its signs."""
    rows = [
        re.split(r" {3,}", line)
        for line in re.search(r"```text\n(.*?)```", section(heading), re.DOTALL)[1].splitlines()
    ]
    return [np.array([row[i].split() for row in rows]) for i in range(len(rows[0]))]


def test_the_drawn_frontiers_and_steps_are_those_of_the_solution_and_the_first_picture_says_its_numbers(own):
    plain, marked = drawn("Where nobody has looked")
    grid = np.select([plain == "?", plain == "#"], [-1, 1], 0)
    assert np.array_equal(np.asarray(own["find_frontiers"](grid)), marked == "F")
    assert np.array_equal(plain[marked != "F"], marked[marked != "F"])
    (steps,) = drawn("Exercise 12.5 (two stars)")
    found = np.asarray(own["travel_steps"](grid == 0, (1, 1)))
    assert [int(each) for each in steps[grid == 0]] == found[grid == 0].tolist()
    assert np.array_equal(steps[grid != 0], plain[grid != 0])
    (cell,) = [each for each in executed("12_beyond").cells if "check.payoff(" in each.source]
    told = re.search(r"!\[([^\]]+)\]\(images/12_payoff.png\)", TEXT)[1]
    said = re.findall(r"(\d\.\d+) m", cell.outputs[0].data["text/plain"])
    wanted = [round(100 * float(each)) for each in said]
    assert [int(each) for each in re.findall(r"(\d+) cm", told)] == wanted


@pytest.mark.slow
@pytest.mark.parametrize(("moves", "ahead"), [(20, {5, 7, 8}), (60, set())])
def test_chance_is_ahead_of_the_nearest_frontier_in_the_rooms_that_the_text_names(own, moves, ahead):
    def known(choose, room):
        *_, last = explore(own["travel_steps"], choose, room, moves + 1)
        return last.part

    found = {
        room
        for room in range(10)
        if known(anywhere_known(np.random.default_rng([room, 32])), room)
        > known(nearest_frontier(own["find_frontiers"]), room)
    }
    assert found == ahead
    assert "After 20 moves, in three of the ten rooms (5, 7 and 8); after 60 moves, in none." in TEXT
