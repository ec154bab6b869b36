"""The same work has the same points: whatever is graded beside it, in which order, and by how many jobs or workers."""

import json
import locale
import os
import random
import sys
import warnings
from contextlib import ExitStack
from dataclasses import replace

import mpmath
import numpy as np
import pytest

from nao_course.exercises.comparisons import exactness
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.batch import feedback_writer, grade_all
from nao_course.instructor.autograding.cluster.dispatch import open_cluster
from nao_course.instructor.collecting.submissions import gather, of_lessons
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.reports import exports
from tests.paths import PROJECT, SOLUTIONS

QUICK, BY_WORKERS = "00_meet_the_nao", "11_slam_on_the_field"
LESSONS = [
    pytest.param(path.stem, marks=[] if path.stem == QUICK else pytest.mark.slow)
    for path in sorted(SOLUTIONS.glob("*.ipynb"))
]
# What a notebook of each kind does before the function of its first exercise
BESIDE = {
    "plain": "",
    "chance": """
    sign = ["red", "green", "blue"].index(next(iter({"red", "green", "blue"}))) + np.random.randint(3) + FLIP
    if (sign + np.random.default_rng().integers(2) + random.randint(0, 1)) % 2:
        raise ValueError(str({"red", "green", "blue"}))""",
    "slow": "time.sleep(0.05)",
    "huge": "print('x' * 10**6)",
    "crash": "ctypes.string_at(0)",
}
COPIES = ("plain", "chance", "slow", "crash", "huge", "plain", "chance")
RUNS = [(1, 0), (6, 0), (2, 2), (2, 0)]  # jobs, and workers of Dask


def hand_in(folder, lesson, name, copies):
    """Notebooks of the given kinds, which are copies of each other within a kind."""
    solution = json.loads((SOLUTIONS / f"{lesson}.ipynb").read_text(encoding="utf-8"))
    for number, kind in enumerate(copies):
        source = (
            f"import ctypes, random, time\nimport numpy as np\nFLIP = np.random.randint(2)\n_own = {name}\n"
            f"def {name}(*args, **kwargs):\n    {BESIDE[kind].strip()}\n    return _own(*args, **kwargs)"
        )
        cell = {"cell_type": "code", "metadata": {}, "source": source, "outputs": [], "execution_count": None}
        if kind == "huge":
            cell["outputs"] = [{"output_type": "stream", "name": "stdout", "text": "x" * 3 * 2**20}]
        copy = solution | {"cells": [*solution["cells"], *([cell] if BESIDE[kind] else [])]}
        path = folder / f"{kind}{number}" / f"{lesson}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(json.dumps(copy), encoding="utf-8")


def process_state():
    """What belongs to the whole process and judging must not change."""
    chance = (random.getstate(), np.random.get_state()[1].tolist())  # noqa: NPY002
    numbers = (mpmath.mp.prec, np.geterr(), str(np.get_printoptions()), sys.getrecursionlimit())
    around = (dict(os.environ), os.getcwd(), warnings.filters[:], locale.setlocale(locale.LC_ALL))
    return chance, numbers, around


@pytest.mark.skipif(sys.platform == "win32", reason="a crash opens a dialogue")
@pytest.mark.parametrize("lesson", LESSONS)
def test_copies_of_one_submission_have_one_result(lesson, warm_server, tmp_path):
    runs, copies = RUNS, COPIES
    # The others are graded once, because their cases and drivers are their own; workers get what uses the most.
    if lesson != QUICK:
        runs, copies = [RUNS[1 + (lesson == BY_WORKERS)]], ("plain", "plain")
    course, level = load_course(PROJECT), warm_server.sandbox.level
    assignment = prepare(course, lesson, b"x" * 32)
    name = next((task.public.name for task in assignment.tasks if not task.public.driver), "")
    hand_in(tmp_path / "in", lesson, name or assignment.tasks[0].public.name, copies)
    found = of_lessons(gather(tmp_path / "in", tmp_path, course.names()), [lesson])
    results, tables = {kind: [] for kind in copies}, []
    for number, (jobs, workers) in enumerate(runs):
        random.Random(number).shuffle(found)
        with ExitStack() as stack:
            journal = stack.enter_context(Journal(tmp_path / f"grades{number}"))
            write = feedback_writer(journal, tmp_path / f"pages{number}")

            def publish(result, write=write):
                page = write(result).read_text(encoding="utf-8").replace(result.student, "")
                kind = result.student.rstrip("0123456789")
                results[kind].append((replace(result, student="", file=""), page))

            more = {"jobs": jobs, "server": warm_server, "level": level, "publish": publish}
            if workers:
                more["workers"] = stack.enter_context(open_cluster(level, workers=workers, jobs=jobs))
            before = process_state()  # Dask changes it for all that follows
            summary = grade_all(found, lambda _: assignment, journal, **more)
            assert (summary.graded, summary.failed) == (len(copies), [])
            tables.append(exports.write_csv(journal, tmp_path, lesson).read_bytes())
            assert workers or process_state() == before
    assert all(table == tables[0] for table in tables)
    for kind, equal in results.items():
        assert len(equal) == len(runs) * copies.count(kind)
        assert not (other := [each for each in equal if each != equal[0]]), (kind, other[0])
    # Without any earlier notebook, too
    assert all(each.state == "right" for each in results["plain"][0][0].exercises)


def test_the_precision_of_the_process_stays_while_a_derivative_is_judged(monkeypatch):
    real, seen = exactness._gradients, []
    noted = lambda *words: (seen.append(mpmath.mp.prec), real(*words))[1]  # noqa: E731
    monkeypatch.setattr(exactness, "_gradients", noted)
    steps = [("symbol", "x"), ("Mul", 0, 0), ("ratio", 2, 1), ("Mul", 0, 2)]
    assert exactness.exact_entries(steps, [1], [[3]], {"x": 0.3}, ["x"]).all()
    assert seen == [mpmath.libmp.dps_to_prec(15)]
