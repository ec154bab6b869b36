"""What a declaration's values have to be: said in the author's words, before anything is built of them."""

import dis
import math
import reprlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, fields
from types import CodeType
from typing import Any

from nao_course.codec import CodecError, encode
from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.comparison import Comparison
from nao_course.exercises.comparisons.values import Between
from nao_course.exercises.earlier import in_words, split_use
from nao_course.exercises.exercise import (
    Exercise,
    LessonPlan,
    Mistake,
    PublicExercise,
    Question,
    Sibling,
    Written,
)
from nao_course.exercises.running import find_driver

MOST_SECONDS = 60.0  # of one call: a submission has 120 s for everything
# Rules of docs/write_a_lesson.md that a short lesson or a lab need not keep: all others protect students
WAIVABLE = ("2", "3", "5", "6", "8", "11", "12", "15")
_Rules = Mapping[str, tuple[Callable[[Any], bool], str]]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _is_amount(value: Any) -> bool:
    return _is_number(value) and value >= 0


def _are_amounts(value: Any) -> bool:
    return _is_amount(value) or (isinstance(value, tuple) and bool(value) and all(map(_is_amount, value)))


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip())


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and value.isidentifier()


def _are_texts(value: Any) -> bool:
    return isinstance(value, tuple | list) and all(map(_is_text, value))


def _are_named_texts(value: Any) -> bool:
    return isinstance(value, Mapping) and all(map(_is_text, (*value, *value.values())))


def _are(kind: type) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, tuple | list) and all(isinstance(each, kind) for each in value)


_NAME = (_is_name, "a name such as 'hue_mask'")
_POINTS = (_is_amount, "a number, 0 or more")
_TEXT = (_is_text, "a text")
_EXERCISE: _Rules = {
    "name": _NAME,
    "points": _POINTS,
    "public": (callable, "a function that takes nothing and returns a list of Case"),
    "hidden": (callable, "a function that takes a random generator and returns a list of Case"),
    "hints": (lambda value: _are_texts(value) and len(value) == 2, "two texts, ('Where to look.', 'How.')"),
    "sibling": (
        lambda value: (
            value is None
            or (isinstance(value, Sibling) and all(map(_is_text, (value.alike, value.code, value.output))))
        ),
        "Sibling('What is alike.', 'print(1)', '1')",
    ),
    "mistakes": (_are(Mistake), "a list of Mistake"),
    "alternatives": (
        lambda value: (
            isinstance(value, Mapping) and all(map(_is_text, value)) and all(map(callable, value.values()))
        ),
        'a dict of functions by their titles, {"a loop": function}',
    ),
    "comparison": (
        lambda value: isinstance(value, Comparison),
        "a comparison with its brackets, such as Close()",
    ),
    "stars": (lambda value: type(value) is int and 1 <= value <= 3, "1, 2 or 3"),
    "uses": (_are_texts, "a list of names of earlier exercises"),
    "driver": (lambda value: isinstance(value, str), "the name of a driver"),
    "with_reference": (
        lambda value: _is_number(value) and 0 <= value <= 1,
        "a fraction of the points, 0 to 1",
    ),
    "equivalents": (_are_named_texts, 'a dict of reasons by line, {"return x": "why it is right"}'),
    "parts": (
        lambda value: (
            isinstance(value, Mapping)
            and all(map(_is_text, value))
            and all(_is_number(each) and each > 0 for each in value.values())
        ),
        'a dict of weights above 0 by part, {"move": 1, "estimate": 2}',
    ),
    "seconds": (
        lambda value: _is_number(value) and 0 < value <= MOST_SECONDS,
        f"more than 0 and at most {MOST_SECONDS:g} (seconds of one call)",
    ),
}
_MISTAKE: _Rules = {
    "name": _TEXT,
    "function": (callable, "the wrong function"),
    "message": (_is_text, "a sentence that helps"),
}
_QUESTION: _Rules = {
    "name": _NAME,
    "text": _TEXT,
    "choices": (
        lambda value: _are_named_texts(value) and len(value) >= 2,
        'a dict of replies by choice, {"Yes": "Why not.", "No": "Why."}',
    ),
    "right": (_is_text, "one of the choices"),
}
_WRITTEN: _Rules = {"name": _NAME, "points": _POINTS, "question": _TEXT, "rubric": _TEXT}
_CASE: _Rules = {
    "args": (lambda value: isinstance(value, tuple), "a tuple, Case((1.0,)) with its comma"),
    "name": (lambda value: isinstance(value, str), "a few words"),
    "kwargs": (
        lambda value: isinstance(value, dict) and all(map(_is_name, value)),
        "a dict of values by the argument's name",
    ),
}


def declaration_problems(plan: LessonPlan) -> Iterator[str]:
    """Yield what is wrong with a plan's values, of any types: exercise or question, value, and what is allowed.

    None of its functions is called.
    """
    kinds = (("exercises", Exercise), ("questions", Question), ("written", Written))
    for field, kind in kinds:
        value = getattr(plan, field)
        if not _are(kind)(value):
            yield f"PLAN: {field} must be a list of {kind.__name__}, got {_shown(value)}"
    if not _are_named_texts(plan.waived):
        yield f'PLAN: waived must be a dict of reasons by rule, {{"3": "a lab"}}, got {_shown(plan.waived)}'
    elif kept := sorted({*plan.waived} - {*WAIVABLE}):
        yield f"PLAN: the rules {', '.join(kept)} cannot be waived; a plan may waive {', '.join(WAIVABLE)}"
    for exercise in _all_of(plan.exercises, Exercise):
        yield from _exercise_problems(exercise)
    for question in _all_of(plan.questions, Question):
        wrong = list(_problems(question, _QUESTION, _called(question)))
        yield from wrong
        if not wrong and question.right not in question.choices:
            yield f"{question.name}: its right answer is not one of its choices"
    for written in _all_of(plan.written, Written):
        yield from _problems(written, _WRITTEN, _called(written))


def case_problems(exercise: Exercise, cases: Any, kind: str) -> Iterator[str]:
    """Yield what is wrong with the cases that an exercise's `public` or `hidden` (the kind) returned."""
    if not _are(Case)(cases):
        yield f"{exercise.name}: its {kind} cases must be a list of Case, got {_shown(cases)}"
    elif not cases:
        yield f"{exercise.name}: no {kind} cases"
    for number, case in enumerate(_all_of(cases, Case), start=1):
        where = f"{exercise.name}: {kind} case {number}"
        yield from _problems(case, _CASE, where)
        if isinstance(exercise.comparison, Between) and not _is_interval(case.expected):
            yield f"{where}: Between wants expected=(low, high), got {_shown(case.expected)}"


def _is_interval(value: Any) -> bool:
    return (
        isinstance(value, tuple | list)
        and len(value) == 2
        and all(map(_is_number, value))
        and value[0] <= value[1]
    )


def _exercise_problems(exercise: Exercise) -> Iterator[str]:
    where = _called(exercise)
    yield from _problems(exercise, _EXERCISE, where)
    for mistake in _all_of(exercise.mistakes, Mistake):
        yield from _problems(mistake, _MISTAKE, f"{where}: mistake {_shown(mistake.name)}")
    if isinstance(exercise.comparison, Comparison):
        yield from _comparison_problems(exercise.comparison, where)
    if exercise.driver and isinstance(exercise.driver, str):
        try:
            find_driver(exercise.driver)
        except (ValueError, ImportError) as error:
            yield f"{where}: driver: {error}"


def _comparison_problems(comparison: Comparison, where: str) -> Iterator[str]:
    """Yield the problems of a comparison's fields: tolerances must be amounts, and names a tuple of texts."""
    for field in fields(comparison):  # type: ignore[arg-type]  # every comparison is a dataclass
        value = getattr(comparison, field.name)
        called = f"{where}: {type(comparison).__name__}'s {field.name}"
        if isinstance(field.default, float) and not _are_amounts(value):
            yield f"{called} must be a number, 0 or more, or a tuple of them, one a column; got {_shown(value)}"
        if (field.default is MISSING or isinstance(field.default, tuple)) and isinstance(value, str):
            yield f"{called} must be a tuple, got the text {_shown(value)}"
    try:
        encode(comparison)
    except CodecError as error:
        yield (
            f"{where}: its comparison cannot travel with the check data ({error}): a law or a comparison of a lesson's "
            "own stands in nao_course/lessons/NAME/, with @register before it"
        )


def _problems(value: Any, rules: _Rules, where: str) -> Iterator[str]:
    for field, (holds, wanted) in rules.items():
        given = getattr(value, field)
        if not holds(given):
            yield f"{where}: {field} must be {wanted}, got {_shown(given)}"


def _all_of(values: Any, kind: type) -> list[Any]:
    return [each for each in values if isinstance(each, kind)] if isinstance(values, Sequence) else []


def _called(declared: Exercise | Question | Written) -> str:
    """Return how a message names an exercise or question: by its name if it has one."""
    return declared.name if _is_name(declared.name) else f"{type(declared).__name__} {_shown(declared.name)}"


def _shown(value: Any) -> str:
    short = reprlib.Repr()
    short.maxstring = short.maxother = 60
    return short.repr(value)


def undeclared_uses(
    plan: LessonPlan, exercise: Exercise, public: PublicExercise, function: Callable[..., Any]
) -> Iterator[str]:
    """Yield a sentence for each earlier exercise that a solution calls without a declaration in `uses`."""
    uses = list(exercise.uses)
    for use in uses:  # the list grows in this loop
        if ":" not in use:
            uses += [each for each in plan[use].uses if each not in uses]
    declared = set(map(split_use, uses))
    others = {each.name for each in plan.exercises} - {exercise.name}
    for name in sorted(others & _global_names(function)):
        if ("", name) not in declared:
            yield f"{exercise.name}: its solution uses {name}; add {name!r} to its `uses`"
    for use in sorted({each.use for each in public.earlier if split_use(each.use) not in declared}):
        yield f"{exercise.name}: it calls {in_words(use)}; add {use!r} to its `uses`"


def _global_names(function: Any) -> set[str]:
    """Return the global names that a function, or the methods of a class, look up."""
    if isinstance(function, type):
        return set().union(*(_global_names(each) for each in vars(function).values()))
    code = function if isinstance(function, CodeType) else getattr(function, "__code__", None)
    if code is None:
        return set()
    found = {str(each.argval) for each in dis.get_instructions(code) if each.opname.startswith("LOAD_GLOBAL")}
    return found.union(*(_global_names(each) for each in code.co_consts if isinstance(each, CodeType)))
