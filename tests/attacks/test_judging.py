"""An answer is judged in the grader itself: whatever its numbers say, that takes no memory and time to speak of."""

import time
import tracemalloc
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

from nao_course.exercises import judging
from nao_course.exercises.checking import read_public
from nao_course.exercises.running import Outcome
from tests.paths import PROJECT

LESSONS = sorted(path.stem for path in (PROJECT / "nao_course" / "exercises" / "checks").glob("*.bin"))
CHANGES = {
    "far away": lambda array: array * 1e4,
    "farther than numbers go": lambda array: array * 1e400,
    "often": lambda array: np.repeat(array, 300, axis=0) if array.ndim and len(array) < 1000 else array,
    "not numbers": lambda array: np.full_like(array, np.nan),
    "nothing": lambda array: array[:0] if array.ndim else array,
}
MEMORY = 200 * 2**20  # bytes: the largest answers have 30 MB
SECONDS = 5.0  # of processor time


def changed(value, change):
    """A value whose numbers are others."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "iuf":
        return change(value.astype(float))
    if isinstance(value, float):
        return float(change(np.array([value])).sum())
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return value
    if isinstance(value, list | tuple):
        return type(value)(changed(each, change) for each in value)
    if isinstance(value, dict):
        return {key: changed(each, change) for key, each in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        try:
            return replace(
                value, **{each.name: changed(getattr(value, each.name), change) for each in fields(value)}
            )
        except (ValueError, TypeError):
            return value
    return value


@pytest.mark.slow
@pytest.mark.parametrize("lesson", LESSONS)
@pytest.mark.parametrize("way", CHANGES)
def test_an_answer_of_any_numbers_is_judged_with_little(lesson, way):
    for exercise in read_public(lesson).exercises:
        case = exercise.cases[0]
        with np.errstate(all="ignore"):
            answer = changed(case.expected, CHANGES[way])
        tracemalloc.start()
        began = time.process_time()
        try:
            with np.errstate(all="ignore"):
                judging.judge(exercise.comparison, case, Outcome("value", answer))
        except (ValueError, TypeError, OverflowError, IndexError):
            pass  # the grader says that it could not be read
        finally:
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
        assert peak < MEMORY, f"{exercise.number} {exercise.name}: {peak / 2**20:.0f} MB"
        assert time.process_time() - began < SECONDS, exercise.name
