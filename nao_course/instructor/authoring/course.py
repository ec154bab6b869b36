"""The course as its course.toml describes it: which lessons there are, and what their exercises are worth."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from nao_course.exercises import lesson_names
from nao_course.exercises.exercise import LessonPlan
from nao_course.instructor.authoring.course_file import NAME, CourseFileError, read_course_file
from nao_course.instructor.authoring.plans import CHECKS, load_plan
from nao_course.instructor.gradebook.late import LatePolicy

ABOUT = "lessons.toml"  # in the folder of texts: what is said about each lesson outside of it


class LessonError(ValueError):
    """A lesson that cannot be built; its message says where, one line for each thing that is wrong."""


@dataclass(frozen=True)
class Course:
    """A checkout of the course, as the course.toml in its root describes it.

    `chosen` are the numbers of the lessons that are released, all if it is empty. `points`, by the exercise's name,
    differ from the declaration's. A submission is graded without the `late_policy`.
    """

    root: Path
    title: str
    version: str
    chosen: tuple[str, ...] = ()
    points: Mapping[str, float] = field(default_factory=dict)
    late_policy: LatePolicy = field(default_factory=LatePolicy)

    @property
    def solutions(self) -> Path:
        """The folder of the lessons' texts."""
        return self.root / "solutions"

    def names(self, wanted: Sequence[str] = ()) -> list[str]:
        """Return the names of lessons, given by number or name; of all by default.

        Raise a LessonError if there is no such lesson.
        """
        there = sorted(path.stem for path in self.solutions.glob(f"{lesson_names.PATTERN}.md"))
        meant = {word: lesson_names.meant(word, there) for word in wanted}
        missing = [word for word, names in meant.items() if not names]
        if missing:
            raise LessonError(
                f"there is no lesson {', '.join(map(_shown, missing))} in {self.solutions.name}/; {there}"
            )
        return [name for name in there if not wanted or any(name in names for names in meant.values())]

    def drafts(self) -> list[str]:
        """Return the names of lessons whose text contains a TODO: they are built and tested, but not released."""
        return [
            name
            for name in self.names()
            if re.search(r"\bTODO\b", self.text(name).read_text(encoding="utf-8"))
        ]

    def text(self, name: str) -> Path:
        """Return the file of a lesson's text."""
        return self.solutions / f"{name}.md"

    def declaration(self, name: str) -> Path:
        """Return the file that declares a lesson's exercises."""
        return self.solutions / "exercises" / f"{name}.py"

    def check_data(self, name: str) -> Path:
        """Return the path of the data of a lesson's checks, which `build` writes."""
        return self.root / CHECKS / f"{name}.bin"

    def plan(self, name: str) -> LessonPlan:
        """Load a lesson's plan, with this course's points; a lesson without a declaration has no exercises.

        Raise a PlanError if the declaration cannot be run, or its values are not allowed.
        """
        path = self.declaration(name)
        plan = load_plan(path) if path.exists() else LessonPlan(())
        return replace(
            plan,
            exercises=[
                replace(each, points=self.points.get(each.name, each.points)) for each in plan.exercises
            ],
            written=[replace(each, points=self.points.get(each.name, each.points)) for each in plan.written],
        )


def _shown(name: str) -> str:
    """Shorten a word of a command, which may be any text, for a message."""
    return name if name.isprintable() and len(name) <= 80 else repr(name[:80])


def load_course(folder: Path | None = None) -> Course:
    """Read the course.toml of a folder or of the nearest one above it.

    Raise a LessonError if there is none, or it is not understood.
    """
    start = (folder or Path.cwd()).resolve()
    for root in (start, *start.parents):
        if (root / NAME).is_file():
            break
    else:
        raise LessonError(
            "no course.toml in this folder or above: this command is for a checkout of the course"
        )
    try:
        file = read_course_file(root)
    except CourseFileError as error:
        raise LessonError(str(error)) from None
    return Course(root, file.title, file.version, file.lessons, file.points, file.late_policy)
