"""The corners panel: its values reach the student's functions, and what is missing is named."""

import numpy as np

from nao_course.lessons.hough_corners.panel import CornerPanel, mark_found
from nao_course.lessons.hough_corners.scenes import CornerPicture
from nao_course.metrics import CornerTruth
from nao_course.plotting.marks import enlarged

LABELS = np.full((48, 64), 3, dtype=np.uint8)
SEGMENTS = np.array([[5.0, 6.0, 40.0, 6.0], [5.0, 6.0, 5.0, 40.0]])


def picture(corner):
    return CornerPicture(
        np.full((48, 64, 3), 90, dtype=np.uint8),
        CornerTruth(np.array([corner], dtype=float), np.zeros((0, 2))),
    )


def panel(pictures=None, **changed):
    student = {
        "label": lambda pixels, beta: LABELS,
        "erase_background": lambda labels, run: labels,
        "find_segments": lambda left, gap, length: SEGMENTS,
        "find_corners": lambda labels, run, gap, length, reach: np.array([[5.0, 6.0]]),
    }
    chosen = {"a": picture((7, 6)), "b": picture((60, 40))} if pictures is None else pictures
    return CornerPanel(chosen, **(student | changed))


def test_every_slider_reaches_its_function():
    got = {}
    shown = panel(
        label=lambda pixels, beta: got.update(beta=beta) or LABELS,
        erase_background=lambda labels, run: got.update(run=run) or labels,
        find_segments=lambda left, gap, length: got.update(gap=gap, length=length) or SEGMENTS,
        find_corners=lambda labels, *values: got.update(found=values) or np.zeros((0, 2)),
    )
    wanted = {"beta": 130, "run": 3, "gap": 7, "length": 20, "reach": 12}
    shown.set(**wanted)
    assert got.pop("found") == (3, 7, 20, 12.0)
    assert got == {name: wanted[name] for name in got} and len(got) == 4
    assert "2 segments, 0 corners" in shown.summary()


def test_it_says_what_was_found_and_what_it_costs_and_draws_segments_and_rings_on_a_copy():
    found, none = panel(), panel(find_corners=lambda *given: np.zeros((0, 2)))
    rings = found.shown.pictures["What you find"] != none.shown.pictures["What you find"]
    rows, columns = np.nonzero(rings.any(axis=2))
    assert rows.max() <= 2 * (6 + 10) and columns.max() <= 2 * (5 + 10) and len(rows) > 80
    shown = panel()
    assert "2 segments, 1 corner: 1 of 1 true corner found, 0 false, cost -1.33." in shown.summary()
    shown.set(picture="b")
    assert "0 of 1 true corner found, 1 false, cost 6.00." in shown.summary()
    shown = picture((20, 30)).pixels
    found = mark_found(shown, np.zeros((0, 4)), [(40, 20)])
    plain = enlarged(shown, 2)
    assert (found != plain).any() and (found[40, 80] == 90).all(), "the corner itself stays visible"
    lines = mark_found(shown, [(1, 45, 60, 45)], ())
    assert (lines[90] != plain[90]).any() and (lines[:80] == plain[:80]).all()
    assert (picture((20, 30)).pixels == shown).all()
