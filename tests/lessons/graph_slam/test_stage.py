"""Lesson 08's challenge, and what it adds to the robot: a map of the drive, by two linear graphs."""

from itertools import combinations

import numpy as np
import pytest

from benchmarks.challenges.measurement_choice import CHOICE_ENTRIES
from nao_course.geometry import Pose
from nao_course.lessons.graph_slam.challenge import CHALLENGE, judge, make_graph
from nao_course.lessons.graph_slam.stage import STAGE
from nao_course.sim import OdometryNoise, SensorNoise, SimulatedNao, TorsoTilt, Truth
from nao_course.student import my_nao
from tests.lessons.driven import pipeline, robot
from tests.lessons.every import own, quotes, text

GRAPH = make_graph(3)


def after(graph, chosen):
    omega = graph.omega.copy()
    for pose, landmark, epsilon in (graph.candidates[each] for each in chosen):
        row = np.zeros(len(graph.xi))
        row[pose], row[landmark] = -1.0, 1.0
        omega += np.outer(row, row) / epsilon
    return np.linalg.inv(omega)


def test_the_score_is_the_largest_standard_deviation_that_is_left():
    for chosen in ([], [7], [7, 1, 30]):
        assert judge(chosen, GRAPH).score == pytest.approx(np.sqrt(np.diag(after(GRAPH, chosen)).max()))
    assert judge(np.array([7, 1]), GRAPH).columns["measurements"] == 2.0


def test_graphs_differ_and_can_be_made_again_and_three_one_after_the_other_are_not_the_best_three():
    graphs = [make_graph(seed) for seed in CHALLENGE.seeds]
    assert len({graph.omega.tobytes() for graph in graphs}) == len(graphs) == 40
    assert all(np.linalg.eigvalsh(graph.omega)[0] > 0 for graph in graphs)
    assert (make_graph(3).omega == GRAPH.omega).all() and make_graph(3).candidates == GRAPH.candidates
    better = list(CHOICE_ENTRIES.values())[-1]
    pairs = [
        (number, graph.worst_after(better(graph.omega, graph.xi, graph.candidates)))
        for number, graph in enumerate(graphs[:3])
    ]
    triples = list(combinations(range(60), 3))
    assert any(min(map(graphs[n].worst_after, triples[::7])) < left - 0.01 for n, left in pairs)


START, MARKS = Pose(0.4, 0.3, -0.2), [each for each in SimulatedNao().field.landmarks if each.kind != "cross"]
PERFECT = {
    "odometry_noise": OdometryNoise(0, 0, 0, 0),
    "sensor_noise": SensorNoise(0, 0),
    "tilt": TorsoTilt(0, 0),
}


def drive(steps=6, changed=(), **noise):
    """Walk and turn a little, and process a picture after each step; return the robot and the last result."""
    nao = robot(START, **noise)
    line = pipeline(STAGE.name, nao, **dict(changed))
    picture = nao.take_picture("bottom")
    seen = line.process(picture)
    for _ in range(steps):
        nao.walk(0.25)
        nao.turn(0.1)
        seen = line.process(picture)
    return nao, seen


def away(landmarks):
    """Return how far each estimated landmark is from each true one."""
    return np.linalg.norm(landmarks[:, None] - [(each.x, each.y) for each in MARKS], axis=2)


@pytest.mark.parametrize("failing", ["", *STAGE.uses])
def test_without_errors_the_map_has_each_landmark_in_its_place_once_also_after_a_function_failed(failing):
    def fails_once(*arguments):
        if not failed:
            failed.append(failing)
            raise RuntimeError("not yet")
        return own("08")[failing](*arguments)

    failed = []
    _, seen = drive(changed={failing: fails_once} if failing else {}, **PERFECT)
    assert failed == [failing] * bool(failing) and seen.complaints == ()
    found = seen.overlays[STAGE.name]
    apart = away(found.estimate.landmarks)
    assert apart.min(axis=1).max() < 1e-6
    assert len(set(apart.argmin(axis=1))) == len(apart) >= (5 if failing else 6)
    assert failing or found.text.startswith(f"{len(apart)} landmarks from 7 poses, ")


def test_a_frame_from_the_same_place_adds_nothing_and_measuring_does_not_change_how_the_robot_slips():
    nao = robot(START)
    again = pipeline(STAGE.name, nao)
    texts = {again.process(nao.take_picture("bottom")).overlays[STAGE.name].text for _ in range(3)}
    assert len(texts) == 1 and "from 1 pose, " in texts.pop()
    blind = robot(START)
    blind.take_picture("bottom")
    for _ in range(6):
        blind.walk(0.25)
        blind.turn(0.1)
    assert Truth(drive()[0]).pose == Truth(blind).pose


@pytest.mark.slow
def test_a_metre_ahead_makes_a_map_and_two_turns_on_the_spot_a_second_one_as_the_lesson_says(
    monkeypatch, tmp_path
):
    monkeypatch.setenv("NAO_COURSE_NOTEBOOKS", str(tmp_path))  # no earlier lesson: its stages are not needed
    panel = my_nao(upto="08", time_limit=60.0, **{name: own("08")[name] for name in STAGE.uses})

    def landmarks():
        return panel._own.latest.overlays[STAGE.name].estimate.landmarks

    for _ in range(5):
        panel.forward()
    assert len(landmarks()) == 7 and away(landmarks()).min(axis=1).max() < 0.21
    for _ in range(16):
        panel.right(np.radians(45))
    assert len(landmarks()) == 17 and len(MARKS) == 10
    quotes(text("08"), "about seven landmarks, each within about 20 cm", "about 17 instead of 10")


def test_the_map_stands_in_the_frame_of_the_start_within_its_ellipses_and_nonsense_is_said_in_words():
    _, seen = drive()
    found = seen.estimate
    off, spread = away(found.landmarks).min(axis=1), np.sqrt(found.landmark_covariances[:, 0, 0])
    assert off.max() < 0.3 and (off < 4 * spread + 0.05).mean() > 0.7
    assert (spread < 0.3).all(), "what nobody knows of the start is not the map's"
    assert not seen.overlays[STAGE.name].points.size, "stars are of other lessons"
    for wrong in (lambda omega, xi: None, lambda omega, xi: np.zeros((2, 2)), lambda omega, xi: "x"):
        _, seen = drive(steps=0, changed={"solve": wrong})
        (said,) = seen.complaints
        assert said.startswith(f"Without {STAGE.name}: ")
