"""Every lesson of the course, in solutions/ and as a student gets it: what a great lesson is, where a machine can tell.

A new lesson is tested as soon as its text is there. What it asks of exercises is in test_exercises.py; that it is built
as it is written, in test_built.py.
"""

import ast
import base64
import re
from functools import cache
from itertools import pairwise

import nbformat
import pytest

from nao_course.instructor.authoring import lesson_text
from tests.lessons.every import (
    COURSE,
    PROJECT,
    each_lesson,
    earlier_functions_are_the_references,  # noqa: F401 - for every test here
    executed,
    public,
    solved,
    student_copy,
    waived,
    waived_rules_are_skipped,  # noqa: F401 - for every test here
)

LONG = {"01", "02", "05", "06", "07", "08", "09", "10", "11", "12"}  # more than one session


def prose(notebook):
    return "\n\n".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")


def headings(text):
    outside = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.findall(r"^#+ .+", outside, re.MULTILINE)


@each_lesson
def test_rubric_1_one_title_and_a_first_cell_that_says_what_is_needed(name):
    notebook = solved(name)
    titles = headings(prose(notebook))
    levels = [len(title.split()[0]) for title in titles]
    assert levels[0] == 1 and levels.count(1) == 1, f"the text begins with its only title of one #: {titles}"
    assert all(after <= before + 1 for before, after in pairwise(levels)), f"a level is skipped: {titles}"
    first = notebook.cells[0].source
    wanted = r"\*\*Before you start\*\*", r"\*\*Follows\*\*", r"\*\*Time:\*\* \d+ minutes"
    missing = [each.replace("\\", "") for each in wanted if not re.search(each, first)]
    assert not missing, f"the first cell lacks {', '.join(missing)}"


@each_lesson
def test_rubric_2_three_to_five_objectives_that_name_every_exercise(name):
    (objectives,) = re.findall(
        r"^## What you will be able to do\n(.*?)(?=^#|\Z)", prose(solved(name)), re.MULTILINE | re.DOTALL
    )
    items = re.findall(r"^- .*(?:\n  .*)*", objectives, re.MULTILINE)
    assert 3 <= len(items) <= 5, f"there are {len(items)} objectives, lines that begin with '- '"
    numbers = {exercise.number for exercise in public(name).exercises}
    left_out = numbers - set(re.findall(r"\d+\.\d+", objectives))
    assert not left_out, f"no objective names the exercises {sorted(left_out)}"
    if name[:2] != "00":
        assert all(re.search(r"\d+\.\d+", item) for item in items), "each objective names its exercise"


@each_lesson
def test_rubric_3_a_length_that_fits_into_its_time(name):
    notebook = solved(name)
    stated = re.search(r"\*\*Time:\*\* (\d+)", notebook.cells[0].source)
    least, most = (91, 225) if name[:2] in LONG else (45, 90)
    assert stated and least <= int(stated[1]) <= most, (
        f"the first cell says no **Time:** of {least} to {most} minutes"
    )
    assert 20 <= len(notebook.cells) <= 70, f"it has {len(notebook.cells)} cells"
    without = re.compile(r"<details>.*?</details>|^\*\*Next\*\*[^\n]*", re.DOTALL | re.MULTILINE)
    read_by_all = without.sub("", prose(notebook))
    assert 900 <= len(read_by_all.split()) <= 3000, f"it has {len(read_by_all.split())} words"


@each_lesson
def test_rubric_4_words_come_before_every_exercise_and_imports_are_public_folded_and_announced(name):
    cells = solved(name).cells
    for ordinal, _ in lesson_text.code_cells(solved(name), "exercise"):
        assert cells[ordinal - 1].cell_type == "markdown", (
            f"there is no text before cell {ordinal + 1}, an exercise"
        )
    last = max(ordinal for ordinal, _ in lesson_text.code_cells(solved(name)))
    texts = (each for each in cells[:last] if each.cell_type == "markdown")
    open_words = (re.sub(r"<details>.*?</details>", "", each.source, flags=re.DOTALL) for each in texts)
    assert max(len(each.split()) for each in open_words) <= 300, "a text before code has at most 300 words"
    for _, cell in lesson_text.code_cells(solved(name)):
        for node in ast.walk(ast.parse(lesson_text.python(cell))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("nao_course"):
                parts = [*node.module.split("."), *(alias.name for alias in node.names)]
                private = [part for part in parts if part == "instructor" or part.startswith("_")]
                assert not private, f"students have no {node.module}: {private}"
    ((_, cell),) = lesson_text.code_cells(solved(name), "setup")
    assert cell.source.startswith("# Set-up: "), "this is the only line of the set-up that JupyterLab shows"
    imports = [each for each in ast.parse(cell.source).body if isinstance(each, ast.Import | ast.ImportFrom)]
    imported = {alias.asname or alias.name for node in imports for alias in node.names}
    exercises = (each for _, each in lesson_text.code_cells(solved(name), "exercise"))
    taken = imported & {"*", *map(lesson_text.exercise_name, exercises)}
    assert not taken, f"the set-up imports what the student writes: {taken}"


@each_lesson
def test_rubric_5_three_to_nine_exercises_say_what_they_want_and_no_docstring_is_cut_off_by_its_cell(name):
    cells = lesson_text.code_cells(solved(name), "exercise")
    assert len(cells) == 1 if name[:2] == "00" else 3 <= len(cells) <= 9, f"there are {len(cells)} exercises"
    for _, cell in cells:
        tree = ast.parse(lesson_text.python(cell))
        wanted = lesson_text.exercise_name(cell)
        definition = next(each for each in tree.body if getattr(each, "name", "") == wanted)
        docstring = ast.get_docstring(definition) or ""
        assert "Example" in docstring and "eturn" in docstring, f"{wanted}: what is returned, and an Example"
        if isinstance(definition, ast.FunctionDef):
            arguments = [*definition.args.args, *definition.args.kwonlyargs]
            assert definition.returns and all(each.annotation for each in arguments), f"{wanted}: types"
            assert len(lesson_text.solution_lines(cell)) <= 15, f"{wanted}: more than 15 lines"
    for _, cell in lesson_text.code_cells(solved(name)):
        lines = cell.source.splitlines()
        for node in ast.walk(ast.parse(lesson_text.python(cell))):
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and ast.get_docstring(node):
                docstring = node.body[0]
                longest = max(lines[docstring.lineno - 1 : docstring.end_lineno], key=len)
                assert len(longest) <= 79, f"a cell would cut this line off: {longest}"


@each_lesson
def test_rubric_6_difficulty_never_falls_and_the_text_says_it(name):
    numbers = {exercise.name: exercise.number for exercise in public(name).exercises}
    exercises = COURSE.plan(name).exercises
    stars = {each.name: each.stars for each in exercises}
    assert [*stars.values()] == sorted(stars.values()), f"difficulty falls: {stars}"
    words = {1: "one star", 2: "two stars", 3: "three stars"}
    titles = headings(prose(solved(name)))
    for exercise in exercises:
        wanted = rf"Exercise {re.escape(numbers[exercise.name])} \(.*{words[exercise.stars]}\)"
        assert re.search(wanted, "\n".join(titles)), f"no heading is {wanted} for {exercise.name}: {titles}"


@each_lesson
def test_rubric_7_a_check_stands_directly_after_its_exercise(name):
    for cell, after in pairwise(cell for _, cell in lesson_text.code_cells(solved(name))):
        if lesson_text.role(cell) == "exercise":
            wanted, found = lesson_text.exercise_name(cell), lesson_text.exercise_name(after)
            assert (lesson_text.role(after), found) == ("check", wanted), f"the check of {wanted} follows it"


@cache
def asserted_equations():
    """Numbers of equations that some test says it asserts."""
    sources = "".join(each.read_text(encoding="utf-8") for each in (PROJECT / "tests").rglob("test_*.py"))
    return set(re.findall(r"eq-[\w-]+", "".join(re.findall(r"pytest\.mark\.asserts\(([^)]*)\)", sources))))


@each_lesson
def test_rubric_10_equations_have_numbers_of_their_own_and_each_is_asserted_by_a_test(name):
    numbers = re.findall(r"\\tag\{([\w.]+)\}", prose(solved(name)))
    assert len(set(numbers)) == len(numbers), f"two equations have one number: {numbers}"
    missing = {"eq-" + number.replace(".", "-") for number in numbers} - asserted_equations()
    assert not missing, (
        f'no test has @pytest.mark.asserts("{min(missing)}"); see tests/lessons/test_{name}.py'
    )


@each_lesson
def test_rubric_12_a_panel_or_question_leaves_words_where_no_widget_lives(name):
    shown = [
        output.data
        for _, cell in lesson_text.code_cells(executed(name))
        for output in cell.outputs
        if output.output_type in ("display_data", "execute_result")
    ]
    assert all(data.get("text/plain", "").strip() for data in shown), "an output has no text"
    panels = [cell for _, cell in lesson_text.code_cells(solved(name)) if ends_with_a_panel(cell)]
    assert panels, "no cell ends with a panel, whose name ends with Panel, Dial, _panel or _dial"


def ends_with_a_panel(cell):
    """Return whether a cell's last line shows a panel: a class, or a function such as mask_panel, or its result."""
    *before, last = ast.parse(lesson_text.python(cell)).body
    assigned = [each for each in before if isinstance(each, ast.Assign)]
    values = {getattr(target, "id", ""): each.value for each in assigned for target in each.targets}
    shown = last.value if isinstance(last, ast.Expr) else None
    shown = values.get(shown.id) if isinstance(shown, ast.Name) else shown
    made = getattr(shown, "func", None)
    return bool(re.search(r"(Panel|Dial|_panel|_dial)$", getattr(made, "id", getattr(made, "attr", ""))))


def test_a_panel_may_be_a_class_or_a_function_whose_result_a_cell_shows():
    panels = "FunctionPanel('a')", "mask_panel(scene)", "panel = panels.mask_panel(scene)\npanel"
    others = "panel = mask_panel(scene)", "mask_panel(scene)\nscene", "draw_panels(scene)", "scene"
    for source in (*panels, *others):
        assert ends_with_a_panel(nbformat.v4.new_code_cell(source)) == (source in panels)


@each_lesson
def test_rubric_11_a_prediction_is_written_before_it_is_run_and_questions_answer_every_choice(name):
    sources = [cell.source for cell in solved(name).cells]
    predicted = [n for n, source in enumerate(sources) if re.search(r"^(\w+ = )?prediction\(", source)]
    assert predicted, "there is no prediction(...)"
    assert "**Predict" in sources[predicted[0] - 1], "the text before the first prediction says **Predict"
    asked = {
        each.name: list(each.choices.values())
        for each in public(name).questions
        if f'check.question("{each.name}")' in sources
    }
    assert len(asked) == len(public(name).questions), f"of the declared questions, it asks only {[*asked]}"
    for number, cell in enumerate(re.split(r"^\*\*Think\.\*\*", "\n".join(sources), flags=re.MULTILINE)[1:]):
        asked[f"think {number}"] = re.findall(r"</summary>\n+(.+?)\n*</details>", cell, re.DOTALL)
    assert len(asked) >= 2, f"it asks {len(asked)} questions"
    for question, replies in asked.items():
        distinct = {each for each in replies if each.strip()}
        assert 3 <= len(distinct) == len(replies), (
            f"{question}: three choices or more, each with a reply of its own"
        )


@each_lesson
def test_rubric_13_every_picture_and_figure_has_words_for_who_cannot_see_it(name):
    text = prose(solved(name))
    assert not re.findall(r"!\[\s*\]\(", text), "a picture has no description: ![](...)"
    silent = [tag for tag in re.findall(r"<img[^>]*>", text) if not re.search(r'alt="[^"]+"', tag)]
    assert not silent, f"a picture has no description: {silent}"
    for _, cell in lesson_text.code_cells(executed(name)):
        shown = [output.get("data", {}) for output in cell.outputs]
        of_pyplot = [data for data in shown if "image/png" in data]
        assert not of_pyplot, (
            "make figures with matplotlib.figure.Figure and return a Drawing: docs/write_a_lesson.md"
        )
        tags = re.findall(r"<img[^>]*>", "".join(str(data.get("text/html", "")) for data in shown))
        described = [bool(re.search(r'alt="[^"]{10,}"', tag)) for tag in tags]
        assert all(described), f"a figure has no description of 10 letters or more: {cell.source}"


@each_lesson
def test_rubric_15_it_ends_with_what_is_built_what_is_missing_and_references(name):
    titles = [title.lstrip("# ") for title in headings(prose(solved(name)))]
    wanted = "the last headings are What you have ..., and References"
    assert titles[-2].startswith("What you have") and titles[-1] == "References", f"{wanted}: {titles[-2:]}"
    references = re.findall(r"^- ", prose(solved(name)).split("## References")[1], re.MULTILINE)
    assert len(references) >= 3, f"there are {len(references)} references"


@each_lesson
def test_rubric_19_it_opens_with_the_picture_that_the_students_code_draws_at_its_end(name):
    notebook = executed(name)
    payoffs = lesson_text.code_cells(notebook, "payoff")
    if not payoffs and "3" in waived(name):
        pytest.skip("this short lesson opens with no figure")
    assert payoffs, "no cell has :role: payoff; a lesson whose plan waives rule 3 needs none"
    ((place, cell),) = payoffs
    shown = "".join(str(output.get("data", {}).get("text/html", "")) for output in cell.outputs)
    drawn = re.findall(r'src="data:image/(\w+);base64,([^"]+)"', shown)
    assert len(drawn) == 1, f"the payoff cell shows {len(drawn)} pictures, not one"
    ((kind, data),) = drawn
    image = f"images/{name[:2]}_payoff.{kind}"
    for folder in ("solutions", "notebooks"):
        assert (PROJECT / folder / image).read_bytes() == base64.b64decode(data), "run `make build`"
    opening = "\n\n".join(cell.source for cell in notebook.cells[:2]).split("## What you will")[0]
    alt = re.findall(rf"!\[([^\]]+)\]\({re.escape(image)}\)", opening)
    assert len(alt) == 1 and len(alt[0]) >= 40, (
        f"it opens with ![a description of 40 letters]({image}): {alt}"
    )
    last = max(ordinal for ordinal, _ in lesson_text.code_cells(notebook, "check"))
    assert place > last, "the payoff is drawn after the last check"
    names = {each.id for each in ast.walk(ast.parse(cell.source)) if isinstance(each, ast.Name)}
    assert names & {each.name for each in COURSE.plan(name).exercises}, "it needs the student's functions"


def calls(cell, function):
    """Calls of a function in a cell, by its name or as a method of that name."""
    return [
        node
        for node in ast.walk(ast.parse(lesson_text.python(cell)))
        if isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) == function
    ]


def is_last_line(cell, call):
    """Whether a cell shows what a call gives: the call, or the name that it was given, is the last line."""
    *_, last = ast.parse(lesson_text.python(cell)).body
    return isinstance(last, ast.Expr) and last.end_lineno >= call.end_lineno


@each_lesson
def test_rubric_21_a_lesson_with_a_challenge_opens_it_behind_its_exercises(name):
    if not (PROJECT / "nao_course" / "lessons" / name[3:] / "challenge.py").is_file():
        pytest.skip("this lesson has no challenge yet")
    code = lesson_text.code_cells(solved(name))
    opened = [(place, cell) for place, cell in code if calls(cell, "challenge")]
    assert any(calls(cell, "enter") for _, cell in opened), "no cell says challenge(...).enter(...)"
    shown = [is_last_line(cell, calls(cell, "challenge")[0]) for _, cell in opened]
    assert all(shown), "challenge(...) is the last line of its cell"
    checks = [place for place, cell in code if lesson_text.role(cell) == "check"]
    assert min(place for place, _ in opened) > max(checks), "the challenge follows the last check"


@each_lesson
def test_rubric_22_a_lesson_with_my_nao_ends_by_driving_it(name):
    code = lesson_text.code_cells(solved(name))
    driven = [(place, cell) for place, cell in code if calls(cell, "my_nao")]
    if not driven:
        pytest.skip("this lesson has no robot of the student's own yet")
    place, cell = driven[-1]
    last = max(place for place, cell in code if lesson_text.role(cell) == "check")
    assert place > last, "the last my_nao() follows the last check"
    assert is_last_line(cell, calls(cell, "my_nao")[0]), "my_nao() is the last line of its cell"


@each_lesson
def test_rubric_23_only_cells_that_merely_show_something_are_folded_and_answers_that_can_be_found_out(name):
    for notebook in (student_copy(name), executed(name)):
        for _, cell in lesson_text.code_cells(notebook):
            hidden = cell.metadata.get("jupyter", {}).get("source_hidden", False)
            assert hidden is (lesson_text.role(cell) in ("setup", "display")), cell.source
    for cell in solved(name).cells:
        if re.search(r"things to (try|find)", cell.source, re.IGNORECASE):
            task, _, answer = cell.source.partition("<details>")
            assert "1." in task and "1." in answer, (
                f"a numbered task, and its answers in <details>: {cell.source}"
            )
        assert cell.source.count("<details>") == cell.source.count("</details>"), cell.source


@each_lesson
def test_rubric_24_a_prediction_says_what_it_can_be_and_is_laid_beside_what_came_out(name):
    assert "____" not in prose(solved(name)), "a prediction has a field to write into"
    code = [cell for _, cell in lesson_text.code_cells(solved(name))]
    for number, cell in enumerate(code):
        for call in calls(cell, "prediction"):
            assigned = re.match(r"(\w+) = prediction\(", cell.source)
            given = {each.arg for each in call.keywords}
            assert given & {"unit", "choices", "low", "high"}, f"{cell.source}: what can the prediction be?"
            beside = f"{assigned[1]}.beside("
            later = [each for each in code[number + 1 :] if beside in each.source]
            assert later, f"{assigned[1]} is never resolved"
            shown = [is_last_line(each, calls(each, "beside")[0]) for each in later]
            assert all(shown), f"{beside}...) is the last line of its cell"
