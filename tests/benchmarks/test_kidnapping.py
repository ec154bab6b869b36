"""Kidnapped robots: how drives are spliced and judged, and that the recorded result is as good as required."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import RESULTS
from benchmarks.field import kidnapping
from benchmarks.field.kidnapping import AFTERWARDS, ELSEWHERE, NEVER, Kidnapping, spliced, summary
from nao_course.field_slam.observation import observation
from nao_course.geometry import Pose
from nao_course.slam import Measurement

GOOD = Kidnapping(noticed=1, back=0, error=0.01, end=0.02, wrong=0, early=0)


@pytest.mark.parametrize("seed", range(5))
def test_a_robot_is_carried_to_another_place_of_another_drive(seed, monkeypatch):
    def drive(number):
        places = np.random.default_rng(number).uniform(0, 1.5, (61, 2))
        return [[SimpleNamespace(pose=Pose(*place.tolist(), 0.0), drive=number)] for place in places]

    monkeypatch.setattr(kidnapping, "stops_of", drive)
    stops, first = spliced(seed, seed + 1)
    assert kidnapping.FIRST <= first <= kidnapping.LAST and len(stops) >= first + AFTERWARDS
    assert [stop[0].drive for stop in stops] == [seed] * first + [seed + 1] * (len(stops) - first)
    here, there = drive(seed)[first][0].pose, stops[first][0].pose
    assert np.hypot(there.x - here.x, there.y - here.y) >= ELSEWHERE


def test_a_robot_succeeds_if_it_notices_and_is_back_in_time_without_an_alarm_before():
    wrong = [{"noticed": 3}, {"noticed": NEVER, "back": NEVER}, {"back": 6}, {"early": 1}]
    for change in ({}, {"noticed": 2, "back": 5}, *wrong):
        result = replace(GOOD, **change)
        assert result.success == (change not in wrong)
        assert summary([GOOD, result])["both, and no alarm before"] == 1 + result.success


def test_clutter_is_what_was_not_measured_before_and_a_far_thing_is_not_counted(monkeypatch):
    pose = Pose(1.0, 0.5, 0.7)
    stop = [SimpleNamespace(pose=pose, view=SimpleNamespace(hfov=1.0))]
    at = [(1.0, 2.0), (0.5, 2.05), (-0.5, 3.5)]
    seen = [observation([Measurement(*each, "corner") for each in chosen]) for chosen in (at[:1], at, at[:2])]
    pictures = iter(seen)
    monkeypatch.setattr(kidnapping, "stops_of", lambda seed: [stop] * len(seen))
    monkeypatch.setattr(kidnapping.Read, "of", lambda picture: picture)
    monkeypatch.setattr(kidnapping, "WHOLE", lambda picture, rng: next(pictures))
    found = kidnapping.clutter(0)
    assert found["corner"] == pytest.approx(2 / 3 / (kidnapping.NEAR**2 * 1.3))
    assert found["post"] == found["centre"] == found["line"] == 0.0


def test_the_recorded_robots_notice_and_are_back_and_no_ordinary_drive_raises_a_false_alarm():
    found = json.loads((RESULTS / "kidnapping.json").read_text(encoding="utf-8"))
    carried, ordinary, times = found["kidnapped"], found["ordinary"], found["ms a picture"]
    assert carried["drives"] == 100 and carried["both, and no alarm before"] >= 95
    assert ordinary["drives"] == 300 and ordinary["false alarms"] == 0
    assert ordinary["off by more than 0.15 m at the end"] <= 1
    assert times["with hypotheses"]["95 %"] <= 30 and times["without"]["95 %"] <= 30
    again = summary([Kidnapping(**each) for each in found["each"].values()])
    assert again == pytest.approx(carried, abs=1e-3)
