"""What lesson 05's figures and panels compute, and that its text says the same."""

import numpy as np
import pytest

from nao_course.lessons.ekf_derivations import bugs, lap, limits, report, samples
from nao_course.lessons.ekf_derivations.figures import bending_clouds, draw_bending
from nao_course.lessons.ekf_derivations.panel import DRIVE_NOISE, LANDMARK, MEASUREMENT, LinearisationPanel
from nao_course.lessons.ekf_derivations.samples import Cloud, motion_cloud


def test_the_payoff_the_shares_and_the_correlation_of_the_text_are_those_of_many_samples(solution):
    functions = solution["predict_pose"], solution["predict_covariance"]
    good, bad = ([each.inside() for each in bending_clouds(*functions, np.radians(s))] for s in (5, 30))
    assert min(good) > 0.9 and max(bad) < 0.65
    alt = draw_bending(*functions).alt
    assert "5 degrees: 94, 92 and 92 %" in alt and "30 degrees: 62, 55 and 49 %" in alt
    assert draw_bending(functions[0], lambda covariance, *rest: covariance).alt != alt
    names = ("landmark_position", "expected_measurement", "landmark_jacobians")
    functions = [solution[name] for name in names]
    errors, correlation = report.two_landmarks(*functions)
    assert np.corrcoef(errors.T)[0, 1] == pytest.approx(correlation, abs=0.04)
    assert "Jacobians give 0.88" in report.draw_two_landmarks(*functions).alt
    covariance = np.diag([0.03, 0.03, np.radians(30)]) ** 2
    functions = solution["predict_pose"], solution["predict_covariance"]
    for distance, inside, shift in ((2.0, 44, -0.26), (1.0, 58, -0.13)):
        rng = np.random.default_rng(2)
        cloud = motion_cloud(*functions, (0, 0, 0), covariance, (distance, 0.0), DRIVE_NOISE, rng, 200_000)
        assert round(100 * cloud.inside()) == inside and cloud.shift[0] == pytest.approx(shift, abs=0.005)


POSE = (1.0, 2.0, 2.4)
SMALL = np.diag([0.02, 0.01, 0.005]) ** 2
CONTROL_NOISE = np.diag([0.05, 0.01, 0.02]) ** 2
MEASUREMENT_NOISE = np.diag([0.01, 0.02]) ** 2


def agrees(cloud):
    error = np.linalg.norm(cloud.shift) / np.sqrt(np.trace(cloud.covariance) / len(cloud.points))
    ratio = np.linalg.solve(cloud.covariance, cloud.sampled_covariance)
    return error < 4 and np.allclose(ratio, np.eye(2), atol=0.12) and 0.93 < cloud.inside() < 0.97


def test_drawn_samples_have_their_covariance_which_both_sides_carry_and_an_ellipse_holds_its_share(rng):
    covariance = np.array([[2.0, 0.6, 0.0], [0.6, 0.5, -0.1], [0.0, -0.1, 0.3]])
    drawn = samples.draw([1, 2, 3], covariance, 100_000, rng)
    assert np.allclose(drawn.mean(axis=0), [1, 2, 3], atol=0.03)
    assert np.allclose(np.cov(drawn.T), covariance, atol=0.04)
    assert (samples.draw([1, 2], np.zeros((2, 2)), 5, rng) == [1, 2]).all()
    slopes, root = rng.normal(size=(2, 3)), rng.normal(size=(3, 3))
    assert np.allclose(samples.propagated(slopes, root @ root.T), slopes @ root @ root.T @ slopes.T)
    assert np.allclose(samples.propagated(slopes, np.zeros((3, 3))), 0, atol=1e-15)
    points = np.array([[0.0, 0.0], [2.4, 0.0], [2.5, 0.0], [0.0, -2.4]])
    assert samples.Cloud(points, np.zeros(2), np.eye(2)).inside() == 0.75
    assert samples.Cloud(points, np.zeros(2), np.diag([1.0, 0.01])).inside() == 0.5


def test_where_all_is_nearly_straight_the_right_solution_predicts_its_samples(solution, rng):
    s, z = solution, MEASUREMENT_NOISE
    drive = s["predict_pose"], s["predict_covariance"]
    place = s["landmark_position"], s["landmark_jacobians"]
    seen = s["expected_measurement"], s["measurement_jacobian_pose"]
    assert agrees(samples.motion_cloud(*drive, POSE, SMALL, (1.5, 0.3), CONTROL_NOISE, rng, 3000))
    assert agrees(samples.landmark_cloud(*place, SMALL, (0.7, 2.0), z, rng, 3000))
    assert agrees(samples.measurement_cloud(*seen, SMALL, (-2.0, 0.01), rng, 3000))
    behind = samples.measurement_cloud(*seen, np.diag([0.1, 0.1, 0.2]) ** 2, (-2.0, 0.0), rng)
    assert np.ptp(behind.points[:, 0]) < np.pi  # bearings stay together
    noise = np.diag([0.0, 0.2, 0.0]) ** 2
    across = samples.motion_cloud(*drive, (0, 0, np.pi / 2), 0 * SMALL, (1, 0), noise, rng)
    assert np.allclose(across.points[:, 1], 1)
    assert np.std(across.points[:, 0]) == pytest.approx(0.2, rel=0.15)


@pytest.fixture
def functions(solution):
    return solution["predict_pose"], solution["predict_covariance"]


def test_the_cloud_grows_across_the_way_and_after_three_metres_holds_fewer_robots_as_the_text_says(rng):
    assert lap.true_paths().shape == (200, len(lap.LAP) + 1, 3)
    paths = lap.true_paths(20_000)
    assert paths[:, 6, :2].std(axis=0) == pytest.approx([0.07, 0.09], abs=0.006)
    assert paths[:, 12, :2].std(axis=0) == pytest.approx([0.29, 0.12], abs=0.006)
    dots = 100 * lap.true_paths()[:, [6, 12], :2].std(axis=0)
    assert dots.round().tolist() == [[8, 9], [29, 13]]
    assert np.degrees(paths[:, -1, 2].std()) == pytest.approx(20, abs=0.5)
    for degrees, percent in ((10, 73), (15, 57)):
        headings = rng.normal(0, np.radians(degrees), 400_000)
        ends = 3 * np.array([np.cos(headings), np.sin(headings)]) + rng.normal(0, 0.03, (2, 400_000))
        predicted = np.diag([0.03**2, 0.03**2 + (3 * np.radians(degrees)) ** 2])
        assert round(100 * Cloud(ends.T, np.array([3.0, 0.0]), predicted).inside()) == percent


def test_the_lap_ends_where_it_starts_and_its_ellipse_holds_95_percent_unless_transposed(functions, solution):
    found = lap.estimates(*functions)
    assert found.poses[-1] == pytest.approx([0, 0, 2 * np.pi], abs=1e-12)
    assert lap.typical_distance() == pytest.approx(0.44, abs=0.01)
    assert "is 0.41 m from" in lap.draw_lap(found).alt
    for steps in (1, 12, len(lap.LAP)):
        share = lap.share_inside(lap.estimates(*functions, steps), robots=5000)
        assert share == pytest.approx(0.945, abs=0.015)
    with pytest.raises(ValueError, match="have none"):
        lap.share_inside(lap.estimates(functions[0], None))

    def wrong(covariance, pose, control, noise):
        F, G = solution["motion_jacobians"](pose, control)
        return F.T @ covariance @ F + G @ noise @ G.T

    assert lap.share_inside(lap.estimates(functions[0], wrong)) < 0.8


def test_the_panel_gets_better_with_each_function(functions):
    first, second, third = lap.LapPanel(), lap.LapPanel(functions[0]), lap.LapPanel(*functions)
    assert "is 1.36 m from its estimated position" in first.summary()
    assert "no covariance yet" in first.summary() and "no covariance yet" in second.summary()
    assert "is 0.41 m from its estimated position" in second.summary()
    assert "190 of 200 robots (95 %)" in third.summary(), "the text states this number below the panel"
    third.set(command=18)
    assert "187 of 200 robots (94 %)" in third.summary()
    third.set(command=0)
    assert "inside" not in third.summary()


@pytest.fixture(scope="module")
def measured(solution):
    return limits.measure_limits(solution["predict_pose"], solution["predict_covariance"])


def test_mean_and_standard_deviation_are_off_by_their_formulas_and_the_lessons_numbers(measured, solution):
    mean, across, _ = (measured[title] for title in limits.TITLES)
    assert np.allclose(mean[:, 1], 100 * limits.short_mean(limits.SIGMAS), atol=0.4)
    assert np.allclose(across[:, 1], 100 * limits.across_too_large(limits.SIGMAS), atol=1.0)
    assert ((mean[:, 0] <= mean[:, 1]) & (mean[:, 1] <= mean[:, 2])).all()
    drawing = limits.draw_limits(measured)
    assert len(drawing.figure.axes) == 3
    assert "samples in the 95 % ellipse (%): 94 at 5°, 79 at 15°" in drawing.alt
    assert limits.limit_of_mean(solution["predict_pose"], 5) == 18.35
    assert np.degrees(np.sqrt(-2 * np.log(0.95))) == pytest.approx(18.35, abs=0.005)
    inside = dict(zip(np.degrees(limits.SIGMAS).round(), measured[limits.TITLES[2]][:, 1], strict=True))
    assert (round(inside[10]), round(inside[15])) == (89, 79)
    functions = solution["predict_pose"], solution["predict_covariance"]
    thick = limits.heading_clouds(*functions, np.radians(15), position_sigma=0.1)
    assert np.mean([each.inside() for each in thick]) == pytest.approx(0.92, abs=0.01)


def test_a_robot_that_cannot_turn_has_no_limits(monkeypatch):
    assert limits.limit_of_mean(lambda pose, control: pose + [1.0, 0.0, 0.0], 5) == np.inf
    monkeypatch.setattr(limits, "RUNS", 2)
    found = limits.measure_limits(
        lambda pose, control: pose + [1, 0, 0], lambda covariance, *rest: covariance
    )
    assert np.allclose(found[limits.TITLES[0]][:, 1], 0, atol=0.5)
    assert (found[limits.TITLES[2]][:, 1] > 90).all()


def test_the_pages_slips_cost_what_the_table_says_and_swapped_coordinates_what_their_formula(solution, rng):
    right, page = report.derivative_at_one(solution["motion_jacobians"])
    assert right == pytest.approx(0, abs=1e-12) and page == pytest.approx(np.radians(5))
    away = report.swapped_coordinates(solution["landmark_position"], rng)
    heading, bearing, distance = 0.7, 0.4, 2.0
    right = distance * np.sin(heading + bearing)
    page = np.sin(heading) * distance * np.sin(bearing) + np.cos(heading) * distance * np.cos(bearing)
    assert abs(right - page) == pytest.approx(abs(distance * (np.sin(1.1) - np.cos(0.3))))
    assert 1.2 < np.median(away) < 2.0
    assert 0.08 < report.share_outside(solution["expected_measurement"], rng) < 0.16  # noise behind the wrap
    assert report.half_turns(solution["expected_measurement"], rng) == pytest.approx(0.5, abs=0.04)
    names = ("expected_measurement", "landmark_position", "motion_jacobians")
    shown = repr(report.report_costs(*(solution[name] for name in names)))
    assert "9 cm, not 0" in shown and all(page in shown for page in ("1.2", "1.3", "1.4", "1.5"))


@pytest.fixture
def predictions(solution):
    return bugs.Predictions(solution["motion_jacobians"], solution["predict_covariance"])


def test_each_bug_is_its_names_formula_and_a_covariance_is_off_in_one_direction(solution, predictions, rng):
    theta = 0.7
    root = rng.normal(size=(3, 3))
    covariance, noise = root @ root.T, np.diag([3.0, 1.0, 0.2])
    F, G = solution["motion_jacobians"]((0, 0, theta), bugs.BUG_DRIVE)
    formulas = {
        "FᵀPF": F.T @ covariance @ F + G @ noise @ G.T,
        "GᵀQG": F @ covariance @ F.T + G.T @ noise @ G,
        "noise not rotated": F @ covariance @ F.T + noise,
    }
    assert formulas.keys() == bugs.BUGS.keys()
    for bug, wanted in formulas.items():
        assert np.allclose(predictions.wrong(bug, covariance, theta, bugs.BUG_DRIVE, noise), wanted)
    for worst in (4.0, 0.25):
        assert bugs.wrong_by(np.eye(3), np.diag([1.0, worst, 9.0])) == pytest.approx(1.0)
    assert bugs.wrong_by(bugs.BUG_POSE, bugs.BUG_POSE) == pytest.approx(0.0)


def test_bugs_hide_and_show_where_the_lesson_says_and_the_figure_how_much_in_the_end(predictions, solution):
    headings = np.radians([0, 45, 90, 135, 180])
    hidden = ("GᵀQG", "noise not rotated", "FᵀPF")
    swapped, unturned, wrong = (predictions.off(bug, headings) for bug in hidden)
    assert np.allclose(swapped[[0, 2, 4]], 0, atol=1e-6) and swapped[1] == pytest.approx(3.5, abs=0.05)
    assert np.allclose(unturned[[0, 4]], 0, atol=1e-6) and unturned[2] == pytest.approx(3.5, abs=0.05)
    assert np.allclose(wrong, 0.27, atol=0.01)
    right, wrong = (predictions.across(bug, np.radians(30))[-1] for bug in ("", "FᵀPF"))
    assert (round(100 * right), round(100 * wrong)) == (28, 8)
    names = ("predict_pose", "motion_jacobians", "predict_covariance")
    drawing = bugs.draw_bug_hunt(*(solution[name] for name in names))
    assert "28 cm across after 3.6 m. FᵀPF" in drawing.alt and "8 cm across" in drawing.alt
    assert len(drawing.figure.axes) == 3 and bugs.BUG_NOISE[0, 0] == pytest.approx(0.09)


NAMES = (
    "predict_pose",
    "predict_covariance",
    "landmark_position",
    "landmark_jacobians",
    "expected_measurement",
    "measurement_jacobian_pose",
)


@pytest.fixture
def panel(solution):
    return LinearisationPanel(*(solution[name] for name in NAMES))


def inside(panel):
    return int(panel.summary().rsplit("\n", 1)[-1].split("%")[0])


def test_a_motion_bends_at_30_degrees_and_a_landmark_too_and_an_expected_measurement_only_near_by(panel):
    panel.set(heading=5)
    assert inside(panel) >= 92
    panel.set(heading=30)
    assert inside(panel) == 41 and "mean off by -0.27 m" in panel.summary()
    panel.set(distance=1.0)
    assert inside(panel) == 55 and "mean off by -0.14 m" in panel.summary()
    panel.set(what=LANDMARK, distance=2.0, heading=0, position=0.5)
    assert inside(panel) >= 93
    panel.set(heading=30, position=0.03)
    assert inside(panel) < 50
    panel.set(what=MEASUREMENT, heading=30, distance=3.0)
    assert inside(panel) >= 93
    for distance, off in ((0.6, 0.08), (0.5, 0.09), (0.4, 0.12)):
        panel.set(heading=5, position=0.3, distance=distance)
        assert f"range: mean off by {off:.2f} m" in panel.summary()
