"""Proofs of lessons, kept: an exercise is proven again only when something that its proof rests on has changed.

A proof is kept in two places. The manifest `solutions/proofs.json` is committed, and vouches for the committed check
data, so that a release of a fresh clone proves nothing. The folder `build/proofs` has what was proven here since.
"""

import hashlib
import json
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import nao_course
from nao_course.codec import encode
from nao_course.exercises import LessonPlan, lesson_names
from nao_course.exercises.cells import SHOWN
from nao_course.exercises.checking import pack, unpack
from nao_course.exercises.definitions import demonstrated
from nao_course.exercises.earlier import resolved_by
from nao_course.exercises.exercise import PublicExercise
from nao_course.exercises.notebook_text import read_cells
from nao_course.instructor.authoring.dependencies import code_by_exercise
from nao_course.instructor.authoring.plan_checks import check_plan
from nao_course.instructor.authoring.plans import (
    CHECKS,
    OUTLINES,
    PlanError,
    load_solution,
    public_lesson,
    solutions_beside,
)

FOLDER = Path("build", "proofs")  # git ignores it, and no release looks there
MANIFEST = Path("solutions", "proofs.json")
MOST_CHECK_DATA = 1_000_000  # bytes of one lesson
LIBRARY = Path(nao_course.__file__).parent  # whose code proves, whichever course is proven
COMPUTES = ("numpy", "opencv-python-headless", "scipy", "sympy")
_MADE = {".bin", ".pyc"}  # files in the library that are made of others
# Parts of the library that no proof loads: the commands, and all that works with a finished lesson.
APART = (
    "cli.py",
    "homework.py",
    "instructor/authoring/build.py",
    "instructor/authoring/course.py",
    "instructor/authoring/course_file.py",
    "instructor/authoring/execute.py",
    "instructor/authoring/leaks.py",
    "instructor/authoring/lesson_text.py",
    "instructor/authoring/mutation.py",
    "instructor/authoring/release.py",
    "instructor/authoring/rounding_errors.py",
    "instructor/authoring/scaffold.",
    "instructor/authoring/stamps.py",
    "instructor/autograding/",
    "instructor/collecting/",
    "instructor/commands/",
    "instructor/gradebook/",
    "instructor/pyproject.toml",
    "instructor/reports/",
    "instructor/similarity/",
    "lab/",
    "robot/cameras.py",
    "robot/emulated.py",
    "robot/naoqi.py",
    "robot/real.py",
    "robot/recording.py",
)


@dataclass(frozen=True)
class Proofs:
    """The proofs of a course's lessons.

    A proof is the check data of a lesson, with the hash of all that it rests on: the library, the declaration, the
    points, and the solutions of the lesson and of those before it; with the same for each exercise, without what only
    other exercises rest on; and with the versions of Python and of what computes.

    `declarations` are the files of all lessons by their names, and `plans` what they declare, with the course's points:
    of all lessons to prove one, of one to ask about it. With `anew`, everything is proven again.
    """

    root: Path
    declarations: Mapping[str, Path]
    plans: Mapping[str, LessonPlan]
    solutions: Path
    anew: bool = False

    def check_data(self, name: str) -> bytes:
        """Return the proven data of a lesson's checks; earlier proofs, also of single exercises, are used again.

        Raise a PlanError with one line for each thing that is wrong with the lesson's declaration.
        """
        head = self._head(name)
        kept = [] if self.anew else list(self._kept(name))
        for earlier, data in kept:
            if earlier["lesson"] == head["lesson"]:
                return data
        data = self._prove(name, _proven_already(head["exercises"], kept))
        _write(self._file(name), json.dumps(head | {"data": _hash(data)}).encode() + b"\n" + data)
        return data

    def committed(self, name: str) -> bytes | None:
        """Return the committed data of a lesson's checks if they were proven on the same inputs with these versions."""
        with suppress(OSError):
            data = (self.root / CHECKS / f"{name}.bin").read_bytes()
            if self.is_vouched_for(name, data) and self._manifest[name]["versions"] == _versions():
                return data
        return None

    def manifest(self, proven: Mapping[str, bytes]) -> bytes:
        """Return the manifest with the proofs of lessons whose check data are given in the place of theirs."""
        heads = {name: head for name, head in self._manifest.items() if name in self.declarations}
        for name, data in proven.items():
            heads[name] = self._head(name) | {"data": _hash(data)}
        return (json.dumps(heads, indent=2, sort_keys=True) + "\n").encode()

    def is_vouched_for(self, name: str, data: bytes) -> bool:
        """Return whether these check data were proven on the same inputs, with any versions of libraries."""
        head = self._manifest.get(name, {})
        return head.get("lesson") == self.rests_on(name) and head.get("data") == _hash(data)

    def _head(self, name: str) -> dict[str, Any]:
        """Return what stands for a proof, except the hash of its data."""
        return {
            "lesson": self.rests_on(name),
            "exercises": self._exercises_rest_on(name),
            "versions": _versions(),
        }

    def _kept(self, name: str) -> Iterator[tuple[Mapping[str, Any], bytes]]:
        """Yield what was proven with the same versions, here or before it was committed, if it is complete."""
        with suppress(OSError, ValueError):
            line, _, data = self._file(name).read_bytes().partition(b"\n")
            if _is_proof(head := json.loads(line), data):
                yield head, data
        with suppress(OSError):
            data = (self.root / CHECKS / f"{name}.bin").read_bytes()
            if _is_proof(head := self._manifest.get(name, {}), data):
                yield head, data

    @cached_property
    def _manifest(self) -> Mapping[str, Any]:
        """What is committed of each lesson; a file that cannot be read vouches for nothing."""
        try:
            found = json.loads((self.root / MANIFEST).read_bytes())
        except (OSError, ValueError):
            return {}
        return (
            {name: head for name, head in found.items() if _is_head(head)} if isinstance(found, dict) else {}
        )

    def rests_on(self, name: str) -> str:
        """Hash all that the proof of a lesson rests on but the versions of other software."""
        plan, declaration = self.plans[name], self.declarations[name]
        parts = self._shared(name) | {
            "declaration": _hash(declaration.read_bytes()) if declaration.is_file() else "",
            "points": plan.points,
            "names of others": sorted(
                self._words_of_others(name) & {*plan.points, *(each.name for each in plan.questions)}
            ),
            "solution": self._solutions.get(name, []),
            "shown": demonstrated(self._cells.get(name, [])),
        }
        return _hash(json.dumps(parts, sort_keys=True).encode())

    def _exercises_rest_on(self, name: str) -> dict[str, str]:
        """Hash the same for each exercise, without what only other exercises of the lesson rest on."""
        plan, file = self.plans[name], self.declarations[name]
        declaration = file.read_text(encoding="utf-8") if file.is_file() else ""
        names = [each.name for each in plan.exercises]
        code, shared = code_by_exercise(declaration, self._solutions.get(name, []), names), self._shared(name)
        return {
            each: _hash(json.dumps([shared, number, plan.points[each], code[each]], sort_keys=True).encode())
            for number, each in enumerate(names)
        }

    def _shared(self, name: str) -> dict[str, Any]:
        """Return what all exercises of a lesson rest on: the library and the solutions of earlier lessons."""
        later = {_folder(each) for each in self.declarations if each > name}
        return {
            "name": name,
            "library": {file: kept for file, kept in self._library.items() if _owner(file) not in later},
            "earlier": {each: cells for each, cells in self._solutions.items() if each < name},
        }

    def _prove(self, name: str, proven: Mapping[str, PublicExercise]) -> bytes:
        """Prove a lesson's plan, except for exercises that are `proven`, and pack what its checks need."""
        plan, notebook = self.plans[name], self.solutions / f"{name}.ipynb"
        reference = load_solution(notebook)
        with resolved_by(solutions_beside(notebook)):
            exercises = check_plan(name, plan, reference, self._taken(name), proven)
            data = pack(public_lesson(name, plan, reference, exercises))
        if len(data) > MOST_CHECK_DATA:
            raise PlanError(f"{name}: {_too_much(exercises, len(data))}")
        return data

    def _taken(self, name: str) -> set[str]:
        """Return the names of the exercises of all other lessons."""
        return {each.name for other in self.plans if other != name for each in self.plans[other].exercises}

    def _words_of_others(self, name: str) -> set[str]:
        """Return all words in the declarations of other lessons; their plans need not be loaded to know them."""
        files = (file for other, file in self.declarations.items() if other != name and file.is_file())
        return {word for file in files for word in re.findall(r"\w+", file.read_text(encoding="utf-8"))}

    def _file(self, name: str) -> Path:
        return self.root / FOLDER / name

    @cached_property
    def _library(self) -> dict[str, str]:
        """The hash of each file of the library that a proof may load."""
        files = {path.relative_to(LIBRARY).as_posix(): path for path in LIBRARY.rglob("*")}
        return {
            name: _hash(path.read_bytes())
            for name, path in files.items()
            if path.suffix not in _MADE
            and path.is_file()
            and path.parent.name != OUTLINES.name
            and not name.startswith(APART)
        }

    @cached_property
    def _solutions(self) -> dict[str, list[tuple[str, str]]]:
        """What each solution notebook defines with: all code but checks and what is only shown."""
        return {name: [cell for cell in cells if _defines(cell[0])] for name, cells in self._cells.items()}

    @cached_property
    def _cells(self) -> dict[str, list[tuple[str, str]]]:
        """The code cells of each solution notebook."""
        return {path.stem: read_cells(path) for path in self.solutions.glob(f"{lesson_names.PATTERN}.ipynb")}


def _defines(role: str) -> bool:
    return role not in ("check", *SHOWN)


def _folder(lesson: str) -> str:
    """Return the folder that only one lesson uses."""
    return lesson.partition("_")[2]


def _owner(file: str) -> str:
    """Return the lesson's folder that contains a file of the library; empty for shared files."""
    parts = file.split("/")
    return parts[1] if parts[0] == "lessons" else ""


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _versions() -> str:
    """Name the versions of Python, without its last number, and of what computes."""
    return ", ".join(
        [f"python {sys.version_info[0]}.{sys.version_info[1]}"]
        + [f"{each} {version(each)}" for each in COMPUTES]
    )


def _is_head(head: object) -> bool:
    """Return whether this has the parts of what stands for a proof."""
    parts = {"lesson": str, "exercises": dict, "versions": str, "data": str}
    return isinstance(head, dict) and all(isinstance(head.get(part), kind) for part, kind in parts.items())


def _is_proof(head: Any, data: bytes) -> bool:
    """Return whether these data were proven, with the present versions."""
    return _is_head(head) and head["data"] == _hash(data) and head["versions"] == _versions()


def _proven_already(
    wanted: Mapping[str, str], kept: Sequence[tuple[Mapping[str, Any], bytes]]
) -> dict[str, PublicExercise]:
    """Return the exercises of earlier proofs that rest on the same as now."""
    found: dict[str, PublicExercise] = {}
    for head, data in kept:
        same = {name for name, rests_on in wanted.items() if head["exercises"].get(name) == rests_on}
        if same - found.keys():
            found |= {each.name: each for each in unpack(data).exercises if each.name in same}
    return found


def _write(file: Path, content: bytes) -> None:
    """Store a proof; a proof that cannot be stored is made again the next time."""
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        temporary = file.with_name(f".{file.name}.{os.getpid()}")
        temporary.write_bytes(content)
        temporary.replace(file)


def _too_much(exercises: Sequence[PublicExercise], size: int) -> str:
    """Return a message about check data that are too large, with the exercise that contributes the most."""
    sizes = {each.name: len(encode(each)) for each in exercises}
    largest = max(sizes, key=sizes.__getitem__)
    return (
        f"its check data has {size / 1e6:.1f} MB; {MOST_CHECK_DATA / 1e6:g} MB is the most, for each student downloads "
        f"it: fewer or smaller public cases, first of {largest}"
    )
