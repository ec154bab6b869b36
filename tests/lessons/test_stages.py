"""What holds for the stage that each lesson adds to the robot; what it computes is tested in its lesson's folder."""

import pytest

from nao_course.exercises.lesson_names import meant
from nao_course.geometry import Pose
from nao_course.sim import Field, SimulatedNao
from nao_course.student.stages import all_stages
from nao_course.widgets.control_panel import Pipeline
from tests.lessons.every import NAMES, reference

STAGES = {stage.name: stage for stage in all_stages()}
# Stages that search or run a whole filter are broken in their lessons' own tests.
BROKEN = [
    (stage.name, used)
    for stage in STAGES.values()
    for used in stage.uses
    if stage.lesson[:2] not in ("08", "10", "11") and used != "choose_move"
]


def functions_of(stage):
    """Return the solutions' functions that a stage and those before it use, by their bare names."""
    uses = [(of.lesson, used) for of in (*(STAGES[name] for name in stage.after), stage) for used in of.uses]
    found = {}
    for lesson, used in uses:
        number, _, name = used.rpartition(":")
        found[name] = reference(meant(number, NAMES)[0] if number else lesson)[name]
    return found


@pytest.mark.parametrize(("name", "used"), BROKEN)
def test_what_fails_is_named_and_tried_again_and_nonsense_stops_nothing(name, used):
    stage, function = STAGES[name], used.rpartition(":")[2]
    functions, errors = functions_of(stage), [ZeroDivisionError("no")]
    right = functions[function]

    def broken(*given, **named):
        if errors:
            raise errors[0]
        return right(*given, **named)

    def drive(changed):
        """Yield what a pipeline complains about after each of three pictures."""
        nao = SimulatedNao(Field(2012), Pose(0.6, 0.5, -0.25), rng=41)
        stages = [*(STAGES[before] for before in stage.after), stage]
        pipeline = Pipeline(stages, functions | {function: changed}, nao, time_limit=60.0)
        for _ in range(3):
            nao.walk(0.05)
            yield pipeline.process(nao.take_picture("bottom")).complaints
            pipeline.retry()

    for_an_error = drive(broken)
    next(for_an_error)
    assert next(for_an_error)[0].startswith(f"Without {name}: ZeroDivisionError in {function}()")
    errors.clear()
    assert next(for_an_error) == ()
    assert [*drive(lambda *given, **named: None)][1][0].startswith(f"Without {name}: ")
