"""A lesson's facts are read from its student copy; README, guide for instructors and syllabus state the same."""

import json
import re
from dataclasses import replace

import pytest

from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.plans import load_plan
from tests.paths import PROJECT
from website import lessons
from website.guide import guide_with_lessons, readme_with_lessons, syllabus_with_lessons
from website.lessons import read_lesson


def notebook(*cells):
    parts = [{"source": [text], "cell_type": kind, "metadata": data} for kind, text, data in cells]
    return json.dumps({"cells": parts})


def test_a_lessons_facts_are_read(tmp_path):
    head = "# Posts\n\nYou find\n*them*.\n\n![a post](images/02_payoff.png)\n\n"
    head += "**Before you start** you need `np.where`, and a pen. "
    head += "**Time:** 90 minutes up to the middle, and 40 minutes for the rest."
    path = tmp_path / "02_posts.ipynb"
    cells = [("markdown", head, {}), ("code", 'find = earlier("01:color_labels")', {})]
    cells += [("code", "check", {"nbgrader": {"points": 3}}), ("markdown", "A", {"nbgrader": {"points": 2}})]
    path.write_text(notebook(*cells))
    lesson = read_lesson(path)
    assert (lesson.number, lesson.title, lesson.goal) == ("02", "Posts", "You find *them*.")
    assert (lesson.picture, lesson.minutes, lesson.later) == ("![a post](images/02_payoff.png)", 90, 40)
    assert lesson.needs == "`np.where`, and a pen"
    assert (lesson.points, lesson.written, lesson.takes) == (5, 2, ("01",))


def test_a_lesson_that_opens_with_no_figure_needs_no_card(tmp_path, monkeypatch):
    monkeypatch.setattr(lessons, "ROOT", tmp_path)
    (tmp_path / "solutions").mkdir()
    (tmp_path / "solutions" / "lessons.toml").write_text('["02"]\ndoes = "x"\ncan = "y"\nleft_out = "z"\n')
    path = tmp_path / "02_posts.ipynb"
    head = "# Posts\n\nYou find them.\n\n**Before you start** you need a pen. **Time:** 30 minutes."
    path.write_text(notebook(("markdown", head, {})))
    assert read_lesson(path).picture == ""


def test_a_lesson_that_lacks_a_fact_says_which(tmp_path, monkeypatch):
    monkeypatch.setattr(lessons, "ROOT", tmp_path)
    (tmp_path / "solutions").mkdir()
    (tmp_path / "solutions" / "lessons.toml").write_text('["00"]\ndoes = "x"\ncard = []\ncard_shows = "y"\n')
    with pytest.raises(ValueError, match=r'lessons.toml does not say can, left_out under \["00"\]'):
        read_lesson(PROJECT / "notebooks" / "00_meet_the_nao.ipynb")
    path = tmp_path / "02_posts.ipynb"
    path.write_text(notebook(("markdown", "# Posts\n\nYou find them.", {})))
    with pytest.raises(ValueError, match=r"02_posts.ipynb does not say its needs, minutes"):
        read_lesson(path)


LESSONS = {
    lesson.number: lesson
    for path in sorted((PROJECT / "notebooks").glob("[0-9][0-9]_*.ipynb"))
    if path.stem not in load_course(PROJECT).drafts()
    for lesson in [read_lesson(path)]
}
README = (PROJECT / "README.md").read_text(encoding="utf-8")
GUIDE = (PROJECT / "docs" / "teach_the_course.md").read_text(encoding="utf-8")
SYLLABUS = (PROJECT / "docs" / "syllabus.md").read_text(encoding="utf-8")
RUN = "run `.venv/bin/python -m website.guide`"


def rows_under(head, page=GUIDE):
    """Return the cells of the table with this head."""
    table = page.split(head, 1)[1].split("\n\n", 1)[0]
    return [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in table.splitlines()[2:]]


def numbers(cell):
    return tuple(re.findall(r"\d\d", cell))


def test_the_tables_are_made_from_the_lessons_and_the_command_keeps_the_rest():
    changed = re.sub(r"^(\| \d+ \| \d\d [^|]*\|) \d+ \| .*$", r"\1 1 | - | 2 (3) | 99 |", GUIDE, flags=re.M)
    changed = re.sub(r"^(\| [a-z ]+ \| \d\d, [^|]*\|) \d+ \| [^|]* \|", r"\1 7 | 98 |", changed, flags=re.M)
    assert changed.count("| 2 (3) | 99 |") == len(LESSONS) and changed.count("| 7 | 98 |") == 3
    assert guide_with_lessons(changed, LESSONS.values()) == GUIDE, RUN
    readme = re.sub(r"^\| \[\d\d .* \|$\n", "", README, flags=re.M)
    assert "hsl_filtering.ipynb" not in readme
    assert readme_with_lessons(readme, LESSONS.values()) == README, RUN
    syllabus = re.sub(r"^(\| [^|]+ \| \d\d) .*$", r"\1 x | y |", SYLLABUS, flags=re.M)
    assert syllabus.count(" x | y |") == len(LESSONS)
    assert syllabus_with_lessons(syllabus, LESSONS.values()) == SYLLABUS, RUN


def test_the_syllabus_says_what_students_can_do_and_its_weeks_are_those_of_the_plan():
    assert "TODO" not in SYLLABUS, f"say `can` in solutions/lessons.toml, and {RUN}"
    weeks = {row[1][:2]: row[0].split(",")[0] for row in rows_under("| week | lesson |", SYLLABUS)}
    plan = rows_under("| week | in the room | at home |")
    planned = {number: week for week, room, *_ in plan for number in numbers(room)[:1]}
    assert {number: week for number, week in weeks.items() if week.isdigit()} == planned


def test_a_new_lesson_gets_a_row_and_a_removed_lesson_loses_its_row():
    first, second, *_ = LESSONS.values()
    about = second.about | {"can": "do more"}
    new = replace(second, name="40_more", title="More", points=2.5, written=0, takes=(), about=about)
    lines = guide_with_lessons(GUIDE, [first, new]).splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("| week | lesson |"))
    assert lines[start + 2].startswith("| 1 | 00 Meet the NAO | 65 |")
    said = f"{second.needs} | {second.about['left_out']}"
    assert lines[start + 3] == f"| 2 | 40 More | {new.minutes} | - | 2.5 | - | {said} |"
    assert lines[start + 4] == ""
    rows = rows_under("| week | lesson |", syllabus_with_lessons(SYLLABUS, [first, new]))
    assert [row[:2] for row in rows] == [["1", "00 Meet the NAO"], ["optional", "40 More"]]
    assert rows[1][2] == "do more"


def test_a_shorter_course_states_its_minutes_and_the_lessons_whose_functions_it_lacks():
    rows = rows_under("| course | lessons |")
    assert len(rows) == 3
    for name, given, minutes, lent in rows:
        lessons = [LESSONS[number] for number in numbers(given)]
        missing = {number for each in lessons for number in each.takes} - {*numbers(given)}
        said = sum(each.minutes for each in lessons), missing
        assert (int(minutes), {*numbers(lent)}) == said, name


def test_what_goes_wrong_in_class_is_a_mistake_that_a_check_of_that_lesson_names():
    rows = rows_under("| lesson, exercise |")
    declarations = PROJECT / "solutions" / "exercises"
    plans = {number: load_plan(declarations / f"{each.name}.py") for number, each in LESSONS.items()}
    without = {number for number, plan in plans.items() if "8" in plan.waived}
    assert {*LESSONS} - without <= {row[0][:2] for row in rows} <= {*LESSONS}
    for where, mistake, *_ in rows:
        number, exercise = re.fullmatch(r"(\d\d) `(\w+)`", where).groups()
        name = LESSONS[number].name
        notebook = (PROJECT / "notebooks" / f"{name}.ipynb").read_text(encoding="utf-8")
        assert f'check(\\"{exercise}\\"' in notebook, where
        assert mistake in [each.name for each in plans[number][exercise].mistakes], where
