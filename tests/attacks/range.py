"""A range for the grader: hostile and odd submissions, each between two honest ones, graded by the real command.

How an entry is added
---------------------
Name the defence that it attacks and the way; if the catalogue has two or three entries for both, it needs no other.
Hostile code goes into a table of `code.py`, which `test_catalogue.py` grades in one run; broken files and odd
but honest notebooks go into `accidents.py`, and have more time and a run of their own. State the honest score: `honest`
names what each exercise has to earn, and all others have to earn nothing. An attack that looks for something answers
wrong unless it finds it (`loot`), so that the honest score is what it earns without. In source, `@NAME@` stands for a
place of the range: COURSE, SOLUTION (a notebook), SUBMISSIONS, NEIGHBOUR (a notebook), GRADES, HOME, SECRET, OPEN (a
folder that anyone may write to), TCP and UDP (ports that listen), UNIX and ABSTRACT (sockets that listen).

What has to be true of all of them is in `laws.py`.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import socket
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.instructor.authoring.course import Course, load_course
from nao_course.instructor.autograding.assignment import Assignment, prepare
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import SubmissionResult, as_json
from nao_course.instructor.sandbox.layers import LEVELS
from tests.paths import PROJECT
from tests.toy import chain, pair
from tests.toy.chain import stamp

LESSON, REAL = "91_range", "01_hsl_filtering"
SECONDS = 2.0  # of a call
KEY = b"the secret of the range, which nobody may see"
ROWS = {  # of the table of attacks and accidents, by the word that an entry names its row with
    "loops": "endless loop; loop that swallows every interrupt; sleeping at import",
    "ends": "sys.exit, os._exit, SIGKILL to itself, segfault, abort in a C library",
    "hogs": "memory hog, fork bomb, 60 setsid children, threads that never end, 10 GB file",
    "large": "prints 100 MB; stored outputs of 50 MB; a 200 MB notebook; deeply nested JSON",
    "broken": "corrupt JSON, empty file, wrong format, kernel or encoding, a directory, a symlink, hostile zips",
    "patches": "patches numpy.testing, numpy.allclose, builtins, json, struct, the codec, sys.modules, ast, gc",
    "answers": "objects that equal everything, subclasses, NaN, huge or object arrays, hand-written frames",
    "reads": "reads solutions, tests, the journal, other submissions, other processes, descriptors, the warm server",
    "writes": "writes or deletes outside, changes permissions, edits its own notebook, the release, others' work",
    "network": "opens a connection, DNS, UDP, a Unix or abstract socket, listens on a port",
    "signals": "signals the grader, ptrace, leaves a detached child that wakes up later",
    "looks": "looks up its caller's frames, times the comparison, a table of known inputs",
    "earlier": "a hostile notebook of an earlier lesson; patches the driver and stand-ins; reads the reference's class",
    "metadata": "edits, deletes or doubles cells, raises the points, moves definitions",
    "styles": "honest work in another shape: defined twice, lambda, class, partial, helper file",
    "honest": "honest warnings, prints, slow, float32, lists",
}

DECLARATION = """
import numpy as np
from nao_course.exercises import Case, Exercise, LessonPlan, Mistake

def exercise(name, points, public, hidden, **more):
    wrong = [Mistake("zero", lambda *_: 0.0, f"That is always zero in {name}.")]
    return Exercise(name, points, lambda: public, hidden, ("a", "b"), wrong, {}, **more)

def number(rng):
    return float(rng.uniform(-1000, 1000))

def numbers(rng):
    return rng.uniform(-1000, 1000, (5, 4))

PLAN = LessonPlan([
    exercise("clamp", 1, [Case((1.5, 0.0, 1.0), "above"), Case((-2.5, 0.0, 1.0), "below")],
             lambda rng: [Case((number(rng), -400.0, 400.0)) for _ in range(4)]),
    exercise("scaled", 2, [Case((np.array([[1.0, 3.0], [2.0, 5.0]]),), "small")],
             lambda rng: [Case((numbers(rng),)) for _ in range(3)]),
    exercise("drawn", 4, [Case((np.random.default_rng(1), 5), "five")],
             lambda rng: [Case((np.random.default_rng(rng.integers(2**60)), 7)) for _ in range(3)]),
    exercise("middle", 8, [Case((np.array([[1.0, 3.0], [2.0, 5.0]]),), "small")],
             lambda rng: [Case((numbers(rng),)) for _ in range(3)], uses=("scaled",), with_reference=0.5),
])
"""
SETUP = "import numpy as np"
POINTS = {"clamp": 1, "scaled": 2, "drawn": 4, "middle": 8}
RIGHT = {
    "clamp": "def clamp(x, low, high):\n    return max(low, min(high, x))",
    "scaled": "def scaled(values):\n    return (values - values.min()) / np.ptp(values)",
    "drawn": "def drawn(rng, n):\n    return rng.normal(size=n).cumsum()",
    "middle": "def middle(values):\n    return float(np.median(scaled(values)))",
}
BLANK = {name: source.split("\n")[0] + "\n    raise NotImplementedError" for name, source in RIGHT.items()}
# One exercise is right by itself, one with the reference's earlier function, one is wrong and one raises.
HALF = {
    "scaled": "def scaled(values):\n    return values / np.ptp(values) - 3.0",
    "drawn": BLANK["drawn"] + "('no')",
}
HALF_POINTS = {"clamp": 1.0, "middle": 4.0}
REAL_POINTS = {
    "rgb_to_hsl": 2, "average_lightness": 1, "white_threshold": 1, "hue_mask": 2, "calibrate_hue": 4, "color_labels": 3,
}  # fmt: skip
LATER_POINTS = pair.POINTS | {"walk": 2}  # without a notebook of the lesson before it


@dataclass(frozen=True)
class Attack:
    """One submission, and what must come of it."""

    name: str  # unique in all catalogues; letters, digits and underscores
    row: str  # a key of ROWS
    # points by exercise; what is not named earns nothing
    honest: Mapping[str, float] = field(default_factory=dict)
    functions: Mapping[str, str] = field(default_factory=dict)  # source of exercises; "" deletes the cell
    before: str = ""  # source of a cell of the student's own before the exercises
    after: str = ""  # and after them
    edit: Callable[[dict[str, Any]], object] | None = None  # changes the notebook's dict
    # what else is handed in; a file of None is removed
    files: Mapping[str, bytes | str | None] = field(default_factory=dict)
    make: Callable[[Path], object] | None = None  # puts into the empty folder what is handed in instead
    says: str = ""  # is in the result: among its notes, reason, or what the student reads
    hides: tuple[str, ...] = ()  # is not on the student's page
    refused: bool = False  # it gets a reason instead of a score
    lesson: str = LESSON
    # with the process that it runs in, so that it may lose points that it states as honest
    races: bool = False


def all_but(*names: str, **points: float) -> dict[str, float]:
    """The points of every exercise of the range but some; of some, other points."""
    return {name: float(worth) for name, worth in POINTS.items() if name not in names} | points


# --- what is handed in ---


def cell(source: str, name: str = "", role: str = "") -> dict[str, Any]:
    """A code cell; with a name, an exercise's."""
    number = hashlib.sha256(f"{name}{source}".encode("utf-8", "replace")).hexdigest()[:10]
    return chain.cell("code", source, chain.grading(name) if name else None, role) | {"id": f"c{number}"}


def notebook(attack: Attack, right: Mapping[str, str] | None = None, setup: str = SETUP) -> dict[str, Any]:
    """The notebook of an attack, but for places; `right` are the right functions of its lesson."""
    cells = [cell(setup, role="setup")]
    cells += [cell(attack.before)] if attack.before else []
    for name, source in {**(RIGHT if right is None else right), **attack.functions}.items():
        if source:
            cells += [cell(source, name), _check(name)]
    cells += [cell(attack.after)] if attack.after else []
    stamp = {"nao_course": {"lesson": attack.lesson, "version": "1"}}
    return {"nbformat": 4, "nbformat_minor": 5, "metadata": stamp, "cells": cells}


def _check(name: str) -> dict[str, Any]:
    made = cell(f"check('{name}', {name})", name, "check")
    made["metadata"]["nbgrader"] |= {
        "grade_id": f"check_{name}", "solution": False, "grade": True, "points": 0, "locked": True,
    }  # fmt: skip
    return made


# --- the range ---


@dataclass
class Listeners:
    """Sockets that wait for somebody to speak to them."""

    folder: Path
    sockets: dict[str, socket.socket] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)

    def __enter__(self) -> Listeners:
        """Listen."""
        abstract = f"nao_attack_{os.getpid()}_{time.monotonic_ns()}"
        short = tempfile.mkdtemp(prefix="nao_")  # a Unix socket's path has at most 107 bytes
        os.chmod(short, 0o777)
        self.names = {"UNIX": f"{short}/socket", "ABSTRACT": abstract}
        kinds = {
            "TCP": (socket.AF_INET, socket.SOCK_STREAM, ("127.0.0.1", 0)),
            "UDP": (socket.AF_INET, socket.SOCK_DGRAM, ("127.0.0.1", 0)),
            "UNIX": (socket.AF_UNIX, socket.SOCK_STREAM, self.names["UNIX"]),
            "ABSTRACT": (socket.AF_UNIX, socket.SOCK_STREAM, f"\0{abstract}"),
        }
        for name, (family, kind, address) in kinds.items():
            made = self.sockets[name] = socket.socket(family, kind)
            made.bind(address)
            made.setblocking(False)
            if kind == socket.SOCK_STREAM:
                made.listen()
            if family == socket.AF_INET:
                self.names[name] = str(made.getsockname()[1])
        os.chmod(self.names["UNIX"], 0o666)
        return self

    def heard(self) -> list[str]:
        """Names of those that somebody has spoken to."""
        found = []
        for name, each in self.sockets.items():
            try:
                if each.type == socket.SOCK_DGRAM:
                    each.recv(1)
                else:
                    each.accept()[0].close()
                found.append(name)
            except BlockingIOError:
                continue
        return found

    def __exit__(self, *_: object) -> None:
        """Close them."""
        for each in self.sockets.values():
            each.close()
        shutil.rmtree(Path(self.names["UNIX"]).parent)


# The real command in a process of its own, with a shorter clock.
_COMMAND = """
import ctypes, resource, sys
from dataclasses import replace
from nao_course import cli
from nao_course.instructor.autograding import session
from nao_course.instructor.sandbox.layers import Layer, Sandbox
grade_all, probe = session.grade_all, session.probe
off, seconds = sys.argv.pop(1).split(","), float(sys.argv.pop(1))
session.grade_all = lambda waiting, assignment_of, *rest, **more: grade_all(
    waiting, lambda lesson: assignment_of(lesson).within(seconds), *rest, **more)
session.probe = lambda: Sandbox(tuple(
    Layer(each.name, each.on and each.name not in off, each.detail) for each in probe().layers))
if __name__ == "__main__":
    ctypes.CDLL(None).syscall(250, 1, None)  # a keyring of its own, and a key in it to be looked for
    ctypes.CDLL(None).syscall(248, b"user", b"nao_key", b"x", ctypes.c_size_t(1), -3)
    try:
        cli.app()
    finally:
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@dataclass(frozen=True)
class Graded:
    """What a run came to."""

    status: int  # of the command's exit
    seconds: float
    processes: list[Any]  # that it left running
    output: str
    peak: int  # bytes that its own process held at most
    results: Mapping[str, SubmissionResult]  # by student
    pages: Mapping[str, str]  # by student
    students: list[str]  # in the journal's order
    again: int  # results that took another one's place
    expected: list[str]  # students who have to be there
    changed: list[str]  # files that are not what they were, and what else was left behind
    heard: list[str]  # sockets that somebody has spoken to


@dataclass
class Range:
    """A course, a class and everything around it, in a folder."""

    root: Path  # an empty folder
    seconds: float = SECONDS  # wall clock of a call
    off: Sequence[str] = ()  # layers of the sandbox to do without: to see attacks succeed
    # who grades, and owns all of it: for attacks that would harm this user without layers
    user: int | None = None
    most_seconds: float = 3600.0  # after which the command is ended
    jobs: int = 2

    def __post_init__(self) -> None:
        """Lay it out."""
        self.course = make_course(self.root / "course")
        self.open, self.home, self.temporary = (self.root / name for name in ("open", "home", "tmp"))
        self.cache = self.root / "cache"  # of Matplotlib: the server itself writes it when it starts
        for folder in (self.open, self.home / ".ssh", self.temporary, self.cache):
            folder.mkdir(parents=True)
        for path in (self.root, self.open):
            path.chmod(0o777 if path == self.open else 0o755)
        (self.open / "anyones.txt").write_text("before")
        (self.open / "anyones.txt").chmod(0o666)
        (self.home / ".ssh" / "id_rsa").write_text("a private key")
        (self.root / "secret").write_bytes(KEY)
        (self.root / "secret").chmod(0o600)
        self.submissions, self.grades = self.root / "in", self.root / "grades"

    @cached_property
    def right(self) -> Mapping[str, Mapping[str, str]]:
        """Cells of the right functions, by lesson and exercise."""
        cells = json.loads((PROJECT / "solutions" / f"{REAL}.ipynb").read_text(encoding="utf-8"))["cells"]
        found = {
            each["metadata"].get("nbgrader", {}).get("grade_id"): "".join(each["source"]) for each in cells
        }
        later = pair.RIGHT[pair.SECOND] | {"setup": pair.SETUP[pair.SECOND]}
        real = {name: found[name] for name in REAL_POINTS} | {"setup": found["setup"]}
        return {LESSON: RIGHT, REAL: real, pair.SECOND: later}

    @cached_property
    def assignment(self) -> Assignment:
        """What the range's own lesson is graded by."""
        return prepare(self.course, LESSON, KEY)

    def places(self, listeners: Listeners, neighbour: str) -> dict[str, str]:
        """What stands for @NAME@ in source."""
        found = {
            "COURSE": self.course.root, "SOLUTION": self.course.solutions / f"{LESSON}.ipynb",
            "SUBMISSIONS": self.submissions, "GRADES": self.grades, "HOME": self.home, "OPEN": self.open,
            "SECRET": self.root / "secret", "NEIGHBOUR": self.submissions / neighbour / f"{LESSON}.ipynb",
        }  # fmt: skip
        return {f"@{name}@": str(each) for name, each in (found | listeners.names).items()}

    def hand_in(self, student: str, attack: Attack, places: Mapping[str, str]) -> None:
        """Put a submission where the command looks for it."""
        folder = self.submissions / student
        folder.mkdir(parents=True)
        if attack.make:
            attack.make(folder)
            return
        right = dict(self.right[attack.lesson])
        made = notebook(attack, right, right.pop("setup", SETUP))
        if attack.edit:
            attack.edit(made)
        for name, content in ({f"{attack.lesson}.ipynb": json.dumps(made)} | dict(attack.files)).items():
            if isinstance(content, str):
                for place, path in places.items():
                    content = content.replace(place, path)
            if content is not None:
                path = folder / name
                path.write_bytes(content.encode() if isinstance(content, str) else content)

    def run(self, attacks: Sequence[Attack]) -> Graded:
        """Grade attacks, each between two honest students of the same lesson."""
        handed_in = lined_up(attacks)
        with Listeners(self.root) as listeners:
            students = list(handed_in)
            for place, (student, each) in enumerate(handed_in.items()):
                right = [name for name in students[max(place - 1, 0) : place + 2] if name.endswith("-right")]
                self.hand_in(student, each, self.places(listeners, right[0] if right else student))
            if self.user is not None:
                for path in (self.root, *self.root.rglob("*")):
                    os.chown(path, self.user, self.user, follow_symlinks=False)
            before = self.state()
            ended = self.command(Path(listeners.names["UNIX"]).parent)
            after = self.state()
            changed = sorted(each for each in before | after if before.get(each) != after.get(each))
            return Graded(*ended, *self.kept(), students, changed, listeners.heard())

    def command(self, *folders: Path) -> tuple[int, float, list[Any], str, int]:
        """Run `nao-course grade`; folders outside of the range may be seen by another user."""
        environment = os.environ | {
            "HOME": str(self.home), "TMPDIR": str(self.temporary), "NAO_COURSE_SECRET": str(self.root / "secret"),
            "PYTHONPATH": str(PROJECT), "COLUMNS": "200", "MPLCONFIGDIR": str(self.cache),
        }  # fmt: skip
        words = ["grade", self.submissions, "--out", self.grades, "--jobs", self.jobs]
        words += [] if self.off else ["--require-sandbox", LEVELS[-1]]
        told = [_COMMAND, ",".join(self.off), self.seconds, *words]
        seen = [str(each) for each in (self.root, *folders)]
        options = json.dumps({"seconds": self.most_seconds, "user": self.user, "folders": seen})
        python = sys.executable
        runner = [python, "-m", "tests.attacks.runner", options, python, "-c", *map(str, told)]
        more = {"cwd": self.course.root, "env": environment}
        done = subprocess.run(runner, **more, stdout=subprocess.PIPE, check=True)
        status, seconds, processes, output = json.loads(done.stdout)
        output, _, peak = output.rstrip().rpartition("\n")
        return status, seconds, processes, output, int(peak) * 1024 if peak.isdecimal() else 0

    def kept(self) -> tuple[dict[str, SubmissionResult], dict[str, str], list[str], int]:
        """What the journal and the feedback folder hold."""
        with Journal(self.grades, make=False) as journal:
            results = [each for each in journal.results() if each.lesson != pair.FIRST]  # handed in beside
            again = sum(len(journal.history(each.student, each.lesson)) for each in results)
        pages = {}
        for each in results:
            path = self.grades / "feedback" / safe_name(each.student) / f"{each.lesson}.html"
            pages[each.student] = path.read_text(encoding="utf-8") if path.exists() else ""
        return {each.student: each for each in results}, pages, [each.student for each in results], again

    def state(self) -> dict[str, str]:
        """All that no submission may change: files by their content, mounts, shared memory."""
        found = dict(_files(self.root, besides=(self.grades, self.cache)))
        found |= _files(Path(np.__file__).parent, contents=False)
        found["mounts"] = Path("/proc/self/mountinfo").read_text()
        for kind in ("shm", "sem", "msg"):
            table = Path("/proc/sysvipc") / kind
            found[kind] = table.read_text() if table.exists() else ""
        for folder in ("/dev/shm", "/dev/mqueue", "/tmp", "/var/tmp"):
            found[folder] = repr(sorted(name for name in _listing(folder) if "nao_attack" in name))
        return found


def make_course(root: Path) -> Course:
    """Lay out a course of the range's lesson, the real first one and two of which one uses the other, in a folder."""
    pair.make_course(root)
    (root / "course.toml").write_text('title = "Range"\nversion = "1"\n')
    (root / "solutions" / f"{LESSON}.md").write_text("# Range\n")
    (root / "solutions" / "exercises" / f"{LESSON}.py").write_text(DECLARATION)
    right = Attack("right", "honest")
    (root / "solutions" / f"{LESSON}.ipynb").write_text(json.dumps(notebook(right)))
    (root / "notebooks" / f"{LESSON}.ipynb").write_text(json.dumps(notebook(replace(right, functions=BLANK))))
    for name in (f"solutions/{REAL}.md", f"solutions/{REAL}.ipynb", f"solutions/exercises/{REAL}.py"):
        shutil.copy(PROJECT / name, root / name)
    released = PROJECT / "notebooks" / f"{REAL}.ipynb"
    shutil.copy(released if released.exists() else root / "solutions" / released.name, root / "notebooks")
    course = load_course(root)
    stamp(course, LESSON)
    return course


def lined_up(attacks: Sequence[Attack]) -> dict[str, Attack]:
    """What each student hands in, in their order: right work and half right work by turns, and attacks in between.

    An honest student between two attacks of one lesson is the neighbour of both.
    """
    line: list[Attack] = []
    kinds = cycle(("right", "half"))
    for number, attack in enumerate(attacks):
        if not number or attack.lesson != attacks[number - 1].lesson:
            line.append(honest(attack, next(kinds)))
        line += [attack, honest(attack, next(kinds))]
    return {f"s{place:04}-{each.name}": each for place, each in enumerate(line)}


def honest(attack: Attack, kind: str) -> Attack:
    """An honest neighbour of an attack: all right, or half right."""
    real = {"hue_mask": "def hue_mask(hue, low, high):\n    return hue > low"}
    second = {"alone": "def alone(x):\n    return x"}
    wrong = {LESSON: HALF, REAL: real, pair.SECOND: second}[attack.lesson]
    return Attack(kind, "honest", functions=wrong if kind == "half" else {}, lesson=attack.lesson)


def honest_points(attack: Attack, kind: str) -> dict[str, float]:
    """What that neighbour earns."""
    if attack.lesson == LESSON:
        return all_but() if kind == "right" else dict(HALF_POINTS)
    every, wrong = {REAL: (REAL_POINTS, "hue_mask"), pair.SECOND: (LATER_POINTS, "alone")}[attack.lesson]
    return {name: float(worth) for name, worth in every.items() if kind == "right" or name != wrong}


def points(result: SubmissionResult) -> dict[str, float]:
    """What each exercise earned, where it earned anything."""
    return {each.name: each.earned for each in result.exercises if each.earned}


def told(result: SubmissionResult) -> str:
    """All that a result says, to student or assistant."""
    said = as_json(replace(result, seconds=0.0))
    return json.dumps(said, ensure_ascii=False)


def hidden_numbers(assignment: Assignment) -> set[str]:
    """The beginnings of all hidden numbers: five digits."""
    cases = [case for task in assignment.tasks for case in task.hidden if task.public.name != "drawn"]
    numbers = [number for case in cases for number in np.ravel(case.args[0])]
    return {f"{abs(number):.3f}"[:6] for number in numbers if abs(number) >= 10}


def _files(folder: Path, besides: Sequence[Path] = (), *, contents: bool = True) -> Iterator[tuple[str, str]]:
    for at, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if Path(at, name) not in besides]
        for name in [*folders, *names]:
            path = Path(at, name)
            status = path.lstat()
            kept = f"{stat.filemode(status.st_mode)} {status.st_uid}"
            if stat.S_ISREG(status.st_mode):
                content = hashlib.sha256(path.read_bytes()).hexdigest() if contents else status.st_mtime_ns
                kept += f" {status.st_size} {content}"
            yield str(path), kept


def _listing(folder: str) -> list[str]:
    return os.listdir(folder) if os.path.isdir(folder) else []


@contextmanager
def ranges() -> Iterator[Callable[..., Range]]:
    """Make ranges in folders of their own; all go at the end."""
    with ExitStack() as stack:

        def make(**more: Any) -> Range:
            made = tempfile.TemporaryDirectory(prefix="nao_range_", ignore_cleanup_errors=True)
            return Range(Path(stack.enter_context(made)), **more)

        yield make
