"""The hundred drives of lesson 11: its text says what is recorded, and the system is as near as it has to be."""

import json

import numpy as np
import pytest

from benchmarks import RESULTS
from nao_course.lessons.slam_on_the_field.system.ways import draw_ways, recorded_ways, ways_table
from tests.paths import SOLUTIONS

WAYS = {row["way"]: row for row in recorded_ways()}
EKF, GRAPH = "compass: the whole EKF", "graph"
SUREST = "the EKF, a stop's surest compass first"


@pytest.fixture(scope="module")
def told():
    text = (SOLUTIONS / "11_slam_on_the_field.md").read_text(encoding="utf-8")
    return text.partition("## A hundred drives, from pictures")[2].partition("## My NAO")[0]


def off(way):
    return 100 * np.array(WAYS[way]["position"])


def lost(way):
    return int((off(way) > 15).sum())


def test_the_text_says_what_the_drives_recorded(told):
    for way, digits, words in (
        ("odometry", 0, "Odometry ends {} cm off"),
        ("the paper's corners and distances", 0, "the paper's way {} cm"),
        ("joint compatibility", 1, "joint compatibility {} cm are left"),
        ("tilt from lines", 1, "tilt from lines brings {},"),
        (EKF, 1, "the compass {},"),
    ):
        assert words.format(f"{np.median(off(way)):.{digits}f}") in told, way
    assert f"the heading right to {np.median(WAYS[EKF]['heading']):.1f}°" in told
    assert lost("the EKF, 0.3 false corners a picture") == 10 and "lose 10 drives" in told
    assert lost("the EKF, one look a stop") == 7 and "loses 7" in told
    saved = 7 - lost("the EKF, one look, lone ones in doubt left out")
    assert f"while the heading is in doubt saves {saved} of these" in told


def test_the_text_says_which_drives_are_lost_and_what_saves_them(told):
    assert (
        lost(EKF) == lost("the EKF, far compasses refused") == 3
        and "Three drives of a hundred are lost" in told
    )
    assert lost(SUREST) == 0 and f"the worst ends {off(SUREST).max():.0f} cm off" in told
    assert f"mean NEES is {np.mean(WAYS[SUREST]['nees']):.1f}" in told


def test_the_text_says_what_the_order_is_worth_on_drives_it_was_not_found_on(told):
    others = json.loads((RESULTS / "field_slam.json").read_text(encoding="utf-8"))["others"]
    usual, surest = others[EKF], others[SUREST]
    lost_by_the_usual_order = round(usual["lost"] * usual["drives"])
    assert (
        surest["lost"] == 0
        and (
            f"On {surest['drives']} others that nothing was tuned on the usual order loses {lost_by_the_usual_order}"
            " and this one none"
        )
        in told
    )
    off_at_most = (
        f"the worst {100 * surest['position worst']:.0f} cm, with a mean NEES of {surest['NEES mean']:.1f}"
    )
    assert f"ends {100 * surest['position']:.1f} cm off, {off_at_most}" in told


def test_the_text_says_what_a_posts_thickness_is_worth(told):
    at_most = [np.quantile(off(way), 0.95) for way in ("the EKF, a post's foot to a pixel", EKF)]
    assert "more than {:.1f} cm off, with them {:.1f}".format(*at_most) in told


def test_the_system_is_as_near_as_it_has_to_be():
    for way in (EKF, GRAPH):
        row = WAYS[way]
        assert len(row["position"]) == 100
        assert np.median(row["position"]) < 0.02 and np.median(row["heading"]) < 0.3
        assert np.median(row["landmarks"]) < 0.011 and 1.5 < np.median(row["nees"]) < 3
    assert np.quantile(WAYS[SUREST]["position"], 0.95) < 0.06


def test_figure_and_table_have_all_of_it():
    assert f"graph: {np.median(off(GRAPH)):.1f} cm" in draw_ways().alt
    assert len(ways_table().rows) == len(WAYS)
