"""The hundred drives of lesson 11: its text states what is recorded, and the system is as accurate as required."""

import json

import numpy as np
import pytest
from scipy.stats import chi2

from benchmarks import RESULTS
from nao_course.lessons.slam_on_the_field.variants import (
    COMPLETE,
    draw_variants,
    recorded_variants,
    variants_table,
)
from tests.paths import SOLUTIONS

VARIANTS = {row["variant"]: row for row in recorded_variants()}
EKF, GRAPH = "compass: the complete EKF", "graph"
SUREST, SUREST_GRAPH = "EKF, best compass of a stop first", "graph, best compass of a stop first"
TAILS = json.loads((RESULTS / "field_tails.json").read_text(encoding="utf-8"))["conditions"]
NORMAL, ONE_PICTURE = "normal", "one picture per stop"
FALSE_CORNERS, WORSE = "0.3 false corners per picture", "odometry twice as bad as stated"


@pytest.fixture(scope="module")
def text():
    whole = (SOLUTIONS / "11_slam_on_the_field.md").read_text(encoding="utf-8")
    hundred = whole.partition("### A hundred drives, from pictures")[2].partition("### On a real field")[0]
    return hundred + whole.partition("## For readers of the paper")[2].partition("## What you have")[0]


def off(variant):
    return 100 * np.array(VARIANTS[variant]["position"])


def of_hard_drives(hardship, algorithm="several hypotheses"):
    return TAILS[f"{hardship}, {algorithm}"]


def lost_of(hardship, algorithm):
    row = of_hard_drives(hardship, algorithm)
    return round(row["lost"] * row["drives"])


def lost(variant):
    return int((off(variant) > 15).sum())


def test_the_text_says_what_the_drives_recorded(text):
    for variant, digits, words in (
        ("odometry", 0, "The median error at the end is {} cm with odometry"),
        ("the paper's corners and distances", 0, "and {} cm with the paper's corners and distances"),
        ("joint compatibility", 1, "Joint compatibility brings the error down to {} cm"),
        ("tilt from lines", 1, "tilt from lines to {} cm"),
        (EKF, 1, "the compass to {} cm"),
    ):
        assert words.format(f"{np.median(off(variant)):.{digits}f}") in text, variant
    assert f"a heading error of {np.median(VARIANTS[EKF]['heading']):.1f}°" in text


def test_the_text_says_which_drive_is_lost_and_what_saves_it(text):
    assert lost(EKF) == 1 and "One drive of a hundred is still lost (more than 15 cm off)" in text
    assert f"a NEES of {max(VARIANTS[EKF]['nees']):.0f}" in text
    assert lost(SUREST) == 0 and f"the worst drive ends {off(SUREST).max():.0f} cm off" in text
    assert f"mean NEES is {np.mean(VARIANTS[SUREST]['nees']):.1f}" in text
    low, high = json.loads((RESULTS / "field_slam.json").read_text(encoding="utf-8"))["NEES band"]
    assert f"between {low:.1f} and {high:.1f}, so this filter is slightly too cautious" in text
    assert np.mean(VARIANTS[SUREST]["nees"]) < low


def test_the_text_says_what_the_joint_update_and_several_hypotheses_bring(text):
    row = of_hard_drives(NORMAL)
    assert row["drives"] == 200
    assert (
        f"ends {100 * row['position']:.1f} cm off (median), and the worst of 200 fresh drives "
        f"{100 * row['position worst']:.0f} cm"
    ) in text
    low, high = json.loads((RESULTS / "field_tails.json").read_text(encoding="utf-8"))["NEES band"]
    said = f"Its mean NEES is {row['NEES mean']:.1f}, although for consistent drives it would lie between"
    assert f"{said} {low:.1f} and {high:.1f}" in text
    assert row["NEES mean"] > high
    assert f"the median, {row['NEES median']:.1f}, is near its expected {chi2.median(3):.1f}" in text
    words = {
        ONE_PICTURE: "with one picture at each stop",
        FALSE_CORNERS: "with 0.3 false corners in each picture",
        WORSE: "with odometry that is twice as bad as stated",
    }
    for hardship, said in words.items():
        alone, many = lost_of(hardship, "surest first"), lost_of(hardship, "several hypotheses")
        assert f"{alone} and {many} {said}" in text, hardship
    middle = 100 * of_hard_drives(ONE_PICTURE)["position"]
    assert f"With one picture it ends {middle:.1f} cm off" in text


def test_the_text_says_what_the_order_is_worth_on_the_drives_that_were_looked_at(text):
    others = json.loads((RESULTS / "field_slam.json").read_text(encoding="utf-8"))["others"]
    usual, surest = others[EKF], others[SUREST]
    assert surest["lost"] == 0
    assert (
        f"the usual order loses {round(usual['lost'] * usual['drives'])} drives and this order none" in text
    )
    at_most = (
        f"the worst {100 * surest['position worst']:.0f} cm, and the mean NEES {surest['NEES mean']:.1f}"
    )
    assert f"the median error is {100 * surest['position']:.1f} cm, {at_most}" in text


def test_the_text_says_what_short_pieces_do_to_the_compass(text):
    found = json.loads((RESULTS / "compass.json").read_text(encoding="utf-8"))
    short = [row for name, row in found["lines"].items() if float(name.split()[2]) <= 0.3]
    share = sum(row["lines"] * row["none"] for row in short) / sum(row["lines"] for row in short)
    assert (
        len(short) == 3
        and 0.6 < share < 0.7
        and "Two in three line segments shorter than 30 cm do not" in text
    )
    all_pieces, long = (
        found["readings"][name]["mean square over variance"] for name in ("all pieces", "from 30 cm on")
    )
    assert f"the stated variance is {long:.1f}; with all segments it is {all_pieces:.1f}" in text
    medians = [
        found["drives"][f"{name}, surest first"]["position"] for name in ("all pieces", "from 30 cm on")
    ]
    assert (
        medians[1] - medians[0] == pytest.approx(1e-3, abs=5e-4)
        and "Without the short segments the median error is a millimetre larger" in text
    )


def test_the_text_says_what_a_posts_thickness_is_worth(text):
    at_most = [np.quantile(off(variant), 0.95) for variant in ("EKF, posts without the extra 2 cm", EKF)]
    assert "error is {1:.1f} cm with these 2 cm, and {0:.1f} cm without them".format(*at_most) in text


def test_the_system_is_as_near_as_it_has_to_be():
    for variant in (SUREST, SUREST_GRAPH):
        row = VARIANTS[variant]
        assert len(row["position"]) == 100
        assert (
            np.median(off(variant)) <= 2 and np.quantile(off(variant), 0.95) <= 5 and off(variant).max() <= 15
        )
        assert np.median(row["heading"]) <= 0.3 and np.median(row["landmarks"]) <= 0.01
        assert 2 <= np.mean(row["nees"]) <= 4
    for name in (NORMAL, FALSE_CORNERS, WORSE):
        row = of_hard_drives(name)
        assert (
            row["position"] <= 0.01
            and row["position 95 %"] <= 0.05
            and lost_of(name, "several hypotheses") == 0
        )
        assert row["NEES mean"] <= 4.5


def test_figure_and_table_have_all_of_it():
    assert f"graph: {np.median(off(GRAPH)):.1f} cm" in draw_variants().alt
    rows = variants_table().rows
    assert len(rows) == len(VARIANTS) - COMPLETE and rows[0][0] == EKF
    assert not any("e+" in cell or "more than" in cell for row in rows for cell in row)
    assert len(VARIANTS) == len(recorded_variants())


def test_the_text_says_how_many_kidnapped_robots_find_their_pose():
    recorded = json.loads((RESULTS / "kidnapping.json").read_text(encoding="utf-8"))
    found, ordinary = recorded["kidnapped"], recorded["ordinary"]
    ending = (
        (SOLUTIONS / "11_slam_on_the_field.md").read_text(encoding="utf-8").partition("## What you have")[2]
    )
    back, drives = found["both, and no alarm before"], found["drives"]
    assert f"is within 5 cm again after seven stops in {back} of {drives} drives" in ending
    assert (ordinary["false alarms"], ordinary["drives"]) == (3, 200)
    assert "with three false alarms in 200 others" in ending
