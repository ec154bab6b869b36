"""Each submission of a batch gets one result, whatever the order, the jobs, and whoever is killed on the way."""

import contextlib
import json
import os
import pickle
import random
import signal
import subprocess
import sys
import threading
import time
from functools import reduce
from pathlib import Path

import psutil
import pytest

from nao_course.instructor.autograding import batch
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.batch import grade_all
from nao_course.instructor.autograding.grader import refuse
from nao_course.instructor.collecting.submissions import gather, of_lessons
from nao_course.instructor.gradebook.journal import Journal, JournalError
from nao_course.instructor.sandbox.layers import SandboxError, probe
from nao_course.instructor.sandbox.warm_server import WarmServer
from tests.paths import PROJECT
from tests.toy import chain
from tests.toy.graded import hand_in, kept, rows

posix = pytest.mark.skipif(sys.platform == "win32", reason="signals and modes of POSIX")


@pytest.fixture
def toy(tmp_path):
    """Return a prepared lesson and the submissions of a small class."""
    course = chain.make_course(tmp_path / "course")
    found = of_lessons(gather(hand_in(tmp_path / "in"), tmp_path, course.names()), course.names())
    return prepare(course, "90", chain.SECRET), found


def test_neither_order_nor_jobs_change_a_result(toy, warm_server, tmp_path):
    (assignment, found), results = toy, []
    for jobs in (1, 4):
        random.Random(jobs).shuffle(found)
        grades = tmp_path / f"grades{jobs}"
        with Journal(grades) as journal:
            publish = batch.feedback_writer(journal, grades / "feedback")
            summary = grade_all(
                found, lambda _: assignment, journal, jobs=jobs, server=warm_server, publish=publish
            )
        assert (summary.graded, len(summary.refused), summary.failed) == (5, 1, [])
        pages = {path.relative_to(grades): path.read_bytes() for path in grades.rglob("feedback/**/*.html")}
        results.append((json.dumps(list(kept(grades).values())), pages))
    assert results[0] == results[1] and len(results[0][1]) == 6


def test_submissions_are_taken_only_as_results_come(toy, tmp_path, monkeypatch):
    path = chain.hand_in(tmp_path, "x", b"{}")
    taken, most = [], []

    def many():
        for number in range(500):
            taken.append(number)
            yield batch.Submission(f"s{number}", chain.LESSON, path)

    monkeypatch.setattr(batch, "grade", lambda submission, given, **_: refuse(submission, given, "no"))
    tell = lambda _: most.append(len(taken) - len(most))  # noqa: E731
    with Journal(tmp_path / "grades") as journal:
        summary = grade_all(many(), lambda _: toy[0], journal, jobs=2, tell=tell)
    assert len(most) == 500 and max(most) <= 5
    refused = [each.student for each in summary.refused]
    assert refused == sorted(refused), "the lists of a run are in the same order however it went"


def test_a_page_that_cannot_be_written_stops_nobody_and_its_result_is_kept(toy, warm_server, tmp_path):
    def publish(result):
        if result.student == "bob":
            raise OverflowError("date value out of range")

    assignment, found = toy
    with Journal(tmp_path / "grades") as journal:
        grade_all(found, lambda _: assignment, journal, jobs=2, server=warm_server, publish=publish)
        assert len(journal.results()) == len(found)
        (problem,) = journal.problems
    assert problem.startswith("bob, 90_chain:") and "OverflowError: date value out of range" in problem


GOOD = chain.notebook(answer="Because.")
OTHERS = ((chain.LESSON.encode(), b"91_other"), (b"def ", b"def other_"), (b"class ", b"class Other"))
NEWER = {
    "a page": b"<!DOCTYPE html>",
    "empty": b"",
    "blank": chain.notebook(chain.BLANK),
    "of another lesson": reduce(lambda text, change: text.replace(*change), OTHERS, GOOD),
}


@pytest.mark.parametrize("newer", NEWER)
def test_a_new_notebook_with_nothing_to_grade_keeps_the_earlier_result(toy, warm_server, tmp_path, newer):
    def run(number, content):
        root = tmp_path / f"in{number}"
        chain.hand_in(root, "ada", content)
        found = of_lessons(gather(root, root / "scratch", [chain.LESSON]), [chain.LESSON])
        publish = batch.feedback_writer(journal, tmp_path / "feedback")
        return grade_all(found, lambda _: toy[0], journal, server=warm_server, publish=publish)

    with Journal(tmp_path / "grades") as journal:
        run(0, GOOD)
        (before,) = journal.results()
        summary = run(1, NEWER[newer])
        (after,) = journal.results()
        assert after.exercises == before.exercises and after.written == before.written and after.earned > 0
        assert after.submission == before.submission
        assert len(summary.kept) == 1 and f"{before.earned:g} points before" in summary.kept[0]
        assert not summary.refused and not summary.graded
        page = next((tmp_path / "feedback" / "ada").iterdir()).read_text("utf-8")
        assert "this earlier notebook counts" in page
        assert run(2, NEWER[newer]).unchanged == 1  # it is not tried again and again
        journal.want_again("ada", chain.LESSON)
        run(3, NEWER[newer])
        (again,) = journal.results()
        assert again.left_out == after.left_out  # and said once
        run(4, chain.notebook(chain.MISTAKES))
        (result,) = journal.results()
        assert result.earned < before.earned and result.left_out == ()  # a worse answer is an answer


def test_control_c_ends_a_run_and_what_is_done_is_kept(toy, warm_server, tmp_path):
    (assignment, found), done = toy, []

    def tell(submission):
        done.append(submission)
        if len(done) == 2:
            raise KeyboardInterrupt

    grades = tmp_path / "grades"
    with Journal(grades) as journal:
        with pytest.raises(KeyboardInterrupt):
            grade_all(found, lambda _: assignment, journal, jobs=2, server=warm_server, tell=tell)
        assert len(journal.results()) == 2
        assert grade_all(found, lambda _: assignment, journal, jobs=2, server=warm_server).unchanged == 2
    assert len(kept(grades)) == 6 and rows(grades, "history") == 0


@posix
def test_a_full_disk_ends_the_run_with_a_clear_error(toy, warm_server, tmp_path):
    assignment, found = toy
    with Journal(tmp_path / "grades") as journal:
        pages = journal._database.execute("PRAGMA page_count").fetchone()[0]
        journal._database.execute(f"PRAGMA max_page_count = {pages + 1}")  # SQLite's own full disk
        with pytest.raises(JournalError, match="full.*Make room on the disk"):
            grade_all(found, lambda _: assignment, journal, jobs=2, server=warm_server)
    with Journal(tmp_path / "grades") as journal:
        whole = len(journal.results())
        assert grade_all(found, lambda _: assignment, journal, jobs=2, server=warm_server).unchanged == whole
    assert len(kept(tmp_path / "grades")) == 6


KILLED = """
import pickle, sys
from pathlib import Path
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.autograding.batch import grade_all
from nao_course.instructor.sandbox.layers import Layer, Sandbox
from nao_course.instructor.sandbox.warm_server import WarmServer
from nao_course.instructor.collecting.submissions import gather, of_lessons
assignment = pickle.loads(Path(sys.argv[1]).read_bytes())
found = gather(Path(sys.argv[2]), Path(sys.argv[3]), [assignment.lesson]).submissions
sandbox = pickle.loads(Path(sys.argv[5]).read_bytes())
with Journal(Path(sys.argv[4])) as journal, WarmServer(sandbox, warm=False) as server:
    print("ready", flush=True)
    done = grade_all(found, lambda _: assignment, journal, jobs=2, server=server)
print(done.graded, flush=True)
"""
KILLS = 8


def of_this_run(marker):
    """Processes with a marker in their environment or command."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            if marker in (path / "environ").read_bytes() + (path / "cmdline").read_bytes():
                found.append(path.name)
        except OSError:
            continue
    return found


def class_of_100(tmp_path):
    """Return a prepared lesson and a hundred submissions of four kinds."""
    kinds = [{}, chain.BLANK, chain.MISTAKES, {"double": chain.MISTAKES["double"]}]
    for number in range(100):
        content = chain.notebook(kinds[number % 4], extra=f"n = {number}")
        chain.hand_in(tmp_path / "in", f"s{number:03}", content)
    course = chain.make_course(tmp_path / "course")
    found = gather(tmp_path / "in", tmp_path, course.names()).submissions
    return prepare(course, "90", chain.SECRET), found


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
def test_a_grader_killed_at_any_moment_leaves_one_result_for_each(warm_server, tmp_path):
    """Eight times kill -9 and the same again: each submission has the result of an undisturbed run, once."""
    assignment, found = class_of_100(tmp_path)
    (tmp_path / "assignment").write_bytes(pickle.dumps(assignment))
    (tmp_path / "sandbox").write_bytes(pickle.dumps(probe()))
    with Journal(tmp_path / "undisturbed") as journal:
        grade_all(found, lambda _: assignment, journal, jobs=2, server=warm_server)
    wanted = kept(tmp_path / "undisturbed")
    chance, kills, rounds = random.Random(3), 0, 0
    marker = f"PATH_OF_RUN={tmp_path}"
    environment = os.environ | dict.fromkeys(("TMPDIR", "PATH_OF_RUN"), str(tmp_path))
    environment |= {"PYTHONPATH": str(PROJECT)}
    while kills < KILLS:
        grades, rounds = tmp_path / f"grades{rounds}", rounds + 1
        places = (tmp_path / "assignment", tmp_path / "in", tmp_path, grades, tmp_path / "sandbox")
        words = [sys.executable, "-c", KILLED, *map(str, places)]
        while True:
            process = subprocess.Popen(words, stdout=subprocess.PIPE, env=environment)
            process.stdout.readline()
            try:
                process.wait(chance.uniform(0.0, 1.5))
            except subprocess.TimeoutExpired:
                process.kill()
                kills += 1
            process.communicate()
            if process.returncode == 0:
                break
            assert process.returncode == -signal.SIGKILL
            assert all(wanted[key] == result for key, result in kept(grades).items())
        assert kept(grades) == wanted
        assert (rows(grades, "results"), rows(grades, "history")) == (len(found), 0)
    deadline = time.monotonic() + 300
    while of_this_run(marker.encode()) and time.monotonic() < deadline:
        time.sleep(0.2)
    assert of_this_run(marker.encode()) == []


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
def test_workers_and_servers_killed_at_any_moment_change_no_result(tmp_path):
    """Send kill -9 eight times to a worker's process or to the warm server: no result changes.

    A kill comes at a random moment, but not before every submission that was in progress at the last kill is done. If
    all attempts at a submission were ended at the same place, the grader could not tell this from a submission that
    ends its own process.
    """
    assignment, found = class_of_100(tmp_path)
    chance, kills = random.Random(4), 0
    servers, in_progress, disturbed = [], set(), set()

    def handed_out():
        for each in found:
            in_progress.add(each.student)
            yield each

    def done(submission):
        in_progress.discard(submission.student)
        disturbed.discard(submission.student)

    def one_run(grades):
        """Do what the command does, until the server cannot be started."""
        in_progress.clear()
        disturbed.clear()
        with (
            contextlib.suppress(SandboxError),
            WarmServer(probe(), warm=False) as server,
            Journal(grades) as journal,
        ):
            servers.append(server)
            summary = grade_all(handed_out(), lambda _: assignment, journal, jobs=2, server=server, tell=done)
            return not summary.failed
        return False

    assert one_run(tmp_path / "undisturbed")
    wanted, over = kept(tmp_path / "undisturbed"), threading.Event()

    def kill():
        nonlocal kills
        while not over.wait(chance.uniform(0.0, 0.5)):
            process = servers[-1].process
            if disturbed or not process:
                continue
            disturbed.update(in_progress)
            with contextlib.suppress(psutil.NoSuchProcess):
                server = psutil.Process(process)
                family = server.children(recursive=True)
                (chance.choice(family) if family and kills % 6 else server).kill()
                kills += 1

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        rounds = 0
        while kills < KILLS:
            grades, rounds = tmp_path / f"grades{rounds}", rounds + 1
            assert any(one_run(grades) for _ in range(50))  # the same command again goes on where it was
            assert kept(grades) == wanted
            assert (rows(grades, "results"), rows(grades, "history")) == (len(found), 0)
    finally:
        over.set()
        killer.join()
