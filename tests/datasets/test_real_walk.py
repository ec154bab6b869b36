"""The real walk's measurements agree with the field, and are what the detectors find in its pictures."""

import json

import numpy as np
import pytest

from nao_course.datasets.real_walk import FIELD, FILE, recorded_walk
from nao_course.geometry import wrap_angle
from nao_course.slam import range_and_bearing


def test_each_measurement_of_the_real_walk_fits_its_landmark():
    walk = recorded_walk()
    assert len(walk.steps) == 30 and walk.steps[0].motion is None
    assert walk.controls[:, 0].sum() == pytest.approx(6.0) and not walk.controls[:, 1].any()
    off, sigmas, kinds = [], [], []
    for step in walk.steps:
        for number, measured, R in zip(step.numbers, step.measurements, step.covariances, strict=True):
            assert np.allclose(R, R.T) and np.linalg.eigvalsh(R)[0] > 0
            off.append(measured - range_and_bearing(step.pose, walk.landmarks[number]))
            sigmas.append(np.sqrt(R[1, 1] + 0.05**2))
            kinds.append(FIELD.detectable_kinds[number])
    off = np.array(off)
    assert (kinds.count("post"), kinds.count("corner")) == (47, 13)
    assert np.abs(np.degrees(wrap_angle(off[:, 0]))).max() < 5.0
    assert np.abs(off[:, 1] / sigmas).max() < 4.0 and np.abs(off[:, 1]).max() < 0.7


@pytest.mark.slow
@pytest.mark.usefixtures("data_dir")
def test_the_file_is_what_the_detectors_measure_in_the_pictures(monkeypatch):
    from benchmarks.pictures import recorded_walk as benchmark

    written = []
    monkeypatch.setattr(benchmark, "write_json", lambda path, stops: written.append((path, stops)))
    result = benchmark.main()
    assert result.values == {
        "pictures": 30,
        "pictures with a measurement": 24,
        "posts": 47,
        "corners": 13,
        "left out": 3,
    }
    (path, stops) = written[0]
    assert path == FILE
    for now, then in zip(stops, json.loads(FILE.read_text(encoding="utf-8")), strict=True):
        assert np.allclose(now["pose"], then["pose"], atol=1e-3)
        assert np.allclose(
            np.reshape(now["seen"], (-1, 6)), np.reshape(then["seen"], (-1, 6)), rtol=2e-3, atol=1e-5
        )
