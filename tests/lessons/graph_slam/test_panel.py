"""The graph panel: constraints arrive, the matrix fills in, and what is missing is named."""

import numpy as np
import pytest

from nao_course.lessons.graph_slam.drives import field_drive
from nao_course.lessons.graph_slam.matrices import NEGATIVE, POSITIVE
from nao_course.lessons.graph_slam.panel import NEAR, GraphPanel, clicked
from nao_course.plotting.matrix_signs import CELL, paint_matrix
from tests.lessons.graph_slam.test_systems import link, start


def panel(**changed):
    functions = {
        "add_initial_position": start,
        "add_relative_motion": link,
        "add_relative_measurement": link,
        "solve": np.linalg.solve,
    }
    return GraphPanel(**{**functions, **changed})


def test_a_cell_has_the_colour_of_its_sign_and_the_edge_nearest_to_a_click_is_selected():
    painted = paint_matrix(np.array([[2.0, -1.0], [-1.0, 0.0]]), 1, (0,))
    middle = CELL // 2
    for place, colour in (
        ((middle, middle), POSITIVE),
        ((middle, CELL + middle), NEGATIVE),
        ((-middle,) * 2, "#ffffff"),
    ):
        assert "#{:02x}{:02x}{:02x}".format(*painted[place]) == colour
    assert (painted[2, 2] != painted[middle, middle]).any()
    ends = np.array([[[0.0, 0.0], [100.0, 0.0]], [[0.0, 50.0], [100.0, 50.0]], [[30.0, 20.0], [30.0, 20.0]]])
    assert clicked(ends, (60, 4)) == 0 and clicked(ends, (60, 46)) == 1 and clicked(ends, (32, 21)) == 2
    assert clicked(ends, (100 + int(NEAR) + 1, 0)) is None and clicked(ends[:0], (0, 0)) is None
    assert clicked(ends * np.nan, (0, 0)) is None, "an edge without estimates cannot be clicked"


def test_each_constraint_fills_the_matrix_and_moves_the_map_of_which_nothing_of_the_last_one_is_kept():
    shown = panel()
    first = shown.shown.pictures["Your map"].copy()
    shown.set(count=60)
    assert "Map off by 4 cm." in shown.summary() and set(shown.shown.pictures) == {"Your Omega", "Your map"}
    full = shown.shown.pictures["Your map"].copy()
    shown.set(variance="x 10000")  # leaves the path to odometry
    assert "Map off by 4 cm." not in shown.summary()
    shown.set(variance="x 1/100")
    assert "Map off by 4 cm." in shown.summary()
    shown.reset()
    assert (shown.shown.pictures["Your map"] == first).all() and (full != first).any()
    shown.set(count=1)
    assert "start: x0 is at (0.30, -1.30) m" in shown.summary() and "1 of 625 entries" in shown.summary()
    assert "No landmark." in shown.summary()
    shown.set(count=25, order="odometry first")
    assert "Map off by 53 cm." in shown.summary()


def test_a_clicked_edge_shows_the_block_that_it_adds_to_omega():
    shown = panel()
    shown.set(count=60)
    newest = shown.shown.pictures["Your Omega"].copy()
    assert "You selected" not in shown.summary() and "L5" in str(next(iter(shown.shown.tables.values())))
    middle = shown._map.pixels(field_drive().path[3:5]).mean(axis=0)
    shown.set(edge=tuple(int(each) for each in middle))
    assert "You selected a motion: x4 - x3 = (0.42, 0.43) m." in shown.summary()
    (table,) = shown.shown.tables.values()
    assert table.rows == (("x3", "44.4", "-44.4", "-18.6"), ("x4", "-44.4", "44.4", "18.6"))
    painted = shown.shown.pictures["Your Omega"]
    changed = np.argwhere((painted != newest).any(axis=2)) // CELL
    assert {(3, 3), (3, 4), (4, 3), (4, 4)} <= {tuple(cell) for cell in changed.tolist()}


def test_the_error_of_solve_without_a_start_is_shown_and_an_omega_with_nan_is_reported():
    def refuse(omega, xi):
        raise ValueError("nothing holds 0, 1")

    shown = panel(solve=refuse)
    assert "There is no map. Your solve says: nothing holds 0, 1" in shown.summary()
    both = {title: pixels.shape for title, pixels in panel().shown.pictures.items()}
    assert {title: pixels.shape for title, pixels in shown.shown.pictures.items()} == both
    shown.set(held=False, count=1)
    assert "No constraint has arrived." in shown.summary()
    # A panel without its map would lay its controls out in other places
    assert {title: pixels.shape for title, pixels in shown.shown.pictures.items()} == both
    spoilt = panel(add_relative_motion=lambda omega, xi, *given: (omega * np.nan, xi))
    assert "contains NaN or infinity: check exercises 8.1 to 8.3" in spoilt.summary()


@pytest.mark.parametrize(
    ("answer", "came"),
    [
        (None, "NoneType"),
        (lambda xi: xi[1:], "shape (10,)"),
        (lambda xi: xi * np.nan, "NaN or infinity among them"),
    ],
)
def test_an_answer_that_is_not_a_solution_is_reported_and_not_quoted_as_an_error_of_solve(answer, came):
    shown = panel(solve=lambda omega, xi: answer(xi) if callable(answer) else answer)
    assert f"There is no map. Your solve must return 11 numbers, and returned {came}" in shown.summary()
    assert "solve says" not in shown.summary() and "No landmark" not in shown.summary()
