"""`nao-course grade` and `regrade`: each submission gets one score or one reason, whatever happens to the run."""

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from contextlib import nullcontext

import pytest
from typer.testing import CliRunner

from nao_course import cli
from nao_course.instructor.autograding import batch, session
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.batch import grade_all
from nao_course.instructor.autograding.grader import GraderError
from nao_course.instructor.collecting.submissions import gather, of_lessons
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.scores import all_scores
from nao_course.instructor.sandbox.layers import Layer, Sandbox, probe
from tests.handed_in import packed, put
from tests.paths import PROJECT
from tests.toy import chain, pair
from tests.toy.graded import hand_in, kept, rows

posix = pytest.mark.skipif(sys.platform == "win32", reason="signals and modes of POSIX")


@pytest.fixture
def course(tmp_path, monkeypatch, secret):
    """A course in the working folder, a secret, and somewhere to hand in to."""
    made = chain.make_course(tmp_path / "course")
    monkeypatch.chdir(tmp_path / "course")
    monkeypatch.setattr(cli.console, "width", 200)
    return made


def prepared_here(course, lessons, secret):
    """What `prepare_in_background` promises, at once: starting a process takes long."""
    done = {lesson: Future() for lesson in lessons}
    for lesson, future in done.items():
        future.set_result(prepare(course, lesson, secret))
    return done


@pytest.fixture
def warm(warm_server, monkeypatch):
    """Let the commands use one server, and prepare in this process: starting others takes long."""
    monkeypatch.setattr(session, "WarmServer", lambda sandbox: nullcontext(warm_server))
    monkeypatch.setattr(session, "prepare_in_background", prepared_here)


@pytest.fixture
def handed_in(tmp_path):
    return hand_in(tmp_path / "in")


def run(*words, status=None):
    done = CliRunner().invoke(cli.app, [str(word) for word in words])
    assert status in (None, done.exit_code), done.output
    return done


def earned(grades, lesson=chain.LESSON):
    results = {who: found["exercises"] for (who, what), found in kept(grades).items() if what == lesson}
    return {who: sum(each["earned"] for each in exercises) for who, exercises in results.items()}


def test_a_class_is_graded_and_the_same_command_again_grades_nothing(course, warm, handed_in, tmp_path):
    grades = tmp_path / "grades"
    said = run("grade", handed_in, "--out", grades, status=0).output
    words = ("Sandbox: level", "graded", "refused", "eve, 90_chain: 90_chain.ipynb: not a notebook")
    assert all(word in said for word in (*words, "mean so far", "2.80 of 9 (5 graded in all)"))
    before = kept(grades)
    assert earned(grades) == {"ada": 7, "bob": 0, "cleo": 0, "dan": 3.5, "eve": 0, "fay": 3.5}
    assert before["ada", chain.LESSON]["level"] == probe().level
    run("grade", handed_in, "--out", grades, status=0)
    assert kept(grades) == before and rows(grades, "history") == 0
    assert len(list((grades / "feedback").rglob("*.html"))) == 6


def test_versions_are_shown_and_what_an_older_one_may_have_broken_waits_for_a_person(course, warm, tmp_path):
    """The receipt knows the libraries, and the notebook knows its Python."""
    newer = {"double": "def double(x):\n    return np.of_a_newer_numpy(x)  # 2"}
    notebook = json.loads(chain.notebook(newer))
    notebook["metadata"]["language_info"] = {"name": "python", "version": "3.1.7"}
    for student, numpy in {"ada": "99.1.0", "ben": "99.2", "eve": 3}.items():
        receipt = {"time": "2026-11-20T23:59:00+00:00", "versions": {"numpy": numpy}}
        files = {f"{chain.LESSON}.ipynb": notebook, "receipt.json": receipt}
        contents = {name: json.dumps(each).encode() for name, each in files.items()}
        packed(tmp_path / "in" / student / "work.zip", contents)
    chain.hand_in(tmp_path / "in", "fay", chain.notebook())
    said = run("grade", tmp_path / "in", "--out", tmp_path / "grades").output
    warning = "WARNING: notebooks were written with NumPy 99.1, NumPy 99.2, and the grader is older"
    assert said.count(warning) == 1
    assert "Written with NumPy 99.1 (1), NumPy 99.2 (1), Python 3.1 (3); graded with Python" in said
    listed = said.partition("NEEDS A DECISION")[2].splitlines()[1:3]
    for line, student in zip(listed, ("ada", "ben"), strict=True):
        assert line.strip().partition(":")[0] == f"{student}, {chain.LESSON}, double"
        assert "NumPy 99." in line and "the grader has NumPy" in line
    states = {who: found["exercises"][0]["state"] for (who, _), found in kept(tmp_path / "grades").items()}
    assert states == {"ada": "undecided", "ben": "undecided", "eve": "raised", "fay": "right"}
    page = (tmp_path / "grades" / "feedback" / "ada" / f"{chain.LESSON}.html").read_text("utf-8")
    assert "Written with Python 3.1, NumPy 99.1; graded with Python" in page
    again = run("grade", tmp_path / "in", "--out", tmp_path / "grades").output
    assert "WARNING" not in again and "Written with" not in again


@pytest.fixture
def pair_course(tmp_path, course, monkeypatch):
    """A course whose second lesson uses the first, in the working folder."""
    made = pair.make_course(tmp_path / "pair")
    monkeypatch.chdir(made.root)
    return made


@pytest.mark.slow
def test_earlier_work_comes_from_the_same_folder_or_an_earlier_run(pair_course, warm, tmp_path):
    first, second, grades = tmp_path / "first", tmp_path / "second", tmp_path / "grades"
    pair.write(first / "ada" / f"{pair.FIRST}.ipynb", pair.FIRST)
    for student in ("ada", "bob"):
        pair.write(second / student / f"{pair.SECOND}.ipynb", pair.SECOND)
    run("grade", second, "--out", grades, status=0)
    assert earned(grades, pair.SECOND) == {"ada": 29.0, "bob": 29.0}  # half of one exercise's points are lost
    run("grade", first, "--out", grades, status=0)
    run("grade", second, "--out", grades, status=0)
    assert earned(grades, pair.SECOND) == {"ada": 31.0, "bob": 29.0}
    assert rows(grades, "history") == 1  # of ada's, whose earlier work has come
    pair.write(second / "bob" / f"{pair.FIRST}.ipynb", pair.FIRST)
    for words in (["grade", second, "--out", grades], ["regrade", grades, "--student", "ada"]):
        run(*words, "--lesson", "81", status=0)
        assert earned(grades, pair.SECOND) == {"ada": 31.0, "bob": 31.0}


def test_earlier_work_does_not_come_from_a_wrapper_that_another_student_made(pair_course, warm, tmp_path):
    grades, name = tmp_path / "grades", f"{pair.FIRST}.ipynb"
    pair.write(tmp_path / "first" / "ada" / name, pair.FIRST)
    run("grade", tmp_path / "first", "--out", grades, status=0)
    put(tmp_path / "second" / "Eve", f"ada/{name}", f"bob/{name}")
    said = run("grade", tmp_path / "second", "--out", grades).output
    assert f"ada, {pair.FIRST}" in said.partition("NOT GRADED")[2]
    pair.write(tmp_path / "third" / "ada" / f"{pair.SECOND}.ipynb", pair.SECOND)
    run("grade", tmp_path / "third", "--out", grades, status=0)
    assert earned(grades, pair.SECOND)["ada"] == 31.0


def test_an_earlier_lesson_that_is_not_what_was_built_stops_the_lesson_that_uses_it(
    pair_course, warm, tmp_path
):
    pair.write(tmp_path / "in" / "ada" / f"{pair.SECOND}.ipynb", pair.SECOND)
    pair_course.text(pair.FIRST).write_text("# edited")
    result = run("grade", tmp_path / "in", "--out", tmp_path / "grades")
    assert result.exit_code == 1 and f"solutions/{pair.FIRST}.md was edited" in result.output
    assert not (tmp_path / "grades").exists()


def test_only_what_has_changed_is_graded_again(course, warm, handed_in, tmp_path):
    grades = tmp_path / "grades"
    run("grade", handed_in, "--out", grades)
    chain.hand_in(handed_in, "bob", chain.notebook())
    chain.hand_in(handed_in, "eve", chain.notebook())
    chain.hand_in(handed_in, "gus", chain.notebook())
    assert run("grade", handed_in, "--out", grades).exit_code == 0
    assert (rows(grades, "results"), rows(grades, "history")) == (7, 2)
    assert sum(each["earned"] for each in kept(grades)["bob", chain.LESSON]["exercises"]) == 7
    path = course.solutions / "exercises" / f"{chain.LESSON}.py"
    path.write_text(path.read_text().replace('"slip"', '"slop"'))
    chain.stamp(course, chain.LESSON)
    run("grade", handed_in, "--out", grades)
    assert rows(grades, "history") == 2 + 7  # another assignment: all of them


def test_a_lesson_can_be_chosen(course, warm, handed_in, tmp_path):
    run("grade", handed_in, "--out", tmp_path / "g", "--lesson", "90", status=0)
    assert len(kept(tmp_path / "g")) == 6


def test_a_sandbox_that_is_too_weak_is_refused_before_anything_runs(course, handed_in, tmp_path, monkeypatch):
    others = tuple(each for each in probe().layers if each.name != "landlock")
    weak = Sandbox((*others, Layer("landlock", False, "not today")))
    monkeypatch.setattr(session, "probe", lambda: weak)
    for level, reason in (("full", "not today"), ("iron", "iron")):
        said = run("grade", handed_in, "--out", tmp_path / "grades", "--require-sandbox", level, status=1)
        assert reason in said.output and kept(tmp_path / "grades") == {}


def test_a_stranger_in_the_folder_is_named_and_stops_nobody(course, warm, handed_in, tmp_path):
    (handed_in / "ada" / "essay.ipynb").write_text("{}")
    (handed_in / "[red]x[").mkdir()
    shutil.copy(handed_in / "ada" / f"{chain.LESSON}.ipynb", handed_in / "[red]x[")
    (handed_in / "gil").mkdir()
    for number in range(25):
        (handed_in / "ada" / f"junk{number}.txt").write_text("junk")
    said = run("grade", handed_in, "--out", tmp_path / "grades")
    assert said.exit_code == 1
    not_graded = said.output.partition("NOT GRADED:")[2]
    assert "ada/essay.ipynb: it is named after no lesson" in not_graded
    assert "gil: there is no notebook of a lesson" in not_graded and "junk" not in not_graded
    students = {student for student, _ in kept(tmp_path / "grades")}
    assert {"ada", "bob", "[red]x["} < students and "gil" not in students


def test_a_wrapper_is_named_and_replaces_no_result(course, warm, tmp_path):
    grades = tmp_path / "grades"
    chain.hand_in(tmp_path / "first", "ada", chain.notebook())
    assert run("grade", tmp_path / "first", "--out", grades).exit_code == 0
    before = kept(grades)
    for student in ("ada", "ben"):
        chain.hand_in(tmp_path / "second" / "Eve", student, b"{")
    said = run("grade", tmp_path / "second", "--out", grades)
    assert "The folder Eve is around all submissions" in said.output
    assert said.exit_code == 1 and "ada, 90_chain: there is a result already" in said.output
    assert kept(grades)["ada", chain.LESSON] == before["ada", chain.LESSON]
    assert run("regrade", grades, "--student", "ada").exit_code == 0
    assert kept(grades)["ada", chain.LESSON] == before["ada", chain.LESSON]
    for student in ("ADA", "cleo"):
        chain.hand_in(tmp_path / "third" / "Eve", student, chain.notebook(chain.BLANK))
    said = run("grade", tmp_path / "third", "--out", grades)
    assert "ADA is ada: the only student of this name" in said.output
    assert "ada, 90_chain: there is a result already" in said.output
    assert {student for student, _ in kept(grades)} == {"ada", "ben", "cleo"}


def test_the_list_of_what_is_not_graded_is_whole_and_survives_regrade(course, warm, tmp_path):
    grades = tmp_path / "grades"
    chain.hand_in(tmp_path / "in", "ada", chain.notebook())
    for number in range(25):
        (tmp_path / "in" / f"s{number}").mkdir()
        chain.hand_in(tmp_path / "in", f"r{number}", b"{")
    said = run("grade", tmp_path / "in", "--out", grades)
    assert all(f"r{number}, 90_chain: " in said.output for number in range(25))
    assert len((grades / "not_graded.txt").read_text().splitlines()) == 25
    assert run("regrade", grades, "--student", "ada").exit_code == 0
    assert (grades / "not_graded.txt").exists()


def test_an_error_of_the_graders_own_is_said_and_the_status_is_not_0(
    course, warm, handed_in, tmp_path, monkeypatch
):
    real = batch.grade

    def fails_at_bob(submission, assignment, **more):
        if submission.student == "bob":
            raise GraderError("bob: the grader failed")
        return real(submission, assignment, **more)

    monkeypatch.setattr(batch, "grade", fails_at_bob)
    said = run("grade", handed_in, "--out", tmp_path / "grades")
    assert said.exit_code == 1 and "NOT GRADED" in said.output and "bob: the grader failed" in said.output
    assert "bob" not in {student for student, _ in kept(tmp_path / "grades")}
    monkeypatch.undo()
    assert len(kept(tmp_path / "grades")) == 5


@posix
@pytest.mark.slow
def test_control_c_on_the_command_is_no_traceback(course, tmp_path):
    for name in ("a1", "a2"):
        chain.hand_in(tmp_path / "in", name, chain.notebook())
    for number in range(40):  # so slow that the run cannot end before it is interrupted
        slow = f"import time\ndef double(x):\n    time.sleep(5 + {number} / 100)"
        chain.hand_in(tmp_path / "in", f"s{number}", chain.notebook({"double": slow}))
    words = ["grade", str(tmp_path / "in"), "--out", str(tmp_path / "grades")]
    process = subprocess.Popen(
        [sys.executable, "-m", "nao_course.cli", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(PROJECT)},
        start_new_session=True,
    )
    pages = tmp_path / "grades" / "feedback"
    while len(list(pages.rglob("*.html"))) < 2 and process.poll() is None:  # then the first result is kept
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    said, error = process.communicate(timeout=600)
    assert (process.returncode, error) == (130, "")
    assert "Stopped. What is graded is kept" in said
    assert 0 < len(kept(tmp_path / "grades")) < 40


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="a file system of 200 kB in a namespace")
def test_a_really_full_disk_is_said_without_a_traceback(course, handed_in, tmp_path):
    (tmp_path / "small").mkdir()
    if subprocess.run(["unshare", "-rm", "true"], capture_output=True).returncode:
        pytest.skip("no user namespaces here")
    for number in range(60):
        chain.hand_in(handed_in, f"more{number}", b"{")
    mount = f'mount -t tmpfs -o size=200k none {tmp_path}/small && cd {tmp_path}/course && exec "$@"'
    words = ["unshare", "-rm", "sh", "-c", mount, "sh", sys.executable, "-m", "nao_course.cli", "grade"]
    words += [str(handed_in), "--out", f"{tmp_path}/small/grades"]
    environment = os.environ | {"PYTHONPATH": str(PROJECT)}
    done = subprocess.run(words, capture_output=True, text=True, env=environment)
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert "disk is full" in done.stderr or "No space left" in done.stderr


@pytest.fixture(scope="module")
def graded_once(warm_server, tmp_path_factory):
    """The grades of the class, to be copied."""
    place = tmp_path_factory.mktemp("graded")
    assignment = prepare(chain.make_course(place / "course"), "90", chain.SECRET)
    found = of_lessons(gather(hand_in(place / "in"), place, [chain.LESSON]), [chain.LESSON])
    with Journal(place / "grades") as journal:
        more = {"publish": batch.feedback_writer(journal, place / "grades" / "feedback"), "jobs": 2}
        grade_all(found, lambda _: assignment, journal, server=warm_server, level=probe().level, **more)
    return place / "grades"


@pytest.fixture
def graded(course, warm, handed_in, graded_once, tmp_path):
    grades = tmp_path / "grades"
    shutil.copytree(graded_once, grades)
    with Journal(grades) as journal:
        journal.began(handed_in)
    return grades


def test_points_can_be_given_by_hand_with_a_reason(graded):
    run("regrade", graded, "--student", "cleo", "--set", "double=1.5", "--reason", "nearly", status=0)
    with Journal(graded) as journal:
        (override,) = journal.overrides()
    assert (override.student, override.exercise) == ("cleo", "double")
    assert (override.points, override.reason) == (1.5, "nearly")
    (page,) = (graded / "feedback").rglob("*leo*/*.html")
    assert "nearly" in page.read_text()


@pytest.mark.slow
def test_decisions_stay_with_the_answer_that_they_were_made_for(course, warm, tmp_path):
    grades, sheet = tmp_path / "grades", tmp_path / "grades" / "marking" / f"{chain.LESSON}_why.csv"

    def grade(answer, **functions):
        chain.hand_in(tmp_path / "in", "ada", chain.notebook(functions, answer))
        said = run("grade", tmp_path / "in", "--out", grades)
        assert said.exit_code == 0, said.output
        with Journal(grades) as journal:
            (score,) = all_scores(journal)
        return {each.name: score.of(each) for each in score.result.exercises}, score.waiting, said.output

    slip = chain.MISTAKES["double"]
    grade("Because.", double=slip)
    run("marks", grades)
    sheet.write_text(sheet.read_text("utf-8-sig").replace("Because.,,,", "Because.,1.5,,"), "utf-8")
    assert "read, 1 of them new" in run("marks", grades, sheet).output
    run("regrade", grades, "--student", "ada", "--set", "double=1", "--reason", "nearly")
    points, waiting, said = grade("Because.", double=slip, total=chain.MISTAKES["total"])
    assert (points["double"], points["total"], waiting) == (1, 0, ()) and "Decisions" not in said
    points, waiting, said = grade("Since.", double=f"{slip}  # again")
    assert (points["double"], len(waiting)) == (0, 1)
    assert "1 marked answer has changed: run nao-course marks" in said
    assert "ada, 90_chain, double: 1 by hand for an earlier answer; now the grader's 0 count" in said
    points, waiting, _ = grade("Because.", double=chain.RIGHT["double"])
    assert (points["double"], waiting) == (2, ())


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("cleo --set double=1", "--reason"),
        ("cleo --set double=1 --reason ' '", "--reason"),
        ("cleo --set double=2.5 --reason x", "0 to 2 points, got 2.5"),
        ("cleo --set double=nan --reason x", "0 to 2 points"),
        ("cleo --set double --reason x", "EXERCISE=POINTS"),
        ("cleo --set treble=1 --reason x", "no exercise 'treble'"),
        ("cloe --set double=1 --reason x", "is it 'cleo'"),
        ("cleo --lesson 03 --set double=1 --reason x", "--lesson"),
    ],
)
def test_points_that_make_no_sense_are_refused(graded, words, reason):
    said = run("regrade", graded, "--student", *shlex.split(words), status=1)
    assert reason in said.output
    with Journal(graded) as journal:
        assert journal.overrides() == []


def test_a_student_of_several_lessons_is_asked_which(graded):
    with Journal(graded) as journal:
        result = next(journal.each_result(student="cleo"))
        journal.keep(type(result)(**(vars(result) | {"lesson": "91_other"})))
    words = ["--student", "cleo", "--set", "double=1", "--reason", "x"]
    said = run("regrade", graded, *words)
    assert said.exit_code == 1 and "90_chain, 91_other" in said.output
    assert run("regrade", graded, *words, "--lesson", "90").exit_code == 0


def test_a_submission_is_graded_again_on_demand_and_found_again_after_another_run(
    graded, handed_in, tmp_path
):
    before = kept(graded)
    run("regrade", graded, "--student", "cleo", status=0)
    assert rows(graded, "history") == 1 and kept(graded) == before
    (tmp_path / "late" / "zoe").mkdir(parents=True)
    shutil.copy(next((handed_in / "ada").glob("*.ipynb")), tmp_path / "late" / "zoe")
    run("grade", tmp_path / "late", "--out", graded, status=0)
    run("regrade", graded, "--student", "bob", status=0)
    assert rows(graded, "history") == 2


def test_what_the_sandbox_saw_is_said(course, warm, handed_in, tmp_path):
    if probe().level == "process":
        pytest.skip("there is no sandbox that could see something")
    notebook = next((handed_in / "bob").glob("*.ipynb"))
    cells = json.loads(notebook.read_text())
    cells["cells"].append(
        {"cell_type": "code", "source": "SEEN = open('/etc/shadow').read()", "metadata": {}, "outputs": []}
    )
    notebook.write_text(json.dumps(cells))
    result = run("grade", handed_in, "--out", tmp_path / "grades")
    assert "Seen by the sandbox:" in result.output and "bob, 90_chain: open /etc/shadow" in result.output
    assert run("report", tmp_path / "grades").exit_code == 0
    assert "open /etc/shadow" in (tmp_path / "grades" / "report.html").read_text()


def test_where_the_submissions_are_gone_it_waits_for_the_next_run(graded, handed_in, tmp_path):
    handed_in.rename(tmp_path / "moved")
    assert "next `nao-course grade`" in run("regrade", graded, "--student", "cleo").output
    assert run("grade", tmp_path / "moved", "--out", graded).exit_code == 0
    assert rows(graded, "history") == 1
