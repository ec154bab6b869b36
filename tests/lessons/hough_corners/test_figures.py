"""Figures of lesson 03: what they say is what they show, and its numbers are as measured."""

import numpy as np
import pytest

from benchmarks import paper_detector as paper
from nao_course.lessons.hough_corners.figures import COSTS, FUNNEL, draw_costs, draw_funnel, draw_segments
from nao_course.sim import standard_scenes

BLACK = np.zeros((24, 32, 3), dtype=np.uint8)


def test_segments_and_corners_are_counted_and_corners_placed():
    segments = [(2, 3, 20, 3), (2, 3, 2, 20)]
    assert draw_segments(BLACK, segments).alt == "A picture with 2 segments."
    assert draw_segments(BLACK, segments, [(2, 3)]).alt.endswith("2 segments and 1 corner at (2, 3).")
    assert draw_segments(BLACK, np.zeros((0, 4)), np.zeros((0, 2))).alt.endswith("0 segments and 0 corners.")


def test_costs_and_funnel_are_told_to_who_cannot_see_them():
    assert "nothing: 2.03" in draw_costs().alt
    assert "two that are not parallel 12" in draw_funnel().alt


def test_a_cost_is_the_papers_weights_times_its_counts():
    for cost, low, high, hits, false, missed in COSTS.values():
        assert hits + missed == FUNNEL["in the picture"]
        total = paper.HIT * hits + paper.FALSE * false + paper.MISSED * missed
        assert cost == pytest.approx(total / 30, abs=0.006) and low < cost < high


@pytest.mark.slow
def test_the_funnel_is_what_the_tuning_pictures_say():
    scenes = [
        paper.Scene(
            scene.pixels,
            np.array(
                [m.pixel for m in scene.truth.landmarks if m.landmark.shape in ("L", "T")], dtype=float
            ).reshape(-1, 2),
        )
        for scene in standard_scenes("tune")
    ]
    corners = sum(len(scene.corners) for scene in scenes)
    left = [round(corners * share) for share in paper.funnel(scenes, paper.Hues()).values()]
    assert [corners, *left] == list(FUNNEL.values())
