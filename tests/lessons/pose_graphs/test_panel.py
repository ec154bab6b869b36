"""The relaxing panel: steps, worlds and guesses, and what is not written yet."""

from types import SimpleNamespace

from nao_course.lessons.pose_graphs import RelaxPanel
from nao_course.lessons.pose_graphs.matrices import block_picture
from nao_course.lessons.pose_graphs.panel import draw_map, first_guess, world_named
from tests.lessons.pose_graphs.own import OWN


def panel(**changed):
    functions = {name: OWN[name] for name in ("linearize", "gauss_newton")}
    return RelaxPanel(**{**functions, **changed})


def blank(*given):
    raise NotImplementedError


def test_a_step_relaxes_the_graph_and_a_step_back_unrelaxes_it():
    shown = panel()
    assert "Off by 2.62 m." in shown.summary() and "H has 720 rows" in shown.summary()
    shown.set(step=3)
    after = shown.summary()
    shown.set(step=2)
    assert "Step 3: chi2" in after and "Off by 2.62 m." not in after and "Step 2: chi2" in shown.summary()
    shown.reset()
    assert "First guess: odometry. Off by 2.62 m." in shown.summary()


def test_what_can_be_found_is_there():
    shown = panel()
    shown.set(guess="headings off by 60°", step=10)
    stuck = shown.summary()
    shown.set(guess="positions off by 100 m", step=4)
    home = shown.summary()
    shown.set(world="a loop that drifted by 90°", guess="odometry", step=1)
    assert "Off by 13.12 m." in stuck and "Off by 0." in home
    assert "chi2 36,663 -> 73,390" in shown.summary()
    shown.set(world="the half field", step=0)
    assert set(shown.shown.pictures) == {"Graph", "Blocks of H"} or "Blocks of H" in shown.shown.pictures


def test_the_player_goes_over_all_steps():
    shown = panel()
    shown._widgets["forwards"].click()  # where no kernel runs, to play is to see the end
    assert shown.values.step == 10


def test_what_is_not_written_is_named_and_the_first_guess_is_shown():
    shown = panel(gauss_newton=blank)
    assert "Blocks of H" in shown.shown.pictures
    shown.set(step=1)
    assert "Finish exercise 9.6" in shown.summary()
    assert "Finish exercise 9.5" in panel(linearize=blank).summary()


def test_the_map_moves_and_its_axes_do_not():
    world, limits = world_named("a building"), set()
    for step in (0, 1, 3):
        states = OWN["gauss_newton"](world.graph, first_guess(world, "positions off by 100 m"), step)[0]
        [ax] = draw_map(world, states, SimpleNamespace(world="a building", step=step)).figure.axes
        limits.add((*ax.get_xlim(), *ax.get_ylim()))
    assert len(limits) == 1


def test_blocks_of_h_are_as_large_for_every_graph():
    sizes = set()
    for name in ("a building", "the half field"):
        world = world_named(name)
        H = OWN["linearize"](world.graph, world.odometry)[0]
        sizes.add(block_picture(H, world.graph.poses).shape)
    assert sizes == {(402, 402, 3)}
