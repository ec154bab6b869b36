"""A notebook that another program has saved gets the same points, and nobody is asked about it without need."""

import json
import re
import zipfile

import pytest

from nao_course import homework, student
from nao_course.exercises.cells import is_solution
from nao_course.exercises.definitions import load_definitions
from nao_course.exercises.earlier import resolved_by
from nao_course.exercises.notebook_text import read_notebook, without_outputs
from nao_course.exercises.outline import read_outline
from nao_course.instructor.authoring.plans import load_solution, publish, solutions_beside
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.grader import grade
from nao_course.instructor.collecting.submissions import gather
from nao_course.instructor.gradebook.scores import score
from nao_course.instructor.reports.feedback import feedback_page
from nao_course.instructor.similarity.comparing import Work, compare
from nao_course.instructor.similarity.known_code import known_code
from nao_course.instructor.similarity.own_code import own_code
from nao_course.student import notebooks
from tests.exercises.test_odd_notebooks import fingerprint
from tests.paths import PROJECT
from tests.real_life.front_ends import FRONT_ENDS, FrontEnd
from tests.toy import chain, pair

LESSONS = [path.stem for path in sorted((PROJECT / "solutions").glob("*.ipynb"))]
JUPYTERLAB = FrontEnd(lambda notebook: notebook)
WRONG = {"double": chain.MISTAKES["double"]}
DOUBLED = "the same, after it has doubled all cells"
# What the assistant reads about a notebook beyond what is said about the same one from JupyterLab: a module that only
# the program has.
NOTES = {"JupyterLite": r"code cell 1, line 1: ModuleNotFoundError: No module named 'piplite'"}
each_front_end = pytest.mark.parametrize("name", FRONT_ENDS)


def released(folder, lesson):
    return (PROJECT / folder / f"{lesson}.ipynb").read_bytes()


def read(path, lesson):
    return load_definitions(path, released=read_outline(lesson))


@each_front_end
@pytest.mark.parametrize("folder", ["solutions", "notebooks"])
@pytest.mark.parametrize(
    "lesson", [pytest.param(each, marks=() if each == LESSONS[1] else pytest.mark.slow) for each in LESSONS]
)
def test_the_same_answers_are_found_in_a_lesson_of_the_release(name, lesson, folder, tmp_path):
    content = released(folder, lesson)
    path = FRONT_ENDS[name].write(tmp_path, lesson, content)
    found, plain = (
        read(each, lesson) for each in (path, JUPYTERLAB.write(tmp_path / "plain", lesson, content))
    )
    names = read_outline(lesson).exercises
    assert {each: fingerprint(found[each]) for each in names} == {
        each: fingerprint(plain[each]) for each in names
    }
    assert (found.text.written, found.text.remarks) == (plain.text.written, plain.text.remarks)
    if name == DOUBLED:
        assert found.remarks.keys() == names  # each says that the later copy is graded
    else:
        assert found.remarks == plain.remarks
    assert found.text.python in ("", "3.11.7", "3.12.8")
    short = tmp_path / "short.ipynb"
    short.write_bytes(without_outputs(path.name, path.read_bytes()))
    assert read_notebook(short, read_outline(lesson)) == found.text


QUESTION = "lesson01-explain_stray_pixel"
WITHOUT_IDS = ("Kaggle", "Deepnote", DOUBLED)


@each_front_end
@pytest.mark.parametrize("above", [1, 10])
def test_a_text_cell_that_a_student_has_changed_is_an_answer_only_directly_above_its_question(
    name, above, tmp_path
):
    # Such a cell is known by its identifier only: it has no name for nbgrader, and its text is not the release's.
    notebook = json.loads(released("notebooks", LESSONS[1]))
    (at,) = (at for at, cell in enumerate(notebook["cells"]) if cell["id"] == QUESTION)
    changed = notebook["cells"][at - above]
    assert changed["cell_type"] == "markdown"
    changed["source"] += "\n\nIt is one pixel of the wall."
    content = json.dumps(notebook).encode()
    found, plain = (
        read(each.write(tmp_path / where, LESSONS[1], content), LESSONS[1]).text
        for where, each in (("found", FRONT_ENDS[name]), ("plain", JUPYTERLAB))
    )
    assert bool(plain.written["explain_stray_pixel"]) == (above == 1)
    assert found.written == plain.written
    # Without identifiers, it is taken for a text of the student's own at another place.
    assert found.remarks == plain.remarks or name in WITHOUT_IDS


# --- from the student's folder to the feedback page ---


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    return chain.make_course(tmp_path_factory.mktemp("course"))


@pytest.fixture(scope="module")
def assignment(course):
    return prepare(course, chain.LESSON, chain.SECRET)


def public(course):
    """Return the checks' data of a course, as a student has them."""
    found = {}
    for lesson in course.names():
        notebook = course.solutions / f"{lesson}.ipynb"
        with resolved_by(solutions_beside(notebook)):
            found[lesson] = publish(lesson, course.plan(lesson), load_solution(notebook))
    return found


@pytest.fixture
def known(monkeypatch):
    """Let the student's side know the lessons of a course, and no others."""

    def know(course):
        data = public(course)
        monkeypatch.delenv("NAO_COURSE_NOTEBOOKS", raising=False)
        monkeypatch.delenv("NAO_COURSE_STRICT", raising=False)
        monkeypatch.setattr(notebooks, "read_public", data.__getitem__)
        for module in (notebooks, homework):
            monkeypatch.setattr(module, "lessons", lambda: sorted(data))

    return know


def as_released(content):
    """Add what a release adds to its cells: exercises cannot be deleted, and the set-up is folded."""
    notebook = json.loads(content)
    for cell in notebook["cells"]:
        folded = {"jupyter": {"source_hidden": True}, "editable": False}
        cell["metadata"] |= {"deletable": False} | ({} if is_solution(cell) else folded)
    return json.dumps(notebook).encode()


def handed_in(folder, front_end, student_name, functions):
    """Return a student's folder of notebooks and the one submission in what was handed in from it."""
    content = as_released(chain.notebook(functions, answer="Because of the carpet."))
    path = front_end.write(folder / student_name / "work", chain.LESSON, content)
    (folder / student_name / "scratch").mkdir()
    there = folder / student_name / "in" / student_name
    there.mkdir(parents=True)
    (there / path.name).write_bytes(path.read_bytes())
    found = gather(there.parent, folder / student_name / "scratch", [chain.LESSON])
    assert not (found.refused or found.unknown or found.not_graded or found.older)
    (submission,) = found.submissions
    return path, submission


def plain_page(result):
    """Return the feedback page without the student, the file and the versions."""
    return re.sub(r"Graded from .*? Hidden cases|<bdi>\w+</bdi>", "", feedback_page(score(result)))


@each_front_end
def test_check_submission_grade_and_page_are_those_of_the_same_notebook(
    name, course, assignment, known, warm_server, tmp_path
):
    known(course)
    results, checks = [], []
    for who, front_end in (("ada", FRONT_ENDS[name]), ("bob", JUPYTERLAB)):
        path, submission = handed_in(tmp_path, front_end, who, WRONG)
        found = student.functions(chain.LESSON, path.parent)
        checks.append(
            (list(found), [(each.name, each.state, each.lines) for each in found.reports], found.unwritten)
        )
        receipt = homework.submit(path.parent, tmp_path / who / "zips")
        with zipfile.ZipFile(receipt.path) as packed:
            assert packed.read(path.name) == path.read_bytes()
        results.append(grade(submission, assignment, warm_server, "full"))
    mine, plain = results
    assert checks[0] == checks[1]
    assert (mine.status, mine.earned) == ("graded", plain.earned) and mine.points > mine.earned > 0
    assert [each.text for each in mine.written] == ["Because of the carpet."]
    assert [(each.note, each.text) for each in mine.written] == [
        (each.note, each.text) for each in plain.written
    ]
    assert plain.notes == () and all(re.fullmatch(NOTES.get(name, "none"), each) for each in mine.notes)
    assert bool(mine.notes) == (name in NOTES)
    assert plain_page(mine) == plain_page(plain)


LONGER = {
    "total": "def total(x):\n    rows = [sum(row) for row in x]\n    result = 0.0\n    for each in rows:\n"
    "        result = result + float(each)\n    return result"
}


@each_front_end
def test_a_copy_is_found_and_two_users_of_one_program_are_not_similar(name, course, tmp_path):
    def work(who, front_end, functions):
        return Work(who, own_code(handed_in(tmp_path, front_end, who, functions)[1]).cells)

    copied = [work("ada", FRONT_ENDS[name], LONGER), work("bob", JUPYTERLAB, LONGER)]
    own = [work("cyd", FRONT_ENDS[name], LONGER), work("dan", FRONT_ENDS[name], {})]
    given = known_code(course, chain.LESSON)
    assert len(compare(copied, given).pairs) == 1
    found = compare(own, given)
    assert not found.pairs and not found.common


@pytest.fixture(scope="module")
def lessons(tmp_path_factory):
    return pair.make_course(tmp_path_factory.mktemp("pair"))


@each_front_end
def test_functions_of_an_earlier_lesson_are_found(name, lessons, known, tmp_path):
    known(lessons)
    for lesson in (pair.FIRST, pair.SECOND):
        content = chain.as_notebook(lesson, chain.solutions(pair.SETUP[lesson], pair.RIGHT[lesson]))
        FRONT_ENDS[name].write(tmp_path, lesson, as_released(content))
    assert student.earlier("80:double", tmp_path)(4.0) == 8.0
    found = student.functions(pair.SECOND, tmp_path)
    assert found.complete and found["tally"](3.0) == 4.0


@each_front_end
def test_a_newer_release_keeps_every_answer_and_repeats_no_released_cell(name, tmp_path):
    lesson = LESSONS[1]
    notebook = json.loads(released("notebooks", lesson))
    release = tmp_path / "release" / "notebooks" / f"{lesson}.ipynb"
    release.parent.mkdir(parents=True)
    release.write_text(json.dumps(notebook))
    homework.renew(tmp_path)
    mine = tmp_path / "notebooks" / f"{lesson}.ipynb"
    FRONT_ENDS[name].write(tmp_path / "saved", lesson, released("solutions", lesson)).replace(mine)
    before = read(mine, lesson)
    notebook["cells"][1]["source"] += "\n\nThis is new."
    release.write_text(json.dumps(notebook))
    homework.renew(tmp_path)
    after = read(mine, lesson)
    added = len(json.loads(mine.read_bytes())["cells"]) - len(notebook["cells"])
    assert added <= (len(read_outline(lesson).exercises) + 1 if name == DOUBLED else 3)
    names = read_outline(lesson).exercises
    assert [fingerprint(after[each]) for each in names] == [fingerprint(before[each]) for each in names]
    assert after.text.written == before.text.written


def test_the_students_guide_names_each_program_with_its_note():
    text = (PROJECT / "docs" / "for_students.md").read_text(encoding="utf-8")
    _, _, table = text.partition("| program |")
    rows = [
        [part.strip() for part in row.split("|")[1:-1]] for row in table.split("\n\n")[0].splitlines()[2:]
    ]
    assert [name for name, _, _ in rows] == list(FRONT_ENDS)
    with_a_note = {name for name, works, _ in rows if works == "with a note"}
    assert with_a_note >= {*NOTES, DOUBLED} and {works for _, works, _ in rows} == {"yes", "with a note"}
    assert all(bool(note) == (works == "with a note") for _, works, note in rows)
