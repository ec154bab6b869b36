"""The hundred drives of lesson 11: its text states what is recorded, and the system is as accurate as required."""

import json

import numpy as np
import pytest

from benchmarks import RESULTS
from nao_course.lessons.slam_on_the_field import variants
from tests.lessons.every import quotes
from tests.lessons.every import text as text_of

VARIANTS = {row["variant"]: row for row in variants.recorded_variants()}
EKF, GRAPH = "compass: the complete EKF", "graph"
SUREST, SUREST_GRAPH = "EKF, best compass of a stop first", "graph, best compass of a stop first"
FALSE_CORNERS, TAILS = (
    json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))["conditions"]
    for name in ("field_false", "field_tails")
)
NORMAL, ONE_PICTURE, WORSE = "0", "one picture per stop", "odometry twice as bad as stated"


@pytest.fixture(scope="module")
def text():
    whole = text_of("11")
    hundred = whole.partition("### A hundred drives, from pictures")[2].partition("### On a real field")[0]
    return hundred + whole.partition("## For readers of the paper")[2].partition("## What you have")[0]


def off(variant):
    return 100 * np.array(VARIANTS[variant]["position"])


def of_hard_drives(hardship, algorithm="several hypotheses"):
    return (FALSE_CORNERS | TAILS)[f"{hardship}, {algorithm}"]


def lost_of(hardship, algorithm):
    row = of_hard_drives(hardship, algorithm)
    return round(row["lost"] * row["drives"])


def lost(variant):
    return int((off(variant) > 15).sum())


def result(name):
    return json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))


def test_the_text_says_what_the_drives_recorded_and_which_is_lost(text):
    low, high = result("field_slam")["NEES band"]
    quotes(
        text,
        *(f"{np.median(off(name)):.0f} cm" for name in ("odometry", "the paper's corners and distances")),
        *(f"{np.median(off(name)):.1f} cm" for name in ("joint compatibility", "tilt from lines", EKF)),
        f"{np.median(VARIANTS[EKF]['heading']):.1f}°",
        f"NEES of {max(VARIANTS[EKF]['nees']):.0f}",
        f"{off(SUREST).max():.0f} cm off",
        f"NEES is {np.mean(VARIANTS[SUREST]['nees']):.1f}",
        f"between {low:.1f} and {high:.1f}",
        *(f"{np.quantile(off(each), 0.95):.1f} cm" for each in ("EKF, posts without the extra 2 cm", EKF)),
    )
    assert lost(EKF) == 1 and lost(SUREST) == 0 and np.mean(VARIANTS[SUREST]["nees"]) < low


def test_the_text_says_what_the_joint_update_and_several_hypotheses_bring(text):
    row = of_hard_drives(NORMAL)
    low, high = result("field_false")["NEES band"]
    pairs = [
        f"{lost_of(name, 'surest first')} and {lost_of(name, 'several hypotheses')} with"
        for name in (ONE_PICTURE, WORSE)
    ]
    quotes(
        text,
        f"{100 * row['position']:.1f} cm off",
        f"{100 * row['position worst']:.0f} cm",
        f"NEES is {row['NEES mean']:.1f}",
        f"{low:.1f} and {high:.1f}",
        f"{100 * row['outside']:.0f} % end outside",
        *pairs,
        f"{100 * of_hard_drives(ONE_PICTURE)['position']:.1f} cm off",
    )
    assert row["drives"] == 200 and low < row["NEES mean"] < high and row["outside"] <= 0.07


def test_the_text_says_what_the_order_is_worth_and_what_short_pieces_do_to_the_compass(text):
    usual, surest = (result("field_slam")["others"][name] for name in (EKF, SUREST))
    compass = result("compass")
    long = [
        compass["readings"][name]["mean square over variance"] for name in ("all pieces", "from 30 cm on")
    ]
    quotes(
        text,
        f"loses {round(usual['lost'] * usual['drives'])} drives",
        f"{100 * surest['position']:.1f} cm",
        f"{100 * surest['position worst']:.0f} cm",
        f"NEES {surest['NEES mean']:.1f}",
        *(f"{each:.1f}" for each in long),
    )
    short = [row for name, row in compass["lines"].items() if float(name.split()[2]) <= 0.3]
    share = sum(row["lines"] * row["none"] for row in short) / sum(row["lines"] for row in short)
    assert surest["lost"] == 0 and len(short) == 3 and 0.6 < share < 0.7  # two in three
    all_pieces, without = (
        compass["drives"][f"{name}, surest first"]["position"] for name in ("all pieces", "from 30 cm on")
    )
    assert without - all_pieces == pytest.approx(1e-3, abs=5e-4)  # a millimetre


def test_the_system_is_as_near_as_it_has_to_be():
    for variant in (SUREST, SUREST_GRAPH):
        row = VARIANTS[variant]
        assert len(row["position"]) == 100
        assert np.median(off(variant)) <= 2 and np.quantile(off(variant), 0.95) <= 5
        assert off(variant).max() <= 15
        assert np.median(row["heading"]) <= 0.3 and np.median(row["landmarks"]) <= 0.01
        assert 2 <= np.mean(row["nees"]) <= 4
    for name, most in ((NORMAL, 0), ("0.3", 0), ("1", 1), ("2", 5), ("3", 5), (WORSE, 0)):
        row = of_hard_drives(name)
        assert row["position"] <= 0.01 and row["position 95 %"] <= 0.05
        assert lost_of(name, "several hypotheses") <= most


def test_figure_and_table_have_all_of_it_and_the_text_says_how_many_kidnapped_robots_find_their_pose():
    assert f"graph: {np.median(off(GRAPH)):.1f} cm" in variants.draw_variants().alt
    rows = variants.variants_table().rows
    assert len(rows) == len(VARIANTS) - variants.COMPLETE and rows[0][0] == EKF
    assert not any("e+" in cell or "more than" in cell for row in rows for cell in row)
    assert len(VARIANTS) == len(variants.recorded_variants())
    recorded = json.loads((RESULTS / "kidnapping.json").read_text(encoding="utf-8"))
    found, ordinary = recorded["kidnapped"], recorded["ordinary"]
    ending = text_of("11").partition("## What you have")[2]
    back, drives = found["both, and no alarm before"], found["drives"]
    assert f"is within 5 cm again after seven stops in {back} of {drives} drives" in ending
    assert (ordinary["false alarms"], ordinary["drives"]) == (0, 300)
    assert "with no false alarm in 300 others" in ending
