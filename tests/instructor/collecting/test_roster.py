"""Who is who: a number, an address or a login decides, a name only if it is the only one, and nothing is guessed."""

import pytest

from nao_course.instructor.collecting.roster import Person, Roster, Student
from nao_course.instructor.collecting.sheets import read_sheet
from tests.handed_in import put

ADA = Student(
    "Ada Lovelace", "Ada Lovelace", "ada@uni.example", "ada", aliases={"moodle 12": "01"}, listed=True
)
JANS = [Student(f"Jan_{number}", "Jan", aliases={f"moodle {number}": "01"}) for number in (1, 2)]


def sheet_of(folder, text):
    """Return the path of a sheet with a text."""
    return put(folder, "sheet.csv", content=text.encode()) / "sheet.csv"


def moodle(name, number, lesson="02"):
    return Person(f"{name}_{number}", "Moodle", str(number), name, lessons=frozenset([lesson]))


@pytest.mark.parametrize(
    "person",
    [
        moodle("A. King", 12, "01"),
        moodle("Ada Lovelace", 99),
        moodle("ada  LOVELACE", 99),
        Person("ada", "nbgrader", login="ada"),
        Person("ada", name="ada"),
        Person("Ada@uni.example", name="Ada@uni.example"),
        Person("ADA LOVELACE", "Teams", name="ADA LOVELACE"),
        Person("Ada (ada@uni.example)", "Gradescope", name="Ada", email="Ada@uni.example"),
        Person("lovelaceada_7", "Canvas", "7", "lovelaceada"),
        Person("Ada Lovelace_12", name="Ada Lovelace_12"),
    ],
    ids=lambda person: person.identity,
)
def test_a_number_an_address_a_login_or_the_only_name_decides(person):
    found = Roster([ADA]).recognise([person])
    assert found.students == {person.identity: "Ada Lovelace"} and not found.new
    learned = found.learned["Ada Lovelace"]
    assert Roster([learned]).recognise([person]).by_name == ()  # from now on it is certain
    assert learned.email == "ada@uni.example" and learned.aliases["moodle 12"] == "01"


@pytest.mark.parametrize(
    ("students", "people"),
    [
        (JANS, [moodle("Jan", 9)]),
        (JANS[:1], [moodle("Jan", 8), moodle("Jan", 9)]),
        (JANS[:1], [moodle("Jan", 9, "01")]),
        ([Student("Jan", "Jan", "jan@a")], [Person("Jan (jan@b)", "Gradescope", name="Jan", email="jan@b")]),
        (
            [Student("Jan K", "Jan", aliases={"brightspace 5": ""})],
            [Person("Jan", "Brightspace", "6", "Jan")],
        ),
        ([ADA], [moodle("Zoe", 5)]),
        ([ADA], [Person("adal", "GitHub Classroom", login="adal")]),
    ],
)
def test_whoever_may_be_several_students_is_asked_about_with_the_command_that_answers(students, people):
    found = Roster(students).recognise(people)
    assert set(found.asked) == {each.identity for each in people} and not found.students
    assert all("nao-course students GRADES --same" in line for line in found.asked.values())


def test_a_new_name_is_a_new_student_and_moodles_number_belongs_to_no_name():
    people = [moodle("Zoe", 5), moodle("Jan", 8), moodle("Jan", 9), moodle("Participant", 7)]
    first = Roster().recognise(people)
    assert list(first.students.values()) == ["Jan_8", "Jan_9", "Participant_7", "Zoe"] and not first.new
    later = Roster(first.learned.values()).recognise([moodle("Kim", 1, "03"), moodle("Participant", 2, "03")])
    assert later.new == ("Kim", "Participant_2") and not later.asked


CANVAS = """Student,ID,SIS User ID,SIS Login ID,Section,Lesson 01 (1)
    Points Possible,,,,,13
"Lovelace, Ada",7,s1,ada@uni.example,A,
"Student, Test",9,,x,A,
"""
MOODLE = """Identifier,Full name,Email address,Status,Last modified (submission),Last modified (grade),Grade
Participant 12,Ada Lovelace,ada@uni.example,x,"Friday, 20 November 2026, 9:32 PM",-,
Participant 13,Ben,ben@uni.example,x,-,"Friday, 20 November 2026, 9:32 PM",
"""


def test_the_platforms_sheets_are_read(tmp_path):
    canvas = read_sheet(sheet_of(tmp_path, CANVAS))
    assert [(each.name, each.login, each.section, dict(each.aliases)) for each in canvas.rows] == [
        ("Ada Lovelace", "ada@uni.example", "A", {"canvas 7": "", "s1": ""})
    ]
    sheet = read_sheet(sheet_of(tmp_path, MOODLE), "01")
    assert [(each.name, each.email, dict(each.aliases)) for each in sheet.rows] == [
        ("Ada Lovelace", "ada@uni.example", {"moodle 12": "01"}),
        ("Ben", "ben@uni.example", {"moodle 13": "01"}),
    ]
    assert sheet.times == {"moodle 12": "2026-11-20 21:32"}
    german = MOODLE.replace("Full name", "Vollständiger Name").replace("Identifier", "ID")
    german = german.replace("Last modified (submission)", "Zuletzt geändert (Abgabe)")
    german = german.replace("Last modified (grade)", "Zuletzt geändert (Bewertung)")
    assert read_sheet(sheet_of(tmp_path, german), "01") == sheet


def test_an_alias_that_several_rows_have_is_nobodys(tmp_path):
    rows = read_sheet(sheet_of(tmp_path, "name,student id,aliases\nAda,n/a,\nBen,n/a,b\n")).rows
    assert [[*each.aliases] for each in rows] == [[], ["b"]]


OTHERS = {
    "own": ("Name;Login;Aliases;handed in\nAda Lovelace;ada;adal; 2026-11-20 21:32\n", "", ["adal"]),
    "Brightspace": (
        "OrgDefinedId,Username,Last Name,First Name,Email\n#7,#ada,Lovelace,Ada,ada@uni.example\n",
        "ada@uni.example",
        ["7"],
    ),
    "Blackboard": (
        '"Last Name","First Name","Username","Student ID"\n"Lovelace","Ada","ada","7"\n',
        "",
        ["7"],
    ),
    "Gradescope": ("Name,Login,SID,Email\nAda Lovelace,ada,7,ada@uni.example\n", "ada@uni.example", ["7"]),
    "GitHub": (
        "identifier,github_username,github_id,name,login\nada@uni.example,adal,9,Ada Lovelace,ada\n",
        "ada@uni.example",
        ["adal"],
    ),
    "with numbers": ('id,name,login,email\n7,"Lovelace, Ada",ada,ada@uni.example\n', "ada@uni.example", []),
}


@pytest.mark.parametrize("name", OTHERS)
def test_other_class_lists_are_read(tmp_path, name):
    text, email, aliases = OTHERS[name]
    (row,) = read_sheet(sheet_of(tmp_path, text)).rows
    assert (row.name, row.login, row.email, list(row.aliases)) == ("Ada Lovelace", "ada", email, aliases)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a,b\n1,2\n", "is not Moodle's grading worksheet"),
        (MOODLE + MOODLE.splitlines()[1], "both have the number '12'"),
        ("name,name\na,b\n", "there twice"),
        ("name,email\nAda,a@x\nBen,b@x\nEve,A@x\n", "rows 2 and 4: both have the email 'A@x'"),
        ("", "is not Moodle's"),
    ],
)
def test_what_is_no_sheet_is_refused(tmp_path, text, said):
    with pytest.raises(ValueError, match=said):
        read_sheet(sheet_of(tmp_path, text))


def test_the_sheets_of_two_assignments_join_what_was_two_students(tmp_path):
    """Join the students of an earlier version, in which every number of Moodle was a student."""
    two = [Student(f"Ada Lovelace_{n}", "Ada Lovelace", aliases={f"moodle {n}": ""}) for n in (12, 99)]
    first, renamed, _ = Roster(two).with_sheet(read_sheet(sheet_of(tmp_path, MOODLE), "01").rows)
    assert not renamed and set(first.students) == {"Ada Lovelace_12", "Ada Lovelace_99", "Ben"}
    second = MOODLE.replace("Participant 12", "Participant 99").replace("Participant 13", "Participant 98")
    joined, renamed, _ = first.with_sheet(read_sheet(sheet_of(tmp_path, second), "02").rows)
    assert renamed == {"Ada Lovelace_99": "Ada Lovelace_12"} and set(joined.students) == {
        "Ada Lovelace_12",
        "Ben",
    }
    assert joined.students["Ada Lovelace_12"].aliases == {"moodle 12": "01", "moodle 99": "02"}
    assert joined.with_sheet(read_sheet(sheet_of(tmp_path, second), "02").rows)[0].students == joined.students


def test_after_blind_marking_the_sheet_says_who_a_participant_was(tmp_path):
    blind = Roster(Roster().recognise([moodle("Participant", 12, "01")]).learned.values())
    nameless = MOODLE.replace("Full name", "x").replace("Email address", "y")
    assert set(blind.with_sheet(read_sheet(sheet_of(tmp_path, nameless)).rows)[0].students) == {
        "Participant_12"
    }
    for roster in (blind, Roster([*blind.students.values(), Student("Ada Lovelace", "Ada Lovelace")])):
        found, renamed, _ = roster.with_sheet(read_sheet(sheet_of(tmp_path, MOODLE), "01").rows)
        assert renamed == {"Participant_12": "Ada Lovelace"} and set(found.students) == {
            "Ada Lovelace",
            "Ben",
        }


def test_a_row_that_belongs_to_two_students_of_different_names_is_refused(tmp_path):
    roster = Roster([ADA, Student("Eve", "Eve", aliases={"moodle 55": ""})])
    text = MOODLE.replace("Participant 12", "Participant 55")
    with pytest.raises(ValueError, match="'Eve' and 'Ada Lovelace' are one student"):
        roster.with_sheet(read_sheet(sheet_of(tmp_path, text)).rows)


def test_two_rows_of_one_name_need_something_that_distinguishes_them(tmp_path):
    with pytest.raises(ValueError, match="two students 'Jan'"):
        Roster().with_sheet(read_sheet(sheet_of(tmp_path, "name,login\nJan,\nJan,\n")).rows)
    found = Roster().with_sheet(read_sheet(sheet_of(tmp_path, "name,login\nJan,j1\nJan,j2\n")).rows)[0]
    assert set(found.students) == {"Jan (j1)", "Jan (j2)"}


def test_a_number_behind_another_name_is_no_platforms(tmp_path):
    found = Roster([Student("Ada", "Ada", aliases={"moodle 12": ""})]).recognise(
        [Person("team_12", name="team_12")]
    )
    assert found.students == {"team_12": "team_12"}


def test_a_word_means_a_student_only_if_it_means_one():
    roster = Roster([ADA, *JANS])
    for word in ("Ada Lovelace", "ada", "ADA@uni.example", "moodle 12", "Ada Lovelace_12"):
        assert roster.meant(word) == "Ada Lovelace"
    assert roster.meant("Jan_1") == "Jan_1" and roster.meant("Jan") is None and roster.meant("") is None
