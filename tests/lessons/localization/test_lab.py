"""The diagnosis lab of lesson 06: no two patients look alike, and the text says what they look like."""

import re

import numpy as np
import pytest

from nao_course.lessons.localization import lab
from nao_course.lessons.localization.honesty import band, median_band
from nao_course.lessons.localization.panels import CASES, LabPanel, readings_table
from tests.paths import SOLUTIONS

MEDIANS = {2: lab.MEDIAN_NIS, 3: lab.MEDIAN_NEES}


@pytest.fixture(scope="module")
def functions(filter_of):
    return dict(zip(("localize", "predict_pose", "predict_covariance"), filter_of, strict=True))


def readings_of(functions, drives):
    return {letter: lab.read(lab.patient(bug, functions, drives)) for letter, bug in CASES.items()}


def diagnosis(r):
    """The name of what a patient has, from its instruments alone; the order is that of how loud it shows."""
    if r.nis_early > 100:
        return "the innovation's sign" if r.nis_late > 1000 * r.nis_early else "bearings in degrees"
    if r.nees_early > 1e4:
        return "R is left out of S"
    if r.range > 1:
        return "ranges 15 % too long"
    if r.nis_late > 5 * r.nis_early:
        return "Q is forgotten"
    if r.nis_late < 0.9:
        return "P is not updated" if r.nis_late < 0.5 * r.nis_early else "R holds standard deviations"
    if r.nees_early > 5:
        return "H belongs to another landmark"
    if r.nis_peak > 10:
        return "the bearing is not wrapped"
    return "each measurement is used twice" if r.nees_early > 1.3 else "nothing: it is healthy"


@pytest.mark.parametrize("drives", [8, pytest.param(20, marks=pytest.mark.slow)])
def test_every_patient_is_named_from_its_instruments(functions, drives):
    readings = readings_of(functions, drives)
    assert {letter: diagnosis(each) for letter, each in readings.items()} == {
        letter: bug.name for letter, bug in CASES.items()
    }
    assert len(lab.BUGS) >= 8 and len(set(CASES.values())) == len(lab.BUGS) + 1


@pytest.mark.slow
def test_on_other_drives_they_have_the_same_names(functions, monkeypatch):
    monkeypatch.setattr(lab, "LAB_SEEDS", range(500, 520))
    for bug in (lab.HEALTHY, *lab.BUGS):
        assert diagnosis(lab.read(lab.patient(bug, functions))) == bug.name


@pytest.mark.slow
def test_the_text_says_what_the_instruments_show(functions):
    text = (SOLUTIONS / "06_localization.md").read_text(encoding="utf-8")
    r = readings_of(functions, len(lab.LAB_SEEDS))
    for sentence in (
        f"A has the roots of $R$: NIS {r['A'].nis_early:.1f} early, {r['A'].nis_late:.1f} late.",
        f"NIS falls to {r['E'].nis_late:.2f}",
        f"NIS is {r['C'].nis_peak:.0f} at that step",
        f"H leaves $R$ out of $S$: NIS {r['H'].nis_early:.1f} to {r['H'].nis_late:.0f}, NEES a million",
        f"NIS {r['G'].nis_late:.1f}, NEES {r['G'].nees_late:.1f}",
        f"residuals lie {r['B'].range:.1f} standard deviations to one side",
        f"NIS climbs from {r['D'].nis_early:.0f} to {r['D'].nis_late:.0f}",
        "F has its bearings in degrees: NIS near 1000",
        f"NIS {r['K'].nis_early:.1f} early and {r['K'].nis_late:.1f} late, and NEES {r['K'].nees_late:.0f}",
    ):
        assert sentence in text, sentence
    assert (
        0.8e6 < r["H"].nees_early < 1.2e6 and 900 < r["F"].nis_early < 1100 and 900 < r["F"].nis_late < 1100
    )
    assert 1e3 < r["J"].nis_early < 3e3 and 1e9 < r["J"].nis_late < 1e10
    assert r["I"].nis_peak < 1.5
    assert [letter for letter in r if r[letter].nis_peak < 1] == ["A", "E"]  # "below 1 at every step"
    one_sided = [letter for letter in r if abs(r[letter].range) > 1 and r[letter].nis_late < 10]
    assert one_sided == ["B"] and all(abs(r[letter].bearing) > 1 for letter in "DFJ")


@pytest.mark.slow
def test_the_healthy_ones_largest_nis_is_what_the_text_leaves_to_chance(functions, monkeypatch):
    peaks = []
    for first in range(1000, 3000, 100):
        monkeypatch.setattr(lab, "LAB_SEEDS", range(first, first + 20))
        peaks.append(lab.read(lab.patient(lab.HEALTHY, functions)).nis_peak)
    assert 5.5 < max(peaks) < 6.5


@pytest.mark.parametrize(("degrees", "runs"), [(2, 4), (2, 100), (3, 20)])
def test_the_bands_hold_the_medians_that_are_drawn(degrees, runs):
    low, high = median_band(degrees, runs).ravel()
    values = np.random.default_rng(6).chisquare(degrees, (4000, runs))
    middle = np.sort(values, axis=1)[:, (runs - 1) // 2 : runs // 2 + 1].mean(axis=1)
    assert np.mean((low < middle) & (middle < high)) == pytest.approx(0.95, abs=0.03)
    mean_low, mean_high = band(degrees, runs)
    assert (
        high - low > 1.2 * (mean_high - mean_low) * MEDIANS[degrees] / degrees
    )  # those of a mean are too narrow


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


def test_the_notebooks_own_function_stays_as_it_was(own):
    localize = own["localize"]
    ill = lab.with_parts(localize, {"innovation": lambda expected, measured: 1 / 0})
    given = np.array([0.0, 0.0, 0.0]), np.eye(3), np.array([0.0, 2.0]), np.array([2.0, 0.0]), np.eye(2)
    with pytest.raises(ZeroDivisionError):
        ill(*given)
    assert np.allclose(localize(*given)[0], 0)


def test_a_filter_without_the_part_is_said_to_lack_it():
    with pytest.raises(ValueError, match=r"your localize does not call innovation\(\)"):
        lab.with_parts(lambda pose, *rest: pose, {"innovation": np.subtract})


def test_a_blank_filter_is_not_said_to_lack_a_part():
    def localize(*given):
        raise NotImplementedError

    with pytest.raises(NotImplementedError):
        lab.with_parts(localize, {"innovation": np.subtract})


def test_the_answers_of_the_lab_are_folded():
    text = (SOLUTIONS / "06_localization.md").read_text(encoding="utf-8")
    below = text.split("LabPanel(localize, predict_pose, predict_covariance)")[1]
    plain = re.sub(r"<details>.*?</details>", "", below, flags=re.DOTALL).split("## My NAO")[0]
    assert "healthy" not in plain and "forgotten" not in plain


def test_the_panel_names_what_is_right_and_says_what_another_would_show(functions, monkeypatch):
    monkeypatch.setattr(lab, "LAB_SEEDS", range(200, 203))
    panel = LabPanel(**functions)
    assert "Patient A: 0 of 11 named so far." in panel.summary()
    panel.set(diagnosis="Q is forgotten")
    assert "No. Q is forgotten would show otherwise" in panel.summary() and not panel.named
    panel.set(diagnosis=CASES["A"].name)
    assert "Right, patient A has it: R holds standard deviations." in panel.summary()
    panel.set(patient="E", diagnosis="not yet")
    assert "Patient E: 1 of 11 named so far." in panel.summary()
    assert "Instruments of patient E" in panel.shown.drawings["Instruments"].alt


def test_the_panel_of_a_blank_notebook_says_what_to_write(functions):
    def localize(*given):
        raise NotImplementedError

    panel = LabPanel(**(functions | {"localize": localize}))
    assert "Finish exercise 6.7: the patients are made of your filter." in panel.summary()


def test_the_table_is_short_enough_to_be_read():
    row = readings_table({"J": lab.Readings(-3.47, -1230.0, 1850.0, 4.28e9, 2.9e12, 3.9e4, 4.8e10)}).rows[0]
    assert row == ("J", "-3.47", "-1e3", "2e3", "4e9", "3e12", "4e4", "5e10")
