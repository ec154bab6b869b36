"""The panels: steps, worlds and initial estimates, given parts, and the edges of H."""

from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.lessons.pose_graphs import EdgePanel, RelaxPanel
from nao_course.lessons.pose_graphs.panels import relaxing
from nao_course.lessons.pose_graphs.panels.edges import first_edges, rows_of
from nao_course.lessons.pose_graphs.panels.relaxing import REAL, draw_map, world_named
from nao_course.lessons.pose_graphs.worlds import small_world
from tests.lessons.every import blank
from tests.lessons.pose_graphs.own import OWN


def panel(**changed):
    functions = {name: OWN[name] for name in ("linearize", "gauss_newton")}
    return RelaxPanel(**{**functions, **changed})


def test_a_step_relaxes_the_graph_and_a_step_back_unrelaxes_it_and_what_can_be_found_is_there():
    shown = panel()
    assert "off by 2.62 m." in shown.summary() and "H has 720 rows" in shown.summary()
    shown.set(step=3)
    after = shown.summary()
    shown.set(step=2)
    assert "Step 3: chi2" in after and "off by 2.62 m." not in after and "Step 2: chi2" in shown.summary()
    shown.reset()
    assert "odometry, chi2 123,111, off by 2.62 m." in shown.summary()
    shown = panel()
    shown.set(guess="each heading off at random, σ 60°", step=10)
    stuck = shown.summary()
    shown.set(guess="each position off at random, σ 100 m", step=4)
    home = shown.summary()
    shown.set(world="a loop that drifted by 90°", guess="odometry", step=1)
    assert "off by 13.12 m." in stuck and "off by 0." in home
    assert "chi2 36,663 -> 73,390" in shown.summary()
    shown.set(world="the half field", step=0)
    assert "Blocks of H" in shown.shown.pictures


def test_the_given_solver_moves_the_map_as_the_solution_does():
    given, own = RelaxPanel(), panel()
    for step in (1, 2, 4):
        given.set(step=step)
        own.set(step=step)
        assert given.summary().splitlines()[1] == own.summary().splitlines()[1]
    assert "The given solver." in given.summary() and "Your code: gauss_newton." in own.summary()


def test_functions_that_are_not_finished_are_replaced_by_given_ones_and_the_students_are_used():
    shown = panel(gauss_newton=blank)
    shown.set(step=2)
    assert "Blocks of H" in shown.shown.pictures and "off by 0.23 m." in shown.summary()
    assert "The given solver." in shown.summary() and shown.error is None
    assert "Finish exercise 9.5" in panel(linearize=blank).summary()
    parts = {name: OWN[name] for name in ("landmark_residual", "pose_residual")}
    shown = RelaxPanel("the half field", **parts, pose_residual_jacobians=blank)
    shown.set(step=3)
    assert "landmark_residual, pose_residual." in shown.summary()
    assert "off by 0.10 m." in shown.summary()
    shown = RelaxPanel(pose_residual=lambda *ends: -0.5 * OWN["pose_residual"](*ends))
    assert "chi2 30,778" in shown.summary(), "it is the student's residual that is squared"
    with pytest.raises(TypeError, match="no part pose_residuals"):
        RelaxPanel(pose_residuals=OWN["pose_residual"])


def test_a_recorded_building_can_be_chosen():
    shown = RelaxPanel()
    shown.set(world=REAL)
    assert "from the map with the smallest chi2" in shown.summary() and "off by 0.00" not in shown.summary()
    shown.set(step=4)
    assert "off by 0.00 m from the map with the smallest chi2" in shown.summary()
    drawn = draw_map(world_named(REAL), world_named(REAL).odometry, SimpleNamespace(world=REAL, step=0))
    named = [text.get_text() for each in drawn.figure.legends for text in each.get_texts()]
    assert "true path" not in named


def test_each_heading_of_the_initial_estimate_is_off_by_another_angle_and_the_map_moves_in_still_axes():
    world, limits = world_named("a building"), set()
    states = relaxing.initial_estimate(world, "each heading off at random, σ 20°")
    away = np.degrees(states - world.truth)[5::3]
    assert 17 < away.std() < 23 and abs(away.mean()) < 4
    scattered = relaxing.initial_estimate(world, "each position off at random, σ 100 m")
    for step in (0, 1, 3):
        states = OWN["gauss_newton"](world.graph, scattered, step)[0]
        [ax] = draw_map(world, states, SimpleNamespace(world="a building", step=step)).figure.axes
        limits.add((*ax.get_xlim(), *ax.get_ylim()))
    assert len(limits) == 1


@pytest.mark.parametrize(
    ("count", "rows"), [(2, [3, 4, 5, 6, 7, 8]), (9, [24, 25, 26, 0, 1, 2]), (13, [18, 19, 20, 29, 30])]
)
def test_an_edge_frames_the_rows_of_its_two_ends(count, rows):
    world = small_world()
    assert rows_of(world.graph, count - 1) == rows
    before, after = (
        OWN["linearize"](first_edges(world.graph, edges), world.odometry)[0].toarray()
        for edges in (count - 1, count)
    )
    assert set(np.flatnonzero(np.abs(after - before).max(axis=0)).tolist()) == set(rows)


def test_the_edge_panel_shows_the_students_entries_where_there_are_some():
    shown = EdgePanel(OWN["linearize"])
    assert "Edge 9: from pose 8 to pose 0." in shown.summary() and "207 of 961 entries" in shown.summary()
    shown.set(count=13)
    assert "landmark B" in shown.summary() and "H" in shown.shown.pictures
    assert "Finish exercise 9.5" in EdgePanel(blank).summary()
    assert "of your H" not in EdgePanel().summary()
