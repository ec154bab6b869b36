"""A platform's own sheet comes back with points in it and nothing else changed; what does not fit is named."""

import csv
import io
import zipfile

import pytest

from nao_course._internal.tables import TableError
from nao_course.instructor.collecting.roster import Roster, Student
from nao_course.instructor.gradebook.scores import scores
from nao_course.instructor.reports.platforms import MOODLES_COLUMNS, feedback_zip, fill_sheet
from tests.pages import answer, exercise, result

MOODLE = (
    "Identifier,Full name,Email address,Status,Grade,Maximum Grade,Grade can be changed,Feedback comments\n"
    'Participant 1234567,Ada Lovelace,ada@uni.example,"Submitted, graded",,2.00,Yes,\n'
    "Participant 1234568,Žofie Nováková,zofie@uni.example,Submitted,5.00,2.00,Yes,keep this\n"
    "Participant 12345,Ben,ben@uni.example,No submission,,2.00,Yes,=1+1\n"
)
CANVAS = (
    "Student,ID,SIS User ID,SIS Login ID,Section,Lesson 01 (4711),Lesson 02 (4712),Current Score\n"
    "    Points Possible,,,,,13.00,2.00,(read only)\n"
    '"Lovelace, Ada",1234567,s001,ada,A,,3,10\n'
    '"Student, Test",99,,x,A,,,\n'
    '"Nováková, Žofie",1234568,s002,zofie,A,2,,\n'
)
MADE = scores(
    [
        result("Ada Lovelace_1234567", exercise(points=2.0, earned=1.5)),
        result("Žofie Nováková_1234568", exercise(points=2.0, earned=2.0)),
        result("Eve_777", exercise(points=2.0, earned=1.0)),
        result("without a number", exercise(points=2.0, earned=1.0)),
    ]
)


def rows(table):
    return list(csv.reader(io.StringIO(table.decode("utf-8-sig"), newline="")))


def sheet(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "theirs.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("separator", [",", ";"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_moodles_worksheet_gets_grades_and_keeps_all_else(tmp_path, encoding, separator):
    given = MOODLE if separator == "," else MOODLE.replace(",", ";").replace("d; g", "d, g")
    filled = fill_sheet("moodle", sheet(tmp_path, given, encoding), MADE)
    before, after = rows(MOODLE.encode()), rows(filled.table)
    assert [row[4] for row in after] == ["Grade", "1.5", "2", ""] and filled.filled == 2
    assert [row[:4] + row[5:] for row in after] == [row[:4] + row[5:] for row in before]
    assert filled.without_row == ("Eve_777", "without a number")
    assert filled.without_grade == ("Ben",)


def test_of_two_students_with_one_number_neither_gets_the_others_points(tmp_path):
    both = [
        *MADE,
        *scores([result("Zed_99_assignsubmission_file_x_1234567", exercise(points=2.0, earned=0.0))]),
    ]
    filled = fill_sheet("moodle", sheet(tmp_path, MOODLE), both)
    assert [row[4] for row in rows(filled.table)] == ["Grade", "", "2", ""]
    assert {"Ada Lovelace_1234567", "Zed_99_assignsubmission_file_x_1234567"} <= set(filled.without_row)


def test_canvas_gets_the_column_that_is_named(tmp_path):
    filled = fill_sheet("canvas", sheet(tmp_path, CANVAS), MADE, "lesson 02")
    after = rows(filled.table)
    assert [row[6] for row in after] == ["Lesson 02 (4712)", "2.00", "1.5", "", "2"]
    assert [row[5] for row in after] == ["Lesson 01 (4711)", "13.00", "", "", "2"]
    assert filled.without_grade == () and filled.filled == 2


@pytest.mark.parametrize(
    ("platform", "text", "column", "said"),
    [
        ("moodle", "a,b\n1,2\n", "", "'Identifier', 'Grade', 'Maximum Grade' .English.*German"),
        ("canvas", MOODLE, "Grade", "not Canvas's exported gradebook"),
        ("canvas", CANVAS, "", "--column 'Lesson 01 .4711.'"),
        ("canvas", CANVAS, "Lesson", "2 columns that begin with 'Lesson'"),
        ("canvas", CANVAS, "Essay", "no columns that begin with 'Essay'"),
        ("moodle", MOODLE + MOODLE.splitlines()[1], "", "rows 2 and 5: both have the number 1234567"),
        ("canvas", CANVAS + CANVAS.splitlines()[2], "Lesson 02", "rows 3 and 6: both have the number"),
        ("moodle", MOODLE.replace("Email address", "identifier"), "", "'identifier' are there twice"),
        ("moodle", MOODLE.replace("Email address", "Maximum Grade"), "", "'maximum grade' are there twice"),
        ("moodle", MOODLE.replace("Email address", "Grade"), "", "2 columns that begin with 'Grade'"),
        ("moodle", "", "", "is empty"),
        ("moodle", 'Identifier,Grade\n"open,1\n', "", "is not a CSV table"),
        ("moodle", "x" * 200_000, "", "is not a CSV table"),
    ],
)
def test_what_is_no_sheet_of_theirs_is_refused(tmp_path, platform, text, column, said):
    with pytest.raises(TableError, match=said):
        fill_sheet(platform, sheet(tmp_path, text), MADE, column)


def test_another_maximum_is_refused_and_both_are_named_unless_points_are_to_be_scaled(tmp_path):
    moodle, canvas = MOODLE.replace("2.00", "100.00"), (CANVAS, MADE, "Lesson 01")
    with pytest.raises(TableError, match="in Moodle is 100 points, and 01_hsl_filtering is worth 2.*--scale"):
        fill_sheet("moodle", sheet(tmp_path, moodle), MADE)
    hundred = fill_sheet("moodle", sheet(tmp_path, moodle), MADE, scale=True)
    assert [row[4] for row in rows(hundred.table)] == ["Grade", "75", "100", ""]
    with pytest.raises(TableError, match="in Canvas is 13 points, and 01_hsl_filtering is worth 2.*--scale"):
        fill_sheet("canvas", sheet(tmp_path, canvas[0]), *canvas[1:])
    thirteen = fill_sheet("canvas", sheet(tmp_path, canvas[0]), *canvas[1:], scale=True)
    assert [row[5] for row in rows(thirteen.table)] == ["Lesson 01 (4711)", "13.00", "9.75", "", "13"]
    same = fill_sheet("moodle", sheet(tmp_path, MOODLE), MADE)
    assert fill_sheet("moodle", sheet(tmp_path, MOODLE), MADE, scale=True) == same


def test_the_lessons_worth_includes_its_questions_also_where_some_submissions_have_none(tmp_path):
    graded = result("Ada_1234567", exercise(points=1.5, earned=1.5), answer(points=0.5, text=""))
    refused = result("Ben_12345", exercise("not found", points=1.5), status="refused", reason="it is empty")
    filled = fill_sheet("moodle", sheet(tmp_path, MOODLE), scores([graded, refused]))
    assert [row[4] for row in rows(filled.table)] == ["Grade", "1.5", "5.00", "0"]


@pytest.mark.parametrize(
    ("platform", "text", "said"),
    [
        ("moodle", MOODLE.replace("2.00", "-"), "'Maximum Grade' of 'Participant 1234567' should be .* '-'"),
        ("canvas", CANVAS.replace("13.00", "0"), "'Points Possible' of 'Lesson 01 .4711.' should be .* '0'"),
        ("canvas", CANVAS.replace("Points Possible", "?"), "has no row 'Points Possible'"),
    ],
)
def test_a_sheet_without_a_maximum_is_refused(tmp_path, platform, text, said):
    column = "Lesson 01" if platform == "canvas" else ""
    for scale in (False, True):
        with pytest.raises(TableError, match=said):
            fill_sheet(platform, sheet(tmp_path, text), MADE, column, scale=scale)


GERMAN = (
    "ID;Vollständiger Name;E-Mail-Adresse;Status;Bewertung;Bestwertung;Bewertung kann geändert werden\n"
    "Teilnehmer/in1234567;Ada Lovelace;ada@uni.example;Zur Bewertung abgegeben;;2,00;Ja\n"
    "Teilnehmer/in 1234568;Žofie Nováková;zofie@uni.example;Zur Bewertung abgegeben;;2,00;Ja\n"
)


def test_a_german_worksheet_gets_grades_with_decimal_commas_and_an_unknown_language_is_refused(tmp_path):
    filled = fill_sheet("moodle", sheet(tmp_path, GERMAN), MADE)
    assert [row[4] for row in rows(filled.table)] == ["Bewertung", "1,5", "2"]
    for old, new, said in (
        ("2,00", "100,00", "is 100 points"),
        ("Bestwertung", "Legmagasabb pont", "Legmagasabb pont.*'Bestwertung' .German"),
    ):
        with pytest.raises(TableError, match=said):
            fill_sheet("moodle", sheet(tmp_path, GERMAN.replace(old, new)), MADE)


@pytest.mark.parametrize("columns", MOODLES_COLUMNS.values(), ids=MOODLES_COLUMNS)
def test_a_worksheet_in_each_known_language_is_filled_in(tmp_path, columns):
    filled = fill_sheet("moodle", sheet(tmp_path, ",".join(columns) + "\nTN 1234567,,2\n"), MADE)
    assert rows(filled.table)[1] == ["TN 1234567", "1.5", "2"]


PAGES = [
    (result("Ada Lovelace_1234567", file="x/01_hsl_filtering.ipynb"), b"<p>good</p>"),
    (result("eve_123456", file="eve_LATE_123456_789_hw.zip/01_hsl_filtering.ipynb"), b"x"),
    (result("ben", file="ben/01_hsl_filtering.ipynb"), b"y"),
]


def test_feedback_has_the_names_that_a_platform_gave():
    moodle = "{}_assignsubmission_file_/feedback.html"
    names = (moodle.format("Ada Lovelace_1234567"), moodle.format("eve_123456"))
    for platform, files, without in (
        ("moodle", dict(zip(names, (b"<p>good</p>", b"x"), strict=True)), ("ben",)),
        ("canvas", {"eve_LATE_123456_789_hw.html": b"x"}, ("Ada Lovelace_1234567", "ben")),
    ):
        archive, left_out = feedback_zip(platform, PAGES)
        with zipfile.ZipFile(io.BytesIO(archive)) as made:
            assert {name: made.read(name) for name in made.namelist()} == files
        assert left_out == without and feedback_zip(platform, PAGES)[0] == archive


# --- platforms whose sheets name students by login, address or number ---

ROSTER = Roster(
    [
        Student("Ada Lovelace", "Ada Lovelace", "ada@uni.example", "ada", aliases={"s001": ""}),
        Student("Žofie Nováková_1234568", "Žofie Nováková", login="zofie"),
        Student("Eve", "Eve Adams", "eve@uni.example"),
    ]
)
GRADED = scores(
    [
        result("Ada Lovelace", exercise(points=2.0, earned=1.5)),
        result("Žofie Nováková_1234568", exercise(points=2.0, earned=2.0)),
        result("Eve", exercise(points=2.0, earned=1.0)),
    ]
)
SHEETS = {  # the sheet, the points of Ada, Žofie and Ben in it, and the header of these points
    "brightspace": (
        "OrgDefinedId,Username,Last Name,First Name,Email,Essay Points Grade <Numeric MaxPoints:5>,"
        "Lesson 01 Points Grade <Numeric MaxPoints:2 Weight:10>,End-of-Line Indicator\n"
        "#s001,#alovelace,Lovelace,A.,,,,#\n#s002,#zofie,Nováková,Žofie,,1,,#\n#s003,#ben,Bee,Ben,,,1,#\n",
        ["1.5", "2"],
        "Lesson 01",
    ),
    "blackboard": (
        '"Last Name"\t"First Name"\t"Username"\t"Student ID"\t"Lesson 01 [Total Pts: 2 Score] |4711"\n'
        '"Lovelace"\t"Ada"\t"unknown"\t"s001"\t""\n"Nováková"\t"Žofie"\t"zofie"\t""\t"In Progress"\n'
        '"Bee"\t"Ben"\t"ben"\t"s003"\t"1"\n',
        ["1.5", "2", "1"],
        "",
    ),
    "ilias": (
        "update;usr_id;login;lastname;firstname;status;mark;notice;comment;plag_flag;plag_comment\n"
        "0;12;ada;Lovelace;Ada;notgraded;;;points;;\n0;13;zofie;Nováková;Žofie;passed;1;;;;\n"
        "0;14;ben;Bee;Ben;notgraded;1;;;;\n",
        ["1.5", "2", "1"],
        "",
    ),
    "google": (
        "Last Name,First Name,Email Address,Lesson 01\n,,Date,2026-11-20\n,,Points,2\n"
        "Lovelace,Ada,ADA@uni.example,\nNováková,Žofie,other@uni.example,1\nBee,Ben,ben@uni.example,1\n",
        ["2026-11-20", "2", "1.5", "2", "1"],
        "",
    ),
}


@pytest.mark.parametrize("platform", SHEETS)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_each_platform_gets_its_sheet_back_with_the_points_and_all_else_as_it_was(
    tmp_path, platform, encoding
):
    text, points, column = SHEETS[platform]
    filled = fill_sheet(platform, sheet(tmp_path, text, encoding), GRADED, column, roster=ROSTER)
    header, *after = rows(filled.table)
    (at,) = (at for at, name in enumerate(header) if name.startswith("Lesson 01") or name == "mark")
    assert [row[at] for row in after] == points and filled.filled == 2
    assert filled.without_row == ("Eve",) and len(filled.without_grade) == 1
    before = list(
        csv.reader(io.StringIO(text), delimiter={"blackboard": "\t", "ilias": ";"}.get(platform, ","))
    )
    if platform == "brightspace":
        assert header == [before[0][at] for at in (0, 1, 6, 7)] and after[0] == [
            "#s001",
            "#alovelace",
            "1.5",
            "#",
        ]
    elif platform == "ilias":
        assert [row[0] for row in after] == ["1", "1", "0"]
        assert [row[1:6] + row[7:] for row in after] == [row[1:6] + row[7:] for row in before[1:]]
    else:
        assert [row[:at] + row[at + 1 :] for row in (header, *after)] == [
            row[:at] + row[at + 1 :] for row in before
        ]


@pytest.mark.parametrize(
    ("platform", "old", "new", "said"),
    [
        (
            "brightspace",
            "MaxPoints:2 ",
            "MaxPoints:100 ",
            "the maximum in Brightspace is 100 points.*--scale",
        ),
        ("blackboard", "Total Pts: 2 ", "Total Pts: up to 100 ", "the maximum in Blackboard is 100 points"),
        ("google", "Points,2", "Points,100", "the maximum in Google Classroom is 100 points"),
        ("google", "Lovelace,Ada,ADA", "Lovelace,Ada,eve", None),
        ("blackboard", '"unknown"\t"s001"', '"zofie"\t""', "rows 2 and 3: both have the number Žofie"),
        ("ilias", ";mark;", ";note;", "is not ILIAS's sheet of grades: it has no column for points"),
        ("blackboard", "Username", "Nickname", None),
        ("google", "Email Address", "Address", "no column with logins, e-mail addresses or numbers"),
    ],
)
def test_what_is_no_sheet_of_the_platform_or_names_a_student_twice_is_refused(
    tmp_path, platform, old, new, said
):
    text, _, column = SHEETS[platform]
    assert old in text
    path = sheet(tmp_path, text.replace(old, new))
    if said is None:  # another column, or the name, says who it is
        assert fill_sheet(platform, path, GRADED, column, roster=ROSTER).filled == 2
        return
    with pytest.raises(TableError, match=said):
        fill_sheet(platform, path, GRADED, column, roster=ROSTER)


def test_the_column_must_be_named_where_a_sheet_has_several(tmp_path):
    with pytest.raises(TableError, match="--column 'Essay Points Grade"):
        fill_sheet("brightspace", sheet(tmp_path, SHEETS["brightspace"][0]), GRADED, roster=ROSTER)
    hundred = SHEETS["brightspace"][0].replace("MaxPoints:2 ", "MaxPoints:100 ")
    filled = fill_sheet(
        "brightspace", sheet(tmp_path, hundred), GRADED, "lesson 01", roster=ROSTER, scale=True
    )
    assert [row[2] for row in rows(filled.table)][1:] == ["75", "100"]
