"""The diagnosis lab of lesson 06: no two patients have the same readings, and the text states them."""

import re

import numpy as np
import pytest

from nao_course.lessons.localization import lab
from nao_course.lessons.localization.consistency import band, median_band
from nao_course.lessons.localization.panels import CASES, LabPanel
from tests.lessons.every import quotes, text

MEDIANS = {2: lab.MEDIAN_NIS, 3: lab.MEDIAN_NEES}


@pytest.fixture(scope="module")
def functions(filter_of):
    return dict(zip(("localize", "predict_pose", "predict_covariance"), filter_of, strict=True))


def readings_of(functions, drives):
    return {letter: lab.read(lab.patient(bug, functions, drives)) for letter, bug in CASES.items()}


def diagnosis(r):
    """Return the name of the fault of a patient, given its readings alone."""
    if r.nis_early > 100:
        return "the innovation's sign" if r.nis_late > 1000 * r.nis_early else "bearings in degrees"
    if r.nees_early > 1e4:
        return "R is missing in S"
    if r.range > 1:
        return "ranges 15 % too long"
    if r.nis_late > 5 * r.nis_early:
        return "Q is missing"
    if r.nis_late < 0.9:
        return "P is not updated" if r.nis_late < 0.5 * r.nis_early else "R holds standard deviations"
    if r.nees_early > 5:
        return "H belongs to another landmark"
    if r.nis_peak > 10:
        return "the bearing is not wrapped"
    return "each measurement is used twice" if r.nees_early > 1.3 else "no fault"


@pytest.mark.parametrize("drives", [8, pytest.param(20, marks=pytest.mark.slow)])
def test_every_patient_is_named_from_its_instruments(functions, drives):
    readings = readings_of(functions, drives)
    assert {letter: diagnosis(each) for letter, each in readings.items()} == {
        letter: bug.name for letter, bug in CASES.items()
    }
    assert len(lab.BUGS) >= 8 and len(set(CASES.values())) == len(lab.BUGS) + 1


@pytest.mark.slow
def test_on_other_drives_they_have_the_same_names_and_the_text_leaves_the_healthy_ones_largest_nis_to_chance(
    functions, monkeypatch
):
    monkeypatch.setattr(lab, "LAB_SEEDS", range(500, 520))
    for bug in (lab.HEALTHY, *lab.BUGS):
        assert diagnosis(lab.read(lab.patient(bug, functions))) == bug.name
    peaks = []
    for first in range(1000, 3000, 100):
        monkeypatch.setattr(lab, "LAB_SEEDS", range(first, first + 20))
        peaks.append(lab.read(lab.patient(lab.HEALTHY, functions)).nis_peak)
    assert 5.5 < max(peaks) < 6.5


@pytest.mark.slow
def test_the_text_says_what_the_instruments_show(functions):
    r = readings_of(functions, len(lab.LAB_SEEDS))
    quotes(
        text("06"),
        f"NIS is {r['A'].nis_early:.1f} early and {r['A'].nis_late:.1f} late",
        f"NIS falls to {r['E'].nis_late:.2f}",
        f"NIS is {r['C'].nis_peak:.0f}",
        f"NIS is {r['H'].nis_early:.1f} to {r['H'].nis_late:.0f}",
        f"NIS is {r['G'].nis_late:.1f}, and NEES is {r['G'].nees_late:.1f}",
        f"{r['B'].range:.1f} standard deviations",
        f"{r['D'].nis_early:.0f} to {r['D'].nis_late:.0f}",
        "NIS is near 1000",
        f"NIS is {r['K'].nis_early:.1f} early and {r['K'].nis_late:.1f} late, and NEES is {r['K'].nees_late:.0f}",
    )
    assert 0.8e6 < r["H"].nees_early < 1.2e6
    assert 900 < r["F"].nis_early < 1100 and 900 < r["F"].nis_late < 1100
    assert 1e3 < r["J"].nis_early < 3e3 and 1e9 < r["J"].nis_late < 1e10
    assert r["I"].nis_peak < 1.55  # "1.5" on these drives
    slightly_high = [letter for letter in r if 1.05 < r[letter].nis_early < 2 and r[letter].nis_late < 2]
    assert slightly_high == ["G", "H"] and min(r[each].nees_early for each in "GH") > 1.5
    assert [letter for letter in r if r[letter].nis_peak < 1] == ["A", "E"]  # "below 1 at every step"
    one_sided = [letter for letter in r if abs(r[letter].range) > 1 and r[letter].nis_late < 10]
    assert one_sided == ["B"] and all(abs(r[letter].bearing) > 1 for letter in "DFJ")


@pytest.mark.parametrize(("degrees", "runs"), [(2, 4), (2, 100), (3, 20)])
def test_the_bands_hold_the_medians_that_are_drawn(degrees, runs):
    low, high = median_band(degrees, runs).ravel()
    values = np.random.default_rng(6).chisquare(degrees, (4000, runs))
    middle = np.sort(values, axis=1)[:, (runs - 1) // 2 : runs // 2 + 1].mean(axis=1)
    assert np.mean((low < middle) & (middle < high)) == pytest.approx(0.95, abs=0.03)
    mean_low, mean_high = band(degrees, runs)
    # Those of a mean are too narrow
    assert high - low > 1.2 * (mean_high - mean_low) * MEDIANS[degrees] / degrees


@pytest.mark.slow
def test_nine_of_ten_steps_of_the_healthy_one_lie_in_the_bands_and_few_of_the_others(functions):
    def inside(letter):
        traces = lab.patient(CASES[letter], functions)
        steps, nis = (np.concatenate([getattr(each, name) for each in traces]) for name in ("steps", "nis"))
        when, counts = np.unique(steps, return_counts=True)
        low, high = median_band(2, counts)
        medians = np.array([np.median(nis[steps == step]) for step in when])
        return np.mean((low <= medians) & (medians <= high))

    assert inside("I") > 0.9 and inside("G") > 0.85 and max(map(inside, "BDEFJ")) < 0.15


def own_mathematics(pose, covariance, measurement, landmark, R):
    """Return the update as a weighted least-squares problem, without any function of the lessons."""
    dx, dy = landmark - pose[:2]
    r = np.hypot(dx, dy)
    H = np.array([[dy / r**2, -dx / r**2, -1.0], [-dx / r, -dy / r, 0.0]])
    off = measurement - (np.arctan2(dy, dx) - pose[2], r)
    off[0] = np.angle(np.exp(1j * off[0]))
    left = np.linalg.inv(np.linalg.inv(covariance) + H.T @ np.linalg.inv(R) @ H)
    new = pose + left @ H.T @ np.linalg.inv(R) @ off
    new[2] = np.angle(np.exp(1j * new[2]))
    return new, left


def test_a_filter_with_its_own_mathematics_gives_the_same_patients_and_not_wrapping_is_off_by_a_full_turn(
    functions, own, report
):
    other = functions | {"localize": own_mathematics}
    for letter in "CK":
        mine, theirs = (lab.patient(CASES[letter], each, drives=2) for each in (functions, other))
        for a, b in zip(mine, theirs, strict=True):
            assert np.allclose(a.poses, b.poses, atol=1e-5) and np.allclose(a.nis, b.nis, rtol=1e-3)
    pose, covariance = np.array([1.0, 0.0, -3.1]), np.diag([0.01, 0.02, 0.005])
    landmark, R, measured = np.array([0.2, 0.1]), np.diag([0.001, 0.01]), np.array([0.02, 0.8])
    H = report["measurement_jacobian_pose"](pose, landmark)
    K = covariance @ H.T @ np.linalg.inv(H @ covariance @ H.T + R)
    dx, dy = landmark - pose[:2]
    plain = measured - (np.arctan2(dy, dx) - pose[2], np.hypot(dx, dy))
    assert abs(plain[0]) > np.pi
    (bug,) = [each for each in lab.BUGS if each.name == "the bearing is not wrapped"]
    new, _ = bug.in_update(own["localize"])(pose, covariance, measured, landmark, R)
    wanted = pose + K @ plain
    assert np.allclose(new[:2], wanted[:2]) and np.isclose(np.exp(1j * new[2]), np.exp(1j * wanted[2]))


@pytest.mark.slow
def test_the_panel_names_what_is_right_and_says_what_another_would_show_and_the_text_folds_the_answers(
    functions, monkeypatch
):
    monkeypatch.setattr(lab, "LAB_SEEDS", range(200, 203))
    panel = LabPanel(**functions)
    assert "Patient A: 0 of 11 named so far." in panel.summary()
    panel.set(diagnosis="Q is missing")
    assert "No: " in panel.summary() and not panel.named
    panel.set(diagnosis=CASES["A"].name)
    assert "Right, " in panel.summary()
    panel.set(patient="E")  # another patient has no diagnosis yet
    assert panel.values.diagnosis == "not yet" and "Patient E: 1 of 11 named so far." in panel.summary()
    assert "Patient E, 20 drives" in panel.shown.drawings["Plots"].alt
    below = text("06").split("LabPanel(localize, predict_pose, predict_covariance)")[1]
    plain = re.sub(r"<details>.*?</details>", "", below, flags=re.DOTALL).split("## My NAO")[0]
    assert "healthy" not in plain and "missing" not in plain
