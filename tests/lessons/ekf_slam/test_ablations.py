"""The report's ten ablations: what each sigma does, in numbers, in a table and in a grid of plots."""

import numpy as np
import pytest

from nao_course.datasets import read_homework_log
from nao_course.lessons.ekf_slam.ablations import ablate, ablation_table, draw_ablations
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS, own_log
from nao_course.metrics import band


@pytest.fixture(scope="module")
def functions(own):
    return own["init_landmarks"], own["predict"], own["update"]


@pytest.fixture(scope="module")
def ablations(functions):
    return ablate(own_log(), *functions, OWN_SIGMAS)


def test_there_are_the_reports_ten_in_its_order_after_the_sigmas_as_they_are(ablations):
    assert [each.title for each in ablations] == [
        *("unchanged", "σx × 10", "σx / 10", "σy × 10", "σy / 10", "σα × 10", "σα / 10"),
        *("σβ × 10", "σβ / 10", "σr × 10", "σr / 10"),
    ]


def test_control_noise_widens_the_prediction_and_measurement_noise_the_map(ablations):
    base, *changed = ablations
    larger = {each.name: each for each in changed if each.factor > 1}
    for name in ("along", "across"):
        assert larger[name].position > 3 * base.position
        assert larger[name].landmark < 1.1 * base.landmark
    for name in ("bearing", "range"):
        assert larger[name].landmark > 1.5 * base.landmark


def test_sigma_x_is_along_the_robot_and_sigma_y_across(ablations):
    for name, axis in (("along", 0), ("across", 1)):
        run = next(each for each in ablations if each.name == name and each.factor > 1).run
        theta, P = run.predicted_states[12, 2], run.predicted_covariances[12, :2, :2]
        robot = np.array([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])
        variances = np.diag(robot @ P @ robot.T)
        assert variances[axis] > 20 * variances[1 - axis]


def test_sigma_alpha_looks_harmless_only_while_each_turn_is_corrected_at_once(ablations, functions):
    def growth(runs):
        return (
            next(each.position for each in runs if (each.name, each.factor) == ("turn", 10))
            / runs[0].position
        )

    assert growth(ablations) < 1.05
    assert growth(ablate(own_log(), *functions, OWN_SIGMAS, every=5)) > 3


def test_the_nis_shows_what_the_lesson_says(ablations):
    nis = {each.title: round(each.nis, 1) for each in ablations}
    assert (nis["σβ / 10"], nis["σr / 10"]) == pytest.approx((295, 390), abs=0.5)
    assert [nis[name] for name in ("σβ × 10", "σr × 10", "σα / 10", "σx / 10", "σy / 10")] == [
        *(6.0, 5.8, 20.5, 14.3, 13.8)
    ]
    assert [nis[name] for name in ("σx × 10", "σy × 10", "σα × 10")] == [11.0, 11.2, 11.3]
    low, high = band(12, len(ablations[0].run.nis))
    assert (round(low, 1), round(high, 1)) == (10.2, 14.0) and nis["σx / 10"] > high > nis["σy / 10"]
    positions = {each.title: f"{100 * each.position:.1f}" for each in ablations}
    assert (positions["unchanged"], positions["σα × 10"]) == ("5.4", "5.5")
    assert f"{100 * ablations[0].updated_position:.1f}" == "4.1"


def test_table_and_figure_say_the_same(ablations):
    table = ablation_table(ablations)
    assert [row[0] for row in table.rows] == [each.title for each in ablations]
    assert table.rows[0][1] == f"{100 * ablations[0].position:.3g}"
    drawing = draw_ablations(ablations)
    assert [ax.get_title(loc="left") for ax in drawing.figure.axes if ax.axison] == [
        *("unchanged", "σx × 10", "σy × 10", "σα × 10", "σβ × 10", "σr × 10"),
        *("σx / 10", "σy / 10", "σα / 10", "σβ / 10", "σr / 10"),
    ]
    assert f"σx × 10: {ablations[1].position / ablations[0].position:.2g} and" in drawing.alt


def test_on_the_homeworks_log_the_reports_findings_hold(functions, data_dir):
    log = read_homework_log(data_dir / "slam" / "cmu16833_hw2" / "data.txt")
    base, *changed = ablate(log, *functions)
    growth = {each.title: each.position / base.position for each in changed}
    assert growth["σx × 10"] > 7 and growth["σy × 10"] > 3 and growth["σα × 10"] < 1.01
    assert next(each for each in changed if each.title == "σβ / 10").landmark < base.landmark / 3
