"""The figures of lesson 06: they draw the filter's results, and the text's statements about them are true."""

import numpy as np
import pytest

from nao_course.geometry import rotation_2d
from nao_course.lessons.localization import consistency, figures, first_drive, next_landmark
from nao_course.lessons.localization.drives import LANDMARKS, follow_many
from nao_course.lessons.localization.panels import FusePanel
from nao_course.metrics import band, squared_distances
from tests.lessons.every import quotes, text

TEXT = text("06")


def test_one_picture_brings_the_robot_back_and_far_from_the_truth_leaves_an_overconfident_estimate(own):
    _, states = figures.measure_one_picture(own["localize"])
    off = [state.error(figures.TRUE)[0] for state in states]
    assert off[0] > 0.6 and off[-1] < 0.15
    sizes = [np.linalg.det(state.covariance) for state in states]
    assert sizes == sorted(sizes, reverse=True)
    alt = figures.draw_wrong_start(own["localize"], own["covariance_ellipse"]).alt
    assert "0.68 m and 14 degrees" in alt and "0.11 m and 5 degrees" in alt
    quotes(TEXT, "0.68 m", "0.11 m")
    squares = []
    for seed in range(60):
        state = figures.measure_one_picture(own["localize"], seed)[1][-1]
        squares.append(own["nees"](state.pose - figures.TRUE.as_array(), state.covariance))
    assert np.allclose(figures.nees_of_pictures(own["localize"]), np.sort(squares))
    alt = figures.draw_wrong_starts(own["localize"]).alt
    assert f"median is {np.median(squares):.1f}; a consistent filter has 2.4" in alt
    quotes(TEXT, f"NEES is {np.median(squares):.1f}")


def test_four_tenths_lie_inside_the_one_sigma_ellipse_whatever_its_angle(own):
    spread = np.array([[0.09, 0.05], [0.05, 0.05]])
    part = figures.inside(figures.cloud(spread), *own["covariance_ellipse"](spread, 1 - np.exp(-0.5)))
    assert part == pytest.approx(1 - np.exp(-0.5), abs=0.02)
    assert "95 %" in figures.draw_cloud(spread, own["covariance_ellipse"], (0.3935, 0.95)).alt
    long, short = rotation_2d(0.7).T
    points = np.array([1.9 * long, 2.1 * long, 0.4 * short, 0.6 * short])
    assert figures.inside(points, np.array([2.0, 0.5]), 0.7) == 0.5


def test_the_given_filter_loses_the_robot_as_the_text_states_and_a_wrapped_innovation_mends_it(own):
    broken, records = first_drive.run_first_drive()
    off = np.hypot(*broken.errors[:, :2].T)
    stated = np.sqrt(broken.covariances[:, 0, 0] + broken.covariances[:, 1, 1])
    fault = int(np.flatnonzero(broken.nees > first_drive.LIMIT)[0])
    worst = max(records, key=lambda each: abs(each.innovation))
    mended, _ = first_drive.run_first_drive(own["innovation"])
    most = np.hypot(*mended.errors[:, :2].T).max()
    degrees = (f"{each:.1f}" for each in np.degrees(worst))
    quotes(TEXT, f"{fault - 1} steps", f"{off.max():.2f} m", f"{most:.2f} m", f"step {fault}", *degrees)
    assert off[:fault].max() < 0.08 and stated[fault:].max() < 0.10 and broken.nees.max() > 800
    assert mended.nees.max() < first_drive.LIMIT
    trace = broken
    raw = trace.innovations.copy()
    raw[:, 0] = [each.innovation for each in records]
    nis = squared_distances(raw, trace.innovation_covariances)
    large = nis > 5.99
    assert trace.steps[large].tolist() == [14, 19, 19] and not np.isin((15, 16, 17, 18), trace.steps).any()
    first, *others = nis[large]
    assert 5500 < first < 6500 and [round(float(each)) for each in others] == [50, 9]
    quotes(TEXT, "step 14", "6000", "step 19", "50 and 9")
    assert np.flatnonzero(trace.nees > first_drive.LIMIT)[-1] == 23
    assert np.hypot(*trace.errors[:, :2].T).argmax() == 18


def test_the_students_parts_give_the_same_drive_as_the_given_ones_and_figures_state_its_errors(own):
    mended, _ = first_drive.run_first_drive(own["innovation"])
    trace, _ = first_drive.run_first_drive(localize=own["localize"])
    assert np.allclose(trace.poses, mended.poses, atol=1e-6)
    assert np.allclose(trace.covariances, mended.covariances, atol=1e-8)
    with pytest.raises(ValueError, match="innovation must have shape"):
        first_drive.run_first_drive(lambda expected, measured: 1.0)
    assert "NEES is 839 at most" in first_drive.draw_first_drive(nees=own["nees"]).alt
    alt = first_drive.draw_first_drive(own["innovation"], own["nees"], own["covariance_ellipse"]).alt
    assert "above 7.81 at 0 of 31 poses" in alt
    assert "the innovation is -360.5" in first_drive.draw_bearings().alt
    assert "at step 14" in first_drive.draw_bearings(own["nees"]).alt.split("largest NIS")[1]


def test_the_first_drives_motion_is_that_of_lesson_05(report, rng):
    for _ in range(5):
        pose, control = rng.uniform(-3, 3, 3), rng.uniform(0.1, 0.4, 2)
        P, Q = np.diag(rng.uniform(0.01, 0.1, 3)), np.diag(rng.uniform(0.001, 0.01, 3))
        moved = first_drive._move(pose, control) - report["predict_pose"](pose, control)
        assert np.allclose(np.exp(1j * moved), 1)
        wanted = report["predict_covariance"](P, pose, control, Q)
        assert np.allclose(first_drive._move_covariance(P, pose, control, Q), wanted)


def test_a_landmark_along_the_ellipse_improves_by_its_range_and_one_beside_by_its_bearing(own, monkeypatch):
    ahead, behind, beside = next_landmark.ROBOT.to_parent([(1.5, 0.0), (-1.5, 0.0), (0.0, 1.5)])

    def position(place, use_range):
        return next_landmark.remaining_after(own["localize"], place, use_range)[0]

    assert position(ahead, True) == pytest.approx(position(behind, True), rel=1e-6)
    assert position(ahead, True) < 0.8 * position(beside, True)
    assert position(beside, False) < 0.8 * position(ahead, False) and position(ahead, False) > 0.45
    monkeypatch.setattr(next_landmark, "GRID", 0.9)
    left, heading = next_landmark.remaining_after(own["localize"], LANDMARKS[9])
    said = f"the post at (3.0, 0.7) leaves {100 * left:.0f} cm and {np.degrees(heading):.1f} degrees"
    assert said in next_landmark.draw_remaining_uncertainty(own["localize"]).alt


def test_the_bands_figure_counts_what_is_inside_and_the_fuse_panel_says_what_it_returns(filter_of, own):
    traces = follow_many(range(4), *filter_of)
    alt = consistency.draw_bands(traces).alt
    assert "the mean NEES of 4 drives" in alt
    low, high = band(3, 30)
    inside = np.mean([low <= trace.nees[1:].mean() <= high for trace in traces])
    assert consistency.inside_naive_band(traces) == inside and f"only {inside:.0%} of the drives" in alt
    panel = FusePanel(own["fuse"])
    assert "Fused: 2.40 m, standard deviation 0.134 m. The weight of the" in panel.summary()
    panel.set(prediction_sigma=0.2, measurement_sigma=0.2, measured=3.0)
    assert "Fused: 2.50 m" in panel.summary() and "is 0.50." in panel.summary()
    panel.set(measured=2.0)
    assert "weight" not in panel.summary() and "fused: 2.00 m" in panel.shown.drawings["Estimates"].alt
