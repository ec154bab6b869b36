"""Marks go out as sheets and come back, whatever a spreadsheet does to them on the way; all of them or none."""

import codecs
import csv
import io
import unicodedata
from dataclasses import replace
from functools import partial

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nao_course._internal.tables import TableError, read_table
from nao_course.instructor.autograding.secret import student_code
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.scores import all_scores
from nao_course.instructor.reports.marking_sheets import HEADER, MORE, MarksError, read_marks, write_sheets
from tests.pages import HOSTILE, RUBRIC, Page, answer, exercise, mark, result, words

code = partial(student_code, b"0123456789abcdef")
LESSON, QUESTION = "01_hsl_filtering", "why_hsl"
STUDENTS = ("ada", "=1+1", 'Łucja; "the" Nguyễn, \'', "007")


@pytest.fixture
def journal(tmp_path):
    with Journal(tmp_path / "grades") as opened:
        for name in STUDENTS:
            opened.keep(result(name, exercise(), answer(text=f"=I am {name}\nand, that; is all")))
        yield opened


@pytest.fixture
def sheet(journal, tmp_path):
    (written,) = write_sheets(journal, tmp_path / "marking", code)
    return written.table


def rows_of(path):
    return list(csv.reader(io.StringIO(path.read_bytes().decode("utf-8-sig"), newline="")))


def save(path, rows, separator=",", encoding="utf-8-sig", ending="\r\n", quoting=csv.QUOTE_MINIMAL):
    text = io.StringIO()
    csv.writer(text, delimiter=separator, lineterminator=ending, quoting=quoting).writerows(rows)
    path.write_bytes(text.getvalue().encode(encoding))


def filled(path, points, comment="Good."):
    """The sheet's rows with points in each."""
    header, *rows = rows_of(path)
    at, beside = header.index("points"), header.index("comment")
    for row, each in zip(rows, points, strict=True):
        row[at], row[beside] = each, comment
    return [header, *rows]


def given_marks(journal):
    return {each.student: (each.points, each.comment) for each in journal.marks()}


def test_a_sheet_has_a_row_for_each_answer_and_no_formula_and_the_page_has_the_rubric(journal, tmp_path):
    (written,) = write_sheets(journal, tmp_path, code)
    header, *rows = rows_of(written.table)
    assert tuple(header) == (*HEADER, *MORE) and len(rows) == len(STUDENTS) == written.answers == written.open
    cells = [cell for row in rows for cell in row]
    assert any("1+1" in cell for cell in cells)
    assert not [cell for cell in cells if cell.lstrip()[:1] in tuple("=+-@\t\r") and cell]
    page = Page(written.page.read_text(encoding="utf-8"))
    assert page.offences() == [] and page.text.index(RUBRIC) < page.text.index("I am ada")


def row_of(path, student):
    return next(row for row in read_table(path, HEADER, MORE) if row["student"] == student)


def test_a_mark_stands_in_the_next_sheet_and_beside_an_answer_that_has_changed(journal, sheet, tmp_path):
    rows = filled(sheet, ["", "", "1.5", ""], "")
    rows[3][rows[0].index("comment")] = "-0.5: the sun"
    save(sheet, rows)
    read_marks(journal, sheet, code)
    (written,) = write_sheets(journal, tmp_path / "marking", code)
    row = row_of(written.table, "ada")
    assert (row["points"], row["comment"], written.open) == ("1.5", "-0.5: the sun", len(STUDENTS) - 1)
    assert read_marks(journal, written.table, code).changed == ()
    journal.keep(replace(result("ada", exercise(), answer(text="A new answer.")), submission="2"))
    (written,) = write_sheets(journal, tmp_path / "marking", code)
    row = row_of(written.table, "ada")
    assert (row["answer"], row["points"], written.open) == ("A new answer.", "", len(STUDENTS))
    assert [row[name] for name in MORE[1:4]] == ["=I am ada\nand, that; is all", "1.5", "-0.5: the sun"]
    page = Page(written.page.read_text("utf-8")).text
    assert "A new answer." in page and "to mark again (1.5 for an earlier" in page and "I am ada" in page
    save(written.table, filled(written.table, ["", "", "1", ""], ""))
    assert len(read_marks(journal, written.table, code).open) == len(STUDENTS) - 1
    assert given_marks(journal)["ada"] == (1, "")


def test_a_mark_belongs_to_the_answer_in_the_sheet_even_if_it_has_changed_meanwhile(journal, sheet):
    rows = filled(sheet, ["", "", "1.5", ""], "")
    save(sheet, [row[: len(HEADER)] for row in rows])  # a sheet of an earlier version
    assert len(read_marks(journal, sheet, code).open) == len(STUDENTS) - 1
    journal.keep(replace(result("ada", exercise(), answer(text="A new answer.")), submission="2"))
    save(sheet, rows)
    taken = read_marks(journal, sheet, code)
    assert taken.read == 1 and len(taken.open) == len(STUDENTS)
    rows[3][rows[0].index("answer id")] = "another"
    save(sheet, rows)
    with pytest.raises(MarksError, match="row 4: the answer id 'another'"):
        read_marks(journal, sheet, code)


@pytest.mark.parametrize(("points", "comment"), [("1", ""), ("", "think again"), ("?", "")])
def test_a_sheet_with_what_nobody_read_is_not_written_over(journal, sheet, tmp_path, points, comment):
    rows = filled(sheet, ["", points, "", ""], "")
    rows[2][rows[0].index("comment")] = comment
    save(sheet, rows)
    before = sheet.read_bytes()
    with pytest.raises(MarksError, match="row 3, has a mark that was not read in"):
        write_sheets(journal, tmp_path / "marking", code)
    assert sheet.read_bytes() == before
    if points == "1":
        read_marks(journal, sheet, code)
        assert write_sheets(journal, tmp_path / "marking", code)[0].open == len(STUDENTS) - 1
    sheet.write_bytes(b"my notes")
    with pytest.raises(MarksError, match="It may hold marks"):
        write_sheets(journal, tmp_path / "marking", code)
    assert sheet.read_bytes() == b"my notes"


def test_an_empty_journal_and_one_without_questions_have_no_sheets(tmp_path):
    with Journal(tmp_path) as empty:
        assert write_sheets(empty, tmp_path / "marking", code) == []
        empty.keep(result("ada", exercise()))
        assert write_sheets(empty, tmp_path / "marking", code) == []


@pytest.mark.parametrize("text", HOSTILE)
def test_the_page_keeps_its_elements_whatever_was_written(tmp_path, text):
    def page(said, folder):
        text = f"x{said.encode('utf-8', 'replace').decode()}"
        with Journal(folder) as kept:
            kept.keep(result("ada", answer(text=text, question=text, rubric=text, number=text)))
            kept.mark([mark(1, text, text=text)])
            return Page(write_sheets(kept, folder, code)[0].page.read_text(encoding="utf-8"))

    found = page(text, tmp_path / "hostile")
    assert found.elements == page("fine", tmp_path / "fine").elements and found.offences() == []


def test_an_empty_answer_has_no_row_and_counts_nowhere_until_a_person_gives_it_points(journal, tmp_path):
    def students(written):
        return {row["student"]: row["points"] for row in read_table(written.table, HEADER, MORE)}

    journal.keep(result("ben", exercise(), answer(text=" \n")))
    (written,) = write_sheets(journal, tmp_path / "marking", code)
    page = Page(written.page.read_text(encoding="utf-8")).text
    assert "ben" not in students(written) and (written.answers, written.open) == (4, 4)
    assert "4 answers, 4 to mark" in page and page.index("No answer: 0 points") < page.index("ben")
    save(written.table, filled(written.table, ["2"] * 4))
    assert read_marks(journal, written.table, code).open == () and "ben" not in given_marks(journal)
    journal.mark([mark(1, "shown in the lab", text=" \n", student="ben")])
    (written,) = write_sheets(journal, tmp_path / "marking", code)
    assert students(written)["ben"] == "1" and (written.answers, written.open) == (5, 0)
    assert "5 answers, 0 to mark" in Page(written.page.read_text(encoding="utf-8")).text


def test_asterisks_in_a_question_and_a_rubric_are_emphasis(tmp_path):
    with Journal(tmp_path) as kept:
        kept.keep(result("ada", answer(question="This *or* that?", rubric="a *or* b, `x*y*z`, 2 * 3 * 4")))
        text = write_sheets(kept, tmp_path, code)[0].page.read_text(encoding="utf-8")
    assert "This <em>or</em> that?" in text and "a <em>or</em> b, <code>x*y*z</code>, 2 * 3 * 4" in text


def test_an_anonymous_sheet_and_page_name_nobody_and_come_back_to_the_students(journal, tmp_path):
    for name in STUDENTS:
        journal.keep(result(name, exercise(), answer(text=f"Because of hue {STUDENTS.index(name)}.")))
    journal.keep(result("Benjamin", exercise(), answer(text="")))
    (written,) = write_sheets(journal, tmp_path / "marking", code, anonymous=True)
    both = written.table.read_bytes().decode() + written.page.read_text(encoding="utf-8")
    assert not [name for name in ("Łucja", "Benjamin", "007", "1+1") if name in both]
    names = [row["student"] for row in read_table(written.table, HEADER, MORE)]
    assert names == sorted(code(each) for each in STUDENTS) and code("Benjamin") in both
    order = sorted(STUDENTS, key=lambda each: code(each))
    save(written.table, filled(written.table, ["0", "0.5", "1", ""], ""))
    with pytest.raises(MarksError, match="row 2, has a mark that was not read in"):
        write_sheets(journal, tmp_path / "marking", code)
    with pytest.raises(MarksError, match="no student 'student-.*' was graded .* with this secret: read an"):
        read_marks(journal, written.table, partial(student_code, b"another secret"))
    assert journal.marks() == []
    taken = read_marks(journal, written.table, code)
    assert given_marks(journal) == dict(zip(order[:3], [(0.0, ""), (0.5, ""), (1.0, "")], strict=True))
    assert taken.open == ((code(order[3]), QUESTION),)


VARIANTS = [
    {"separator": ";", "quoting": csv.QUOTE_ALL},
    {"separator": "\t", "encoding": "utf-16"},
    {"encoding": "utf-16-le", "separator": ";"},
    {"encoding": "utf-16-be"},
    {"encoding": "utf-8", "ending": "\r"},
]


def test_excels_line_and_empty_moved_and_sorted_columns_and_rows_do_no_harm(journal, sheet):
    header, *rows = filled(sheet, ["0", "1", "2", "0.5"])
    turned = [[*reversed(row), "", ""] for row in [header, *reversed(rows)]]
    turned.insert(2, [""] * 9)
    save(sheet, turned, separator=";")
    assert read_marks(journal, sheet, code).read == 4

    rows[3][header.index("points")] = "3"
    save(sheet, [header, *rows], separator=";")
    sheet.write_bytes(codecs.BOM_UTF8 + b"sep=;\r\n" + sheet.read_bytes()[3:])
    with pytest.raises(MarksError, match="row 5: 3 points; the question is worth 2"):
        read_marks(journal, sheet, code)


def test_a_number_that_lost_its_zeros_is_found_again_where_only_one_can_be_meant(journal, sheet):
    rows = [[cell if cell != "007" else "7" for cell in row] for row in filled(sheet, ["1"] * 4)]
    save(sheet, rows)
    assert read_marks(journal, sheet, code).read == 4 and "007" in given_marks(journal)
    journal.keep(result("07", answer()))
    with pytest.raises(MarksError, match="no student '7'"):
        read_marks(journal, sheet, code)


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_sheet_comes_back_from_any_spreadsheet_and_is_read_twice(journal, sheet, variant):
    marked, empty = filled(sheet, ["0,5", " 2 ", "0", "1.25"]), filled(sheet, [""] * 4, "")
    save(sheet, marked, **variant)
    taken = read_marks(journal, sheet, code)
    assert (taken.read, len(taken.changed), taken.open) == (4, 4, ())
    wanted = {name: (each, "Good.") for name, each in zip(sorted(STUDENTS), (0.5, 2, 0, 1.25), strict=True)}
    assert given_marks(journal) == wanted
    again = read_marks(journal, sheet, code)
    assert (again.read, again.changed, given_marks(journal)) == (4, (), wanted)
    save(sheet, empty)
    assert read_marks(journal, sheet, code).read == 0 and given_marks(journal) == wanted


@pytest.mark.parametrize("points", ["-1", "2.01", "1e0", "nan", "1,5,0", "٢"])
def test_points_that_cannot_be_are_refused_with_their_rows_and_nothing_is_read(journal, sheet, points):
    save(sheet, filled(sheet, [points, "1", "9", "1"]))
    said = f"'{points}'; they must be a number from 0 to 2" if points != "2.01" else "the question is worth 2"
    with pytest.raises(MarksError, match=f"(?s)nothing was read in.*row 2: .*{said}.*row 4: 9 points"):
        read_marks(journal, sheet, code)
    assert journal.marks() == []


def changed(rows, what, to):
    return [[to if cell == what else cell for cell in row] for row in rows]


def test_a_row_that_belongs_to_nobody_and_a_changed_header_are_refused(journal, sheet):
    rows = filled(sheet, ["1"] * 4)
    for what, to, said in (
        ("ada", "eve", "row [2-5]: no student 'eve' was graded"),
        ("ada", "?da", "save as CSV UTF-8"),
        (QUESTION, "how", "row 2: there is no question 'how'.*there are 01_hsl_filtering why_hsl"),
        (LESSON, "02_posts", "row 2: there is no question 'why_hsl' in lesson '02_posts'"),
        ("points", "score", "row 1: the columns are .student.*they should be"),
        ("comment", "points", "row 1: the columns are"),
    ):
        save(sheet, changed(rows, what, to))
        with pytest.raises((MarksError, TableError), match=f"(?s){said}"):
            read_marks(journal, sheet, code)
        assert journal.marks() == []


def test_own_columns_and_doubled_rows_are_read_and_what_is_ambiguous_is_refused(journal, sheet):
    header, *rows = filled(sheet, ["1"] * 4)
    save(sheet, [[*header, "mine"], *([*row, "later"] for row in rows)])
    assert read_marks(journal, sheet, code).read == 4
    save(sheet, [header, *rows, rows[0]])
    assert read_marks(journal, sheet, code).read == 4
    for table, said in (
        ([[*header, "points"], *rows], "the columns 'points' are there twice"),
        ([header, [*rows[0], "1.5"], *rows[1:]], "row 2: '1.5' stands in a column without a name"),
        ([header, *rows, *changed([rows[0]], "1", "2")], "row 6: .* has another mark in row 2"),
    ):
        save(sheet, table)
        with pytest.raises((MarksError, TableError), match=said):
            read_marks(journal, sheet, code)


def test_a_file_that_is_no_sheet_is_refused(journal, tmp_path):
    path = tmp_path / "x.csv"
    for content, said in (
        (b"\xff\xfe", "is empty"),
        (b"student\r\nada", "row 1: the columns are 'student'"),
        (b"\x81\x8d\x8f", "Save it as UTF-8"),
        (",".join(HEADER).encode() + b'\r\n"ada,1', "not a CSV table"),
    ):
        path.write_bytes(content)
        with pytest.raises(TableError, match=said):
            read_marks(journal, path, code)
    with pytest.raises(MarksError, match="there is no"):
        read_marks(journal, tmp_path / "missing.csv", code)


@settings(max_examples=30, deadline=None)
@given(words(), words(), st.integers(0, 8).map(lambda n: n / 4))
def test_any_name_answer_and_comment_survives_the_round(tmp_path_factory, name, text, points):
    folder = tmp_path_factory.mktemp("round")
    name = unicodedata.normalize("NFC", name.encode("utf-8", "replace").decode()) or "x"  # as it is collected
    with Journal(folder) as kept:
        text = text.encode("utf-8", "replace").decode()
        kept.keep(result(name, answer(text=text)))
        kept.mark([mark(points, "-1, \"=2\"; 'so'", text=text, student=name)])
        (written,) = write_sheets(kept, folder, code)
        taken = read_marks(kept, written.table, code)
        assert (taken.read, taken.changed) == (1, ())


# --- several markers ---


def marked(path, points):
    """Fill in a sheet's points by student, and return the rows that were there."""
    header, *rows = rows_of(path)
    for row in rows:
        row[header.index("points")] = points.get(row[0].removeprefix("'"), row[header.index("points")])
    save(path, [header, *rows])
    return rows


def test_parts_for_several_markers_have_each_answer_once_and_replace_the_whole_sheet(
    journal, sheet, tmp_path
):
    journal.keep(result("Benjamin", exercise(), answer(text="")))
    parts = write_sheets(journal, tmp_path / "marking", code, parts=3)
    assert [each.table.name for each in parts] == [f"{LESSON}_{QUESTION}.{k}of3.csv" for k in (1, 2, 3)]
    assert sorted(row["student"] for each in parts for row in read_table(each.table, HEADER, MORE)) == sorted(
        STUDENTS
    )
    assert sum("Benjamin" in each.page.read_text("utf-8") for each in parts) == 1
    assert not sheet.exists() and not sheet.with_suffix(".html").exists()
    marked(parts[0].table, {"ada": "1", "=1+1": "1", "007": "1"})
    with pytest.raises(MarksError, match="1of3.csv, row 2, has a mark that was not read in"):
        write_sheets(journal, tmp_path / "marking", code)
    taken = read_marks(journal, parts[0].table, code, "ben")
    assert {each.given_by for each in taken.changed} == {"ben"}
    (whole,) = write_sheets(journal, tmp_path / "marking", code)
    assert {each.name for each in whole.table.parent.iterdir()} == {whole.table.name, whole.page.name}


def test_a_mark_of_another_person_is_not_replaced_unless_the_sheet_shows_it(journal, sheet, tmp_path):
    old = sheet.read_bytes()
    marked(sheet, {"ada": "1.5"})
    read_marks(journal, sheet, code, "ben")
    sheet.write_bytes(old)
    marked(sheet, {"ada": "0.5", "007": "2"})
    with pytest.raises(MarksError, match="row 4: 'ada' has 1.5 by ben since this sheet was written"):
        read_marks(journal, sheet, code, "cleo")
    assert given_marks(journal) == {"ada": (1.5, "")}
    assert read_marks(journal, sheet, code, "ben").replaced == ("ada: 1.5 by ben before, now 0.5 by ben",)
    (written,) = write_sheets(journal, tmp_path / "marking", code)
    assert "0.5 of 2 by ben" in Page(written.page.read_text("utf-8")).text
    marked(written.table, {"ada": "2"})
    taken = read_marks(journal, written.table, code, "cleo")
    assert taken.replaced == ("ada: 0.5 by ben before, now 2 by cleo",)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_second_marks_count_for_nothing_and_are_compared(journal, tmp_path, order):
    first, second = write_sheets(journal, tmp_path / "marking", code, double=True)
    marked(first.table, {"ada": "2", "007": "1.5"})
    marked(second.table, {"ada": "1", "007": "1"})
    sheets = ((first, "ben"), (second, "cleo"))
    for number in order:
        taken = read_marks(journal, sheets[number][0].table, code, sheets[number][1])
        assert len(taken.open) == len(STUDENTS) - 2
    assert taken.differing == (f"ada, {QUESTION}: 2 by ben, 1 by cleo",)
    scores = {each.result.student: each for each in all_scores(journal)}
    assert (
        scores["ada"].earned == 4 and len(scores["007"].second_marks) == 1 and scores["007"].differing == []
    )
    for each in write_sheets(journal, tmp_path / "marking", code, double=True):
        assert ("cleo" in each.page.read_text("utf-8")) == (".second" in each.page.name)
    (written,) = write_sheets(journal, tmp_path / "marking", code)
    assert "ada has two marks: 2 by ben, 1 by cleo" in Page(written.page.read_text("utf-8")).text


def test_a_second_mark_is_another_persons(journal, tmp_path):
    for each in write_sheets(journal, tmp_path / "marking", code, double=True):
        marked(each.table, {"ada": "2"})
        if ".second" in each.table.name:
            with pytest.raises(MarksError, match="ben gave 'ada' the first mark, too"):
                read_marks(journal, each.table, code, "ben")
        else:
            read_marks(journal, each.table, code, "ben")


@pytest.mark.parametrize("anonymous", [False, True])
def test_the_same_words_are_marked_once_for_all_who_wrote_them(journal, tmp_path, anonymous):
    for name, text in (
        ("ada", "The  sun.\n"),
        ("007", "the sun."),
        ("Cleo", "The sun."),
        ("dan", "The moon."),
    ):
        journal.keep(replace(result(name, exercise(), answer(text=text)), submission=text))
    (written,) = write_sheets(journal, tmp_path / "marking", code, anonymous=anonymous)
    rows = read_table(written.table, HEADER, MORE)
    assert len(rows) == 4 and written.answers == written.open == 6
    named = code if anonymous else str
    (row,) = (row for row in rows if "sun" in row["answer"])
    assert {row["student"], *row["same answer"].splitlines()} == set(map(named, ("ada", "007", "Cleo")))
    assert Page(written.page.read_text("utf-8")).text.count("The same words, marked once for all:") == 1
    journal.keep(replace(result("Cleo", exercise(), answer(text="The stars.")), submission="later"))
    marked(written.table, {row["student"]: "1.5"})
    assert len(read_marks(journal, written.table, code, "ben").changed) == 3
    counting = {each.result.student: each.marks for each in all_scores(journal)}
    assert [len(counting[name]) for name in ("ada", "007", "Cleo", "dan")] == [1, 1, 0, 0]
    journal.mark([mark(0.5, student="dan", text="The moon.", given_by="cleo")])
    marked(written.table, {row["student"]: "1.5", named("dan"): "1"})
    with pytest.raises(MarksError, match=f"'{named('dan')}' has 0.5 by cleo since"):
        read_marks(journal, written.table, code, "ben")
    marked(written.table, {named("dan"): ""})
    journal.mark([mark(0.5, student="007", text="the sun.", given_by="cleo")])
    with pytest.raises(MarksError, match=f"'{named('007')}' has 0.5 by cleo since") as error:
        read_marks(journal, written.table, code, "ben")
    assert str(error.value).count("row ") == 1
    journal.mark([mark(1.5, student="007", text="the sun.", given_by="ben")])
    journal.keep(replace(result("eve", exercise(), answer(text="The sun.")), submission="later"))
    (written,) = write_sheets(journal, tmp_path / "marking", code, anonymous=anonymous)
    text = Page(written.page.read_text("utf-8")).text
    assert f"in another row: {named('eve')} (to mark)" in text and "(1.5 by ben)" in text
