"""On a real robot's pictures distances are what lesson 04 says, after one calibration."""

from typing import Any

import numpy as np
import pytest

from benchmarks.pictures import distance
from nao_course.lessons.distance.calibration import Marked, by_distance
from nao_course.lessons.distance.calibration_figure import REAL

MOST = {"1-2 m": 0.12, "2-3 m": 0.25}  # m, median of the exact way's error


@pytest.mark.slow
@pytest.mark.parametrize("title", distance.SETS)
def test_distances_on_real_pictures(title, data_dir, monkeypatch):
    monkeypatch.setenv("NAO_COURSE_DATA", str(data_dir))
    offset, errors = distance.measured(distance.SETS[title])
    assert 4.5 < np.degrees(offset) < 7.5
    found: dict[str, Any] = {name: by_distance(*each) for name, each in errors.items()}
    assert [pair[0] for pair in found["exact"]][:2] < list(MOST.values())
    assert found["exact"][0][0] <= MOST["1-2 m"] and found["exact"][1][0] <= MOST["2-3 m"]
    for name, rows in REAL[title].items():
        assert np.array(found[name]) == pytest.approx(np.array(rows), abs=0.002), f"{name}: {found[name]}"


def test_ten_pictures_are_for_the_calibration_and_all_others_are_measured():
    pictures = [Marked(np.zeros((1, 2)), np.zeros((1, 2)), None) for _ in range(23)]  # type: ignore[arg-type]
    ten, others = distance.split(pictures)
    assert (len(ten), len(others)) == (10, 13)
    assert not {id(each) for each in ten} & {id(each) for each in others}
