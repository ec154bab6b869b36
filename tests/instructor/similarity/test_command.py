"""`nao-course similar`: reads what `grade` reads, and writes a page that nobody's notebook can take over."""

import json
from base64 import b64encode

import nbformat
import pytest
from typer.testing import CliRunner

from benchmarks.course.similar import disguised, renamed
from nao_course import cli
from nao_course.exercises.definitions import load_definitions
from nao_course.instructor.similarity import comparing
from nao_course.instructor.similarity.comparing import LONGEST, MOST_SHOWN, Comparison, SimilarPair, Work
from nao_course.instructor.similarity.course_answers import CourseAnswers, SameWords
from nao_course.instructor.similarity.own_code import with_executed_texts
from nao_course.instructor.similarity.page import Found, similar_page
from tests.instructor.similarity.test_comparing import OWN
from tests.pages import HOSTILE, Page
from tests.paths import PROJECT

LESSON = "02_goalposts"


@pytest.fixture(autouse=True)
def in_the_course(monkeypatch):
    monkeypatch.chdir(PROJECT)
    monkeypatch.setattr(cli.console, "width", 200)


def similar(folder, *words):
    done = CliRunner().invoke(cli.app, ["similar", str(folder), "--out", str(folder.parent / "out"), *words])
    page = folder.parent / "out" / "similar.html"
    return done, Page(page.read_text("utf-8")) if page.exists() else None


def hand_in(folder, student, code="", name=f"{LESSON}.ipynb", **metadata):
    notebook = nbformat.read(PROJECT / "notebooks" / f"{LESSON}.ipynb", as_version=4)
    if code:
        notebook.cells.append(nbformat.v4.new_code_cell(code, metadata=metadata))
    path = folder / student / name
    path.parent.mkdir(parents=True, exist_ok=True)
    nbformat.write(notebook, path)
    return path


def test_a_copy_is_shown_side_by_side_and_released_code_is_not(tmp_path):
    folder = tmp_path / "in"
    for student, code in {"ada": OWN, "ben": "", "eve": disguised(OWN), "zoe": ""}.items():
        hand_in(folder, student, code)
    done, page = similar(folder, "--lesson", "02")
    assert done.exit_code == 0, done.output
    assert f"{LESSON}: 4 notebooks, 1 similar pair" in done.output
    assert "ada and eve" in page.text and "ben" not in page.text and "zoe" not in page.text
    assert page.tags.count("mark") >= 2 and page.offences() == []


def test_helper_files_count_as_own_code_and_large_outputs_do_not_hinder(tmp_path):
    folder = tmp_path / "in"
    for student in ("ada", "ben"):
        path = hand_in(folder, student)
        path.with_name("tools.py").write_text(OWN)
    notebook = json.loads(path.read_text("utf-8"))
    notebook["cells"][-1]["outputs"] = [{"output_type": "stream", "name": "stdout", "text": "x" * 3 * 2**20}]
    path.write_text(json.dumps(notebook))
    assert "1 similar pair" in similar(folder)[0].output


def test_what_the_grader_runs_is_compared_whatever_its_cell_is_called(tmp_path):
    folder = tmp_path / "in"
    role = {"nao_course": {"role": "mine"}}
    ways = {
        "ada": hand_in(folder, "ada", OWN, **role),
        "ben": hand_in(folder, "ben", f"exec({OWN!r})", **role),
        "cyd": hand_in(folder, "cyd", f"half = {OWN[:99]!r}\nexec(compile(half + {OWN[99:]!r}, '', 'exec'))"),
        "dan": hand_in(folder, "dan", f"exec('\\n'.join({OWN.splitlines()!r}))"),
        "fay": hand_in(folder, "fay", f"import base64\nexec(base64.b64decode({b64encode(OWN.encode())!r}))"),
    }
    for path in ways.values():
        assert "centre" in load_definitions(path)
    done, page = similar(folder)
    assert "6 similar pairs" in done.output  # all but the last one's
    assert "fay, 02_goalposts: code that is put together while it runs was not compared" in page.text
    assert "ben, 02_goalposts: code" not in page.text


def test_texts_that_double_from_name_to_name_and_hundreds_of_commands_stop_nobody(tmp_path):
    doubled = "\n".join(f"a{i + 1} = a{i} + a{i}" for i in range(14))
    bomb = with_executed_texts({"cell 1": f"a0 = {'x' * 60_000!r}", "cell 2": f"{doubled}\nexec(a14)"})
    assert max(map(len, bomb.cells)) <= 3 * LONGEST
    assert bomb.hidden == ("cell 2, line 15",)
    folder = tmp_path / "in"
    hand_in(folder, "ada", OWN)
    hand_in(folder, "ben", "!a\n" * 600)
    hand_in(folder, "eve", OWN)
    done, _ = similar(folder, "--lesson", "02")
    assert done.exit_code == 0, done.output
    assert f"{LESSON}: 3 notebooks, 1 similar pair" in done.output


def test_a_folder_without_two_notebooks_is_refused_and_a_student_is_not_similar_to_the_same_student(tmp_path):
    folder = tmp_path / "in"
    folder.mkdir()
    for _ in range(2):
        done, page = similar(folder)
        assert done.exit_code == 1 and "no two notebooks of a lesson" in done.output and page is None
        hand_in(folder, "ada", OWN)
    hand_in(folder, "ada", OWN, f"{LESSON} (1).ipynb")
    hand_in(folder, "ben")
    done, page = similar(folder)
    assert "2 notebooks, 0 similar pairs" in done.output and "ada" not in page.text
    hand_in(folder, "cyd", OWN)
    hand_in(folder, "eve").write_text("no notebook")
    hand_in(folder, "zoe").write_text("")
    done, page = similar(folder)
    assert "1 similar pair" in done.output
    assert "eve, 02_goalposts:" in page.text and "zoe, 02_goalposts: it is empty" in page.text


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_names_and_code_stay_text(text):
    first, second = Work(text, (text, text * 3)), Work("ben", (text,))
    pair = SimilarPair(first, second, (0.5, 0.1), 40, ([(1, 3), (4, 9)], [(0, len(text))]))
    common = comparing.CommonCode((first, second), (0.5, 1.0), [(1, 3)])
    copied, words = CourseAnswers(text, (text,), 3), SameWords(text, (text, "ben"), True, text)
    page = Page(similar_page({LESSON: Found(Comparison(2, [pair], [common]), [copied], [words])}, [text]))
    assert page.offences() == [] and page.text.count("marked in the first notebook") == 1


def test_only_the_first_pairs_show_their_code_and_of_it_what_is_near_a_passage():
    code = "".join(f"line_{number}\n" for number in range(40))
    start, work = code.index("line_20"), Work("ada", (code,))
    pair = SimilarPair(work, work, (1, 1), 40, ([(start, start + 7)], []))
    page = Page(similar_page({LESSON: Found(Comparison(2, [pair]))}, []))
    shown = page.text.partition("[16 other lines]")[2].partition("[16 other lines]")[0]
    assert shown.split() == [f"line_{number}" for number in range(16, 24)]
    pairs = [SimilarPair(work, Work(f"s{k}", ("y",)), (0.5, 0.5), 40) for k in range(MOST_SHOWN + 5)]
    page = Page(similar_page({LESSON: Found(Comparison(2, pairs))}, []))
    assert page.tags.count("section") == MOST_SHOWN and page.tags.count("tr") == MOST_SHOWN + 6
    assert f"ada and s{MOST_SHOWN + 4}" in page.text


def test_the_courses_own_solution_and_its_words_are_found_whatever_its_names_are(tmp_path):
    folder = tmp_path / "in"
    solution = nbformat.read(PROJECT / "solutions" / f"{LESSON}.ipynb", as_version=4)
    for student, change in (("ada", str), ("eve", renamed)):
        notebook = nbformat.from_dict(solution)
        for cell in notebook.cells:
            if cell.metadata.get("nao_course", {}).get("role") == "exercise":
                cell.source = change(cell.source)
        (folder / student).mkdir(parents=True)
        nbformat.write(notebook, folder / student / f"{LESSON}.ipynb")
    hand_in(folder, "ben", OWN)
    done, page = similar(folder)
    assert (
        "3 notebooks, 0 similar pairs, 2 with the course's own answers, 1 group with the same words"
        in done.output
    )
    assert "The course's own answers: 2 students" in page.text and "3 of 3" in page.text
    assert "ada, eve, the course's model answer" in page.text and "ben" not in page.text
    assert page.offences() == []
