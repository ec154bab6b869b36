"""A lesson 90_toy whose checks the student's side knows, and a stage of the robot that uses its two functions."""

import pytest

from nao_course.exercises import checking
from nao_course.exercises.definitions import load_definitions
from nao_course.instructor.authoring.plans import load_plan, publish
from nao_course.student import notebooks, overview, robot, stages, strip
from nao_course.widgets.control_panel import Overlay, Stage
from tests.toy import toy


@pytest.fixture(scope="session")
def public(tmp_path_factory):
    """What a student's copy carries of the lesson."""
    solved = load_definitions(toy.solutions(tmp_path_factory.mktemp("course") / "s") / "90_toy.ipynb")
    return publish("90_toy", load_plan(toy.HERE / "exercises" / "90_toy.py"), solved)


@pytest.fixture(autouse=True)
def lesson(public, monkeypatch):
    """There is a lesson 90_toy and no other; the course's own lessons are left as they are."""
    for module in (notebooks, checking):
        monkeypatch.setattr(module, "read_public", {"90_toy": public}.__getitem__)
    monkeypatch.setattr(overview, "read_public", {"90_toy": public}.__getitem__)
    for module in (notebooks, overview, stages):
        monkeypatch.setattr(module, "lessons", lambda: ["90_toy"])
    monkeypatch.delenv("NAO_COURSE_NOTEBOOKS", raising=False)
    monkeypatch.delenv("NAO_COURSE_STRICT", raising=False)


def look_around(student, nao):
    """Two points on the map, as far away as the student's functions say."""

    def look(frame):
        away = student.clamp(2.0, 0.0, 1.0)
        return Overlay(points=[(away, 0.0), (away, 0.5)], text=f"{away:.1f} m away")

    return look


@pytest.fixture
def stage(monkeypatch):
    """The robot's only stage."""
    made = Stage("distances", "90_toy", ("clamp", "mean_of_positive"), look_around)
    for module in (stages, strip, robot):
        monkeypatch.setattr(module, "all_stages", lambda: [made])
    monkeypatch.setattr(stages, "PLANNED", {"90": "distances", "91": "goal posts"})
    return made
