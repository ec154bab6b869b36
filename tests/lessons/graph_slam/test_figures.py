"""Figures of lesson 08: what they say is what they show."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse.linalg

from nao_course.lessons.graph_slam import costs
from nao_course.lessons.graph_slam.costs import draw_costs
from nao_course.lessons.graph_slam.drives import corridor, field_drive
from nao_course.lessons.graph_slam.figures import draw_snapshots, draw_valley, draw_weights
from nao_course.lessons.graph_slam.map_errors import (
    ANGLES,
    HEADINGS,
    POWERS,
    doubling_turn,
    draw_powers,
    draw_turning,
    errors_by_turn,
    expected_error,
    unlike_drive,
)
from nao_course.lessons.graph_slam.matrices import (
    correlations,
    draw_correlations,
    draw_fill_in,
    draw_marginalised,
    fewest_neighbours_first,
    fill_in,
    share,
)
from nao_course.lessons.graph_slam.residuals import draw_drive, filtered, path_error
from nao_course.lessons.graph_slam.systems import assemble, solve_axes
from tests.lessons.every import quotes, text
from tests.lessons.graph_slam.test_systems import BUILDERS, link, start

WALK = corridor(18, np.random.default_rng(4))
OMEGA, XI = assemble(WALK.constraints, WALK.size, BUILDERS, 0)


def test_fill_in_is_where_the_factor_is_not_zero_and_depends_on_the_order_of_elimination(rng):
    for order in (list(range(len(OMEGA))), fewest_neighbours_first(OMEGA != 0), rng.permutation(len(OMEGA))):
        factor = np.linalg.cholesky(OMEGA[np.ix_(order, order)])
        pattern = fill_in(OMEGA != 0, order)
        assert not (np.abs(factor) > 1e-12)[~pattern].any()
        assert np.count_nonzero(factor) > 0.99 * pattern.sum(), "except for entries that underflow"
    star = np.eye(6, dtype=bool)
    star[0] = star[:, 0] = True
    assert fill_in(star, range(6)).sum() == 21
    assert fill_in(star, range(5, -1, -1)).sum() == 11
    assert fewest_neighbours_first(star).index(0) >= 4, "at the end there are two, each with one neighbour"
    said = draw_fill_in(star, 1).alt
    assert "as numbered: 21" in said and "fewest neighbours first: 11" in said


def test_valley_and_snapshots_say_how_the_error_falls_and_the_doubling_turn_is_between_its_angles():
    system = start(np.zeros((3, 3)), np.zeros(3), 0, 0.0)
    for each in ((0, 1, 5.0), (0, 2, 9.0), (1, 2, 3.0)):
        system = link(*system, *each)
    assert "lowest point, (5.33, 8.67) steps" in draw_valley(*system).alt
    said = draw_snapshots(start, link, link, np.linalg.solve).alt
    assert "15 constraints, no landmark" in said and "map off by 53 cm" in said
    assert "off by 16 cm" in said and "all constraints: 60 constraints, map off by 4" in said
    errors = 0.1 + 0.02 * np.degrees(ANGLES)
    assert doubling_turn(errors) == pytest.approx(5.0)
    assert np.isnan(doubling_turn(np.full(len(ANGLES), 0.1)))
    drawing = draw_turning(dict.fromkeys(HEADINGS, errors))
    assert drawing.figure.axes[0].texts[0].get_text() == "doubled at 5.0°"
    assert drawing.alt.count("0.50 m at 20 degrees") == len(HEADINGS)


def test_the_heading_of_the_odometry_helps_from_five_degrees_on_as_the_lesson_says():
    none, odometry, true = (errors_by_turn(kind, BUILDERS, np.linalg.solve) for kind in HEADINGS)
    degrees = np.degrees(ANGLES).round(1)
    assert (odometry >= none - 1e-9)[degrees <= 2.5].all() and (odometry < none)[degrees >= 5].all()
    assert true.max() < 0.05 and f"{doubling_turn(none):.0f}" == "3"
    quotes(text("08"), "no better than none up to a turn of 2.5 degrees, and helps from five degrees on")


def test_on_most_drives_the_graphs_path_is_better_than_the_filters_as_the_lesson_says():
    errors = []
    for drive in map(field_drive, range(1, 201)):
        maps = filtered(drive), solve_axes(drive.constraints, drive.size, BUILDERS, np.linalg.solve)[0]
        errors.append([(path_error(drive, each), np.hypot(*(each[12] - drive.path[12]))) for each in maps])
    (of_filter, stop_of_filter), (of_graph, stop_of_graph) = 100 * np.median(errors, axis=0)
    better = sum(graph[0] < old[0] for old, graph in errors)
    assert sum(old[1] < errors[0][0][1] for old, _ in errors) > 180, (
        "the filter misses x12 by more than usual"
    )
    quotes(
        text("08"),
        f"the graph's path is better in {better}",
        f"{of_graph:.1f} cm instead of {of_filter:.1f} cm",
        f"{stop_of_graph:.0f} cm instead of {stop_of_filter:.0f} cm",
    )


@pytest.mark.slow
def test_the_map_of_the_students_code_gets_better_with_each_exercise():
    functions = (start, link, link, np.linalg.solve)
    first, second, *others = (draw_drive(*functions[:count]).alt for count in (1, 2, 3, 4))
    assert "1 of 15 stops" in first and "15 of 15 stops: path off by 72 cm, no landmark" in second
    for said in others:
        assert "path off by 8 cm, map by 4 cm; 60 residuals, the largest 2.1 sigma" in said
    with pytest.raises(ValueError, match="has no inverse here: check exercises 8.1 to 8.3"):
        draw_drive(lambda omega, xi, *rest: (omega, xi), link)


def test_weights_marginal_blocks_and_correlations_are_said_in_numbers():
    said = draw_weights(lambda epsilon: (5 / epsilon + 3) / (1 / epsilon + 0.5), lambda epsilon: epsilon).alt
    assert "equal variances it is 5.33" in said
    assert draw_marginalised(np.eye(4), 2, np.ones((2, 2))).alt.endswith("100 % once poses are removed.")
    with pytest.raises(ValueError, match=r"expected \(2, 2\)"):
        draw_marginalised(np.eye(4), 2, np.eye(3))
    found = correlations(OMEGA)
    assert np.diag(found) == pytest.approx(1) and np.abs(found[0, 1:]).max() < 0.05
    drive = field_drive()
    said = draw_correlations(drive, BUILDERS).alt
    assert f"{100 * share(assemble(drive.constraints, drive.size, BUILDERS, 0)[0]):.0f} % of Omega" in said


def test_the_error_to_be_expected_is_that_of_many_tries_and_one_over_the_variance_is_the_best_weight(rng):
    drive = unlike_drive(3)
    sigmas = np.array([0.0 if each.kind == "start" else np.sqrt(each.epsilon) for each in drive.constraints])
    for power in (0.0, 2.0):
        weighted = [replace(each, epsilon=each.epsilon ** (power / 2)) for each in drive.constraints]
        omega, _ = assemble(weighted, drive.size, BUILDERS, 0)
        columns = np.zeros((drive.size, len(sigmas)))  # what a unit of each constraint's value adds to xi
        for number, each in enumerate(drive.constraints[1:], start=1):
            weight = each.epsilon ** (-power / 2)
            columns[each.first, number], columns[each.second, number] = -weight, weight
        drawn = sigmas[:, None] * rng.standard_normal((len(sigmas), 4000))
        errors = np.linalg.solve(omega, columns @ drawn)
        found = np.sqrt(2 * np.square(errors[len(drive.path) :]).mean())
        assert expected_error(drive, BUILDERS, power) == pytest.approx(found, rel=0.05)
    for seed in range(12):
        errors = [expected_error(unlike_drive(seed), BUILDERS, power) for power in POWERS]
        assert POWERS[int(np.argmin(errors))] == 2.0
    assert "The smallest is at p = 2." in draw_powers((np.array(POWERS) - 2) ** 2 + 0.1).alt


@pytest.mark.slow
def test_the_costs_are_the_recorded_ones_and_the_students_own(monkeypatch):
    monkeypatch.delenv("NAO_COURSE_STRICT", raising=False)

    def blank(omega, xi):
        raise NotImplementedError

    assert "100000 variables" in draw_costs().alt and "yours" not in draw_costs(blank).alt
    said = draw_costs(lambda omega, xi: scipy.sparse.linalg.spsolve(omega, xi)).alt
    assert "s for 100000 variables" in said.partition("yours, on this computer: ")[2]
    monkeypatch.setattr(costs, "PATIENCE", 0.0)
    assert "s for 3000 variables" in draw_costs(scipy.sparse.linalg.spsolve).alt
    with pytest.raises(ValueError, match="must return 300 numbers, .* NoneType: check exercise 8.6"):
        draw_costs(lambda omega, xi: None)
    monkeypatch.setenv("NAO_COURSE_STRICT", "1")
    assert "yours" not in draw_costs(lambda omega, xi: None).alt, "a kept solution has no times"
