"""A lesson as it is graded: its exercises with hidden cases, and what is expected of them."""

from __future__ import annotations

import ast
import hashlib
import json
import re
import zlib
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial
from importlib import metadata
from pathlib import Path
from typing import Any

from nao_course.exercises import lesson_names
from nao_course.exercises.case import Case
from nao_course.exercises.checking import unpack
from nao_course.exercises.earlier import resolved_by, split_use
from nao_course.exercises.exercise import SECONDS, Exercise, LessonPlan, PublicExercise, Written
from nao_course.exercises.notebook_text import read_cells
from nao_course.exercises.outline import FOLDER as OUTLINES
from nao_course.exercises.outline import read_outline
from nao_course.instructor.authoring.course import Course, LessonError
from nao_course.instructor.authoring.plans import hidden_cases, load_solution, publish, solutions_beside
from nao_course.instructor.authoring.proofs import Proofs
from nao_course.instructor.autograding.secret import keyed

LIBRARY = Path(__file__).parents[2]
_NOT_SCORING = ("instructor", "plotting", "widgets", "cli.py", "homework.py")
RULES = "6"  # how it is graded; another number has everything graded again


@dataclass(frozen=True)
class Task:
    """An exercise as it is graded; no code, so that it can be sent to another process.

    `hidden` has the hidden cases with expected answers, and `second` the same drawn anew, for a student who gets a
    second try and may remember the first. `with_reference` is the fraction of the points for an exercise that is right
    only with the reference's `uses`, the earlier exercises that it calls. `mistakes` are names by their messages, and
    `parts` weights of the parts that earn points of their own, empty if all hidden cases count together.
    """

    public: PublicExercise
    hidden: tuple[Case, ...]
    second: tuple[Case, ...] = ()
    uses: tuple[str, ...] = ()
    with_reference: float = 1.0
    mistakes: Mapping[str, str] = field(default_factory=dict)
    parts: Mapping[str, float] = field(default_factory=dict)

    def points_of(self, right: Collection[str]) -> float:
        """Return the points that some right parts earn together."""
        if not self.parts:
            return 0.0
        share = sum(weight for part, weight in self.parts.items() if part in right) / sum(self.parts.values())
        return self.public.points * share

    def notes_on(self, right: Collection[str]) -> tuple[str, ...]:
        """Return a note for the student if some right parts earn points; otherwise nothing."""
        if not (earned := self.points_of(right)):
            return ()
        return (f"{earned:g} of {self.public.points:g} points for the right parts: {', '.join(right)}.",)


@dataclass(frozen=True)
class EarlierLesson:
    """An earlier lesson whose functions an assignment uses: its solution notebook, and its released set-up cell."""

    lesson: str
    reference: Path
    setup: str


@dataclass(frozen=True)
class UsedClass:
    """A class of the reference that other exercises use: its objects can be made only where its source is.

    The source is the cell that defines it.
    """

    source: str
    uses: tuple[str, ...] = ()


@dataclass(frozen=True)
class Assignment:
    """A lesson, such as "01_hsl_filtering", as it is graded, with exercises and questions in the lesson's order.

    `reference` is the solution notebook, `setup` the released set-up cell, and `hash` depends on everything that
    affects a score, except the submission. `seconds` limit the loading of a notebook; each exercise has the limit for
    its calls. `version` is the release's. `earlier` are the lessons whose functions its exercises use directly or
    indirectly, in their order, and `classes` the classes among these, by "name" or "01:name".
    """

    lesson: str
    tasks: tuple[Task, ...]
    written: tuple[Written, ...] = ()
    reference: Path = Path()
    setup: str = ""
    hash: str = ""
    seconds: float = SECONDS
    version: str = ""
    earlier: tuple[EarlierLesson, ...] = ()
    classes: Mapping[str, UsedClass] = field(default_factory=dict)

    def anew(self) -> Assignment:
        """Return the assignment with other hidden cases, which are the same for every retry."""
        return replace(self, tasks=tuple(replace(each, hidden=each.second) for each in self.tasks))

    def within(self, seconds: float) -> Assignment:
        """Return the assignment with other time limits."""
        tasks = [replace(each, public=replace(each.public, seconds=seconds)) for each in self.tasks]
        return replace(self, tasks=tuple(tasks), seconds=seconds)


def prepare(course: Course, lesson: str, secret: bytes) -> Assignment:
    """Draw a lesson's hidden cases, the same for the same secret of the instructor, and compute the expected answers.

    Raise a LessonError, PlanError or FileNotFoundError if there is no such lesson, its declaration does not fit its
    solution, or it has not been built.
    """
    (name,) = course.names([lesson])
    plan, notebook = course.plan(name), course.solutions / f"{name}.ipynb"
    _need(notebook)
    setup = _released_setup(course, name)
    reference = load_solution(notebook)
    with resolved_by(solutions_beside(notebook)):
        tasks = tuple(
            _task(each, known, reference[each.name], partial(keyed, secret, "hidden cases", name, each.name))
            for each, known in zip(plan.exercises, _published(course, name, plan, reference), strict=True)
        )
    earlier = tuple(
        EarlierLesson(each, course.solutions / f"{each}.ipynb", _released_setup(course, each))
        for each in lessons_used(course, name)
    )
    declaration = course.solutions / "exercises" / f"{name}.py"
    told: list[object] = [
        library_digest(name),
        (RULES, metadata.version("nao-course"), name, keyed(secret, "assignment"), setup),
        read_cells(notebook),
        declaration.read_text(encoding="utf-8") if declaration.exists() else "",
        plan.points,
        read_outline(name).cells,
    ]
    if earlier:
        told += [
            (each.lesson, each.setup, read_cells(each.reference), read_outline(each.lesson).cells)
            for each in earlier
        ]
    digest = hashlib.sha256(json.dumps(told).encode()).hexdigest()
    return Assignment(
        name,
        tasks,
        tuple(replace(each, numbers=None) for each in plan.written),  # no code, so that it can be sent
        notebook,
        setup,
        digest,
        version=course.version,
        earlier=earlier,
        classes=_classes(course, name),
    )


@cache
def library_digest(lesson: str) -> str:
    """Hash the part of the library that a lesson's scores can depend on: all that students import except display code.

    Of the lessons' folders, only its own counts. The hash is of names and sources, and the same in any folder and
    system.
    """

    def counts(inside: Path) -> bool:
        room = inside.parts[0]
        elsewhere = (
            room == "lessons" and len(inside.parts) > 2 and inside.parts[1] != lesson.partition("_")[2]
        )
        return room not in _NOT_SCORING and not elsewhere and inside.suffix != ".json"

    return _sources_digest(counts)


@cache
def package_digest() -> str:
    """Hash the whole package, with the instructor's side: two machines with the same digest grade alike.

    The hash is of names and sources, and the same in any folder and system.
    """
    return _sources_digest(lambda inside: True)


def _sources_digest(counts: Callable[[Path], bool]) -> str:
    digest = hashlib.sha256()
    outlines = (LIBRARY / "exercises" / OUTLINES).glob("*.json")
    for path in sorted([*LIBRARY.rglob("*.py"), *LIBRARY.rglob("*.toml"), *outlines]):
        inside = path.relative_to(LIBRARY)
        if counts(inside):
            digest.update(f"{inside.as_posix()}\0".encode())
            digest.update(path.read_bytes().replace(b"\r\n", b"\n") + b"\0")
    return digest.hexdigest()


def lessons_used(course: Course, lesson: str) -> list[str]:
    """Return the names of the lessons that a lesson's exercises use directly or indirectly, in their order."""
    names, found, left = course.names(), set[str](), [lesson]
    while left:
        for use in [use for each in course.plan(left.pop()).exercises for use in each.uses]:
            for name in lesson_names.meant(split_use(use)[0], names):
                if name not in found:
                    found.add(name)
                    left.append(name)
    return sorted(found)


def _published(
    course: Course, name: str, plan: LessonPlan, reference: Mapping[str, Callable[..., Any]]
) -> list[PublicExercise]:
    """Return what the public checks know of a lesson: as it was proven, or else, which takes up to a minute, made anew.

    The pairs of mistakes are what `build` found; to find them again would take minutes.
    """
    declarations = {each: course.declaration(each) for each in course.names()}
    proofs = Proofs(course.root, declarations, {name: plan}, course.solutions)
    path, proven = course.check_data(name), proofs.committed(name)
    try:
        built = unpack(path.read_bytes()).exercises if path.is_file() else []
    except (ValueError, zlib.error):
        number = lesson_names.number_of(name)
        raise LessonError(
            f"{path.name} is damaged: run `nao-course build {number}` to write it again"
        ) from None
    if proven is not None:
        return built
    pairs = {each.name: each.pairs for each in built}
    made = publish(name, plan, reference, pairs=False).exercises
    return [replace(each, pairs=pairs.get(each.name, [])) for each in made]


def _need(path: Path) -> None:
    if not path.is_file():
        raise FileNotFoundError(f"there is no {path}: run `nao-course build` first")


def _released_setup(course: Course, lesson: str) -> str:
    """Return the source of the setup cells in the students' notebooks."""
    released = course.root / "notebooks" / f"{lesson}.ipynb"
    _need(released)
    return "\n\n".join(source for role, source in read_cells(released) if role == "setup")


def _classes(course: Course, lesson: str) -> dict[str, UsedClass]:
    """Return the classes that a lesson's exercises use directly or indirectly."""
    found: dict[str, UsedClass] = {}
    left = [use for each in course.plan(lesson).exercises for use in each.uses]
    while left:
        use = left.pop()
        number, name = split_use(use)
        (home,) = lesson_names.meant(number, course.names()) if number else [lesson]
        source = class_source(course.solutions / f"{home}.ipynb", name)
        if source and use not in found:
            named = loaded_in(_released_setup(course, home), words_of(source))
            own = dict.fromkeys([*course.plan(home)[name].uses, *named])
            uses = [each if ":" in each or not number else f"{number}:{each}" for each in own]
            found[use] = UsedClass(source, tuple(uses))
            left += uses
    return found


def loaded_in(setup: str, named: Collection[str]) -> list[str]:
    """Return the named functions that a set-up cell loads from earlier lessons.

    >>> loaded_in('warp2pi = earlier("07:warp2pi")', {"warp2pi", "turn"})
    ['07:warp2pi']
    """
    return [use for use in re.findall(r"""\bearlier\(\s*["']([^"']+)""", setup) if split_use(use)[1] in named]


def words_of(source: str) -> set[str]:
    """Return all names in some code, and the words of its texts."""
    return set(re.findall(r"\w+", source))


def class_source(notebook: Path, name: str) -> str:
    """Return the cell of a solution that defines a class, or an empty string."""
    for role, source in read_cells(notebook):
        if role == "solution" and any(
            isinstance(each, ast.ClassDef) and each.name == name for each in ast.parse(source).body
        ):
            return source
    return ""


def _task(
    exercise: Exercise, public: PublicExercise, function: Callable[..., Any], drawn: Callable[..., str]
) -> Task:
    return Task(
        public,
        tuple(hidden_cases(exercise, function, int(drawn(), 16))),
        tuple(hidden_cases(exercise, function, int(drawn("second try"), 16))),
        tuple(exercise.uses),
        exercise.with_reference,
        {mistake.message: mistake.name for mistake in exercise.mistakes},
        dict(exercise.parts),
    )
