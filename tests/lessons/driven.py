"""A robot whose pictures go through the stages of lessons, with the solutions' functions or others in their places."""

import numpy as np

from nao_course.exercises.lesson_names import meant
from nao_course.geometry import Pose
from nao_course.sim import SimulatedNao, Truth
from nao_course.student.stages import all_stages
from nao_course.widgets.control_panel import Pipeline
from tests.lessons.every import NAMES, reference

STAGES = {stage.name: stage for stage in all_stages()}
POSE = Pose(0.6, 0.5, -0.25)


def robot(pose=POSE, **more):
    return SimulatedNao(pose=pose, rng=41, **more)


def functions_of(stage):
    """Return the solutions' functions that a stage and those before it use, by their bare names."""
    uses = [(of.lesson, used) for of in (*(STAGES[name] for name in stage.after), stage) for used in of.uses]
    found = {}
    for lesson, used in uses:
        number, _, name = used.rpartition(":")
        found[name] = reference(meant(number, NAMES)[0] if number else lesson)[name]
    return found


def pipeline(name, nao, *before, **changed):
    """Return the pipeline of a stage behind others, which are those that it needs unless others are given."""
    stage = STAGES[name]
    before = before or [STAGES[each] for each in stage.after]
    return Pipeline([*before, stage], functions_of(stage) | changed, nao, time_limit=60.0)


def look(name, nao=None, *before, **changed):
    """Return what a stage makes of a robot's first picture."""
    nao = nao or robot()
    return pipeline(name, nao, *before, **changed).process(nao.take_picture("bottom"))


def off(nao, pose):
    """Return the error (x, y, theta) of an estimated pose."""
    return np.asarray(pose) - Truth(nao).pose.as_array()
