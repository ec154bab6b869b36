"""A student is one student in all assignments, on every platform, and the commands say who is who."""

import csv
import io
import re
from concurrent.futures import Future
from contextlib import contextmanager
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from nao_course import cli
from nao_course.instructor.autograding.batch import grade_all
from nao_course.instructor.collecting.files import read
from nao_course.instructor.collecting.roster import Roster, Student
from nao_course.instructor.commands import grading, students
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import SubmissionResult
from tests.handed_in import answered, packed
from tests.pages import answer, exercise

LESSONS = {"01": "01_hsl_filtering", "02": "02_goal_posts", "04": "04_homography"}
DUE = {"01": "2026-11-20", "02": "2026-11-27", "04": "2026-12-04"}
FIRST = ["Ada", "Ben", "Cleo", "Dan", "Eva", "Finn", "Gil", "Hana", "Ida", "Jan"]
NAMES = [f"{first} {last}" for last in ("Kowalski", "Novák") for first in FIRST[:-1]]
NAMES += ["Jan Kowalski", "Jan Kowalski"]  # two students of one name
LOGINS = [f"u{number:02}" for number in range(20)]


class Grader:
    """A grader that gives a point for each answer, and remembers whose earlier notebooks it was given.

    Each notebook has an answer in words, which says how many others there are.
    """

    def __init__(self):
        self.earlier = {}

    def submit(self, submission, assignment):
        files = read(submission)
        self.earlier[submission.student, submission.lesson] = [each.file for each in submission.earlier]
        answers, future = files.notebook.count(b"return"), Future()
        future.set_result(
            SubmissionResult(
                submission.student,
                submission.lesson,
                "graded",
                file=submission.file,
                submission=files.hash,
                assignment=assignment.hash,
                exercises=(exercise(points=8.0, earned=float(answers)),),
                written=(answer(text=f"{submission.student} has {answers}."),),
                handed_in=submission.handed_in,
                late=submission.late,
            )
        )
        return future

    @property
    def most(self):
        return 8

    def grade(self, submissions, journal, feedback, tell):
        assignment = SimpleNamespace(hash="a")
        return grade_all(submissions, lambda _: assignment, journal, workers=self, tell=tell)


@pytest.fixture
def grader(tmp_path, monkeypatch, secret):
    """Make a course of three lessons in the working folder, each of which uses the earlier ones; return its grader."""
    (tmp_path / "course" / "solutions").mkdir(parents=True)
    deadlines = "".join(f"{number} = {day}T23:59:00+01:00\n" for number, day in DUE.items())
    extension = "".join(
        f'[extensions."{name}@uni.example"]\n01 = 2026-11-23T23:59:00+01:00\n'
        for name in (LOGINS[3], "nobody")
    )
    (tmp_path / "course" / "course.toml").write_text(
        f'title = "Toy"\nversion = "1"\n[deadlines]\n{deadlines}[late]\nper_day = 0.1\n{extension}'
    )
    for lesson in LESSONS.values():
        (tmp_path / "course" / "solutions" / f"{lesson}.md").touch()
    monkeypatch.chdir(tmp_path / "course")
    monkeypatch.setattr(grading, "refuse_edited_lessons", lambda *_: None)
    monkeypatch.setattr(
        grading, "lessons_used", lambda _, lesson: [each for each in LESSONS.values() if each < lesson]
    )
    made = Grader()

    @contextmanager
    def session(*_):
        yield made

    monkeypatch.setattr(grading, "open_session", session)
    return made


def run(*words, status=0):
    done = CliRunner().invoke(cli.app, [str(word) for word in words])
    assert done.exit_code == status, done.output
    return done.output


def table_of(grades):
    run("export", grades, "--format", "csv")
    with (grades / "exports" / "grades.csv").open(encoding="utf-8-sig", newline="") as file:
        return {row["student"]: row for row in csv.DictReader(file)}


def day(number, late):
    """Return the day of a submission that is `late` by some days, as numbers."""
    year, month, date = map(int, DUE[number].split("-"))
    return year, month, date + late


def moodle(number, who, attempt, late, lesson):
    """Return Moodle's name of the last attempt, with the number in this assignment; no other is in the zip."""
    if attempt == 1:
        return None
    group = "Group A-" if who == 5 and number == "02" else ""
    return f"{group}{NAMES[who]}_{int(number)}300{who:02}_assignsubmission_file_/{lesson}.ipynb"


def canvas(number, who, attempt, late, lesson):
    last_first = "".join(filter(str.isalnum, "".join(reversed(NAMES[who].split())).lower()))
    mark, again = "_LATE" if late else "", f"-{attempt - 1}" if attempt > 1 else ""
    return f"{last_first}{mark}_{5000 + who}_{int(number)}{who}{attempt}_{lesson}{again}.ipynb"


def blackboard(number, who, attempt, late, lesson):
    year, month, date = day(number, late)
    time = f"{year}-{month:02}-{date:02}-{18 + attempt}-15-00"
    return f"Lab {number}_{LOGINS[who]}_attempt_{time}_{lesson}.ipynb"


def csv_of(*rows):
    text = io.StringIO()
    csv.writer(text).writerows(rows)
    return text.getvalue()


def moodles_sheet(number, late_by):
    rows = [
        ["Identifier", "Full name", "Email address", "Last modified (submission)", "Grade", "Maximum Grade"]
    ]
    for who, late in late_by.items():
        year, month, date = day(number, late)
        time = f"Friday, {date} {'November' if month == 11 else 'December'} {year}, 8:15 PM"
        mail = f"{LOGINS[who]}@uni.example"
        rows.append([f"Participant {int(number)}300{who:02}", NAMES[who], mail, time, "", "10.00"])
    return csv_of(*rows)


def canvass_sheet(number, late_by):
    rows = [["Student", "ID", "SIS User ID", "SIS Login ID", "Section", f"Lesson {number} (1)"]]
    rows.append(["    Points Possible", "", "", "", "", "10.00"])
    for who, name in enumerate(NAMES):
        first, last = name.split()
        rows.append([f"{last}, {first}", 5000 + who, f"s{who}", f"{LOGINS[who]}@uni.example", "A", ""])
    return csv_of(*rows)


def class_list(number, late_by):
    rows = [["name", "email", "login"]]
    return csv_of(
        *rows, *([name, f"{each}@uni.example", each] for name, each in zip(NAMES, LOGINS, strict=True))
    )


PLATFORMS = {
    "Moodle": (moodle, moodles_sheet),
    "Canvas": (canvas, canvass_sheet),
    "Blackboard": (blackboard, class_list),
}


def download(folder, platform, number, late_by, resubmitted=()):
    """Write the download of an assignment, in which every third student has an older attempt with fewer answers.

    Students who `resubmitted` have a newer one with more answers, and ask to check an exercise again.
    """
    name_of, sheet_of = PLATFORMS[platform]
    lesson, files = LESSONS[number], {}
    for who, late in late_by.items():
        for attempt in (*[1] * (who % 3 == 0), 2, *[3] * (who in resubmitted)):
            if name := name_of(number, who, attempt, late, lesson):
                files[name] = answered(who % 4 + attempt)
                if attempt == 3:
                    files[re.sub(rf"{lesson}.*", "regrade_request.txt", name)] = b"rgb_to_hsl: It is right."
                if platform == "Blackboard":
                    files[name.removesuffix(f"_{lesson}.ipynb") + ".txt"] = b"Name: (x)"
    sheet = folder / f"{platform} {number}.csv"
    sheet.write_text(sheet_of(number, late_by), encoding="utf-8")
    return packed(folder / f"{platform} {number}.zip", files), sheet


def mark_answers(grades, number):
    """Divide a lesson's answers between two markers, who mark what is open with a point; return how many they were."""
    said = run("marks", grades, "--split", "2", "--lesson", number)
    assert said.count("wrote") == 2
    for by, part in (("ana", "1of2"), ("ben", "2of2")):
        for sheet in sorted((grades / "marking").glob(f"{number}_*.{part}.csv")):
            with sheet.open(encoding="utf-8-sig", newline="") as file:
                rows = list(csv.DictReader(file))
            filled = [row | {"points": row["points"] or "1"} for row in rows]
            sheet.write_text(csv_of(list(rows[0]), *(row.values() for row in filled)), encoding="utf-8")
            said += run("marks", grades, sheet, "--by", by)
    return sum(map(int, re.findall(r"(\d+) of them new or changed", said)))


RESUBMITTED = (6, 7)  # after their answers in words were marked


@pytest.mark.parametrize("platform", PLATFORMS)
def test_in_a_term_of_three_assignments_nobody_is_two_people_and_decisions_stay_where_they_belong(
    grader, tmp_path, platform
):
    """Run a term with two markers.

    Dan has an extension by the e-mail address, and so has a name that is not in the class. Dan and Eva are two days
    late in 01, Finn leaves out 02, Gil and Hana hand in 01 again with a request, Ben and Hana have points by hand, and
    at the end Cleo's data are deleted.
    """
    grades = tmp_path / "grades"
    for number in LESSONS:
        late_by = {who: 2 if number == "01" and who in (3, 4) else 0 for who in range(20)}
        if number == "02":
            del late_by[5]
        path, sheet = download(tmp_path, platform, number, late_by)
        words = ["grade", path, "--out", grades, "--sheet", sheet, "--lesson", number]
        if number == "01":
            said = run(*words, "--dry-run")
            assert f"{platform}: 20 students, " in said and "Nothing was graded" in said
            assert not grades.exists()
        said = run(*words)
        assert "WHO IS THIS" not in said and "NOT GRADED" not in said
        assert ("NO TIME" in said) == (platform == "Canvas")
        assert said.partition("for names that no student has:")[2].split()[0] == "nobody@uni.example"
        assert mark_answers(grades, number) == len(late_by)
        if number == "01":
            for who in (1, 7):
                person = f"{LOGINS[who]}@uni.example"
                run("regrade", grades, "--student", person, "--set", "rgb_to_hsl=8", "--reason", "Shown.")
            path, sheet = download(tmp_path, platform, "01", late_by, RESUBMITTED)
            said = run("grade", path, "--out", grades, "--sheet", sheet, "--lesson", number)
            assert "2 marked answers have changed" in said
            assert f"{NAMES[7]}, {LESSONS['01']}, rgb_to_hsl: 8 by hand for an earlier answer" in said
            assert f"{NAMES[1]}, {LESSONS['01']}" not in said
            asked = [line for line in said.splitlines() if line.endswith("rgb_to_hsl: It is right.")]
            assert [line.split(",")[0].strip() for line in asked] == [NAMES[who] for who in RESUBMITTED]
            assert mark_answers(grades, number) == 2
        if platform != "Blackboard":
            more = ["--sheet", sheet, *(["--column", "Lesson"] if platform == "Canvas" else [])]
            said = run("export", grades, "--format", platform.lower(), "--lesson", number, *more)
            assert f"{len(late_by)} rows filled in" in said and "in no row" not in said
    table = table_of(grades)
    assert len(table) == 20
    jans = [f"Jan Kowalski ({LOGINS[who]}@uni.example)" for who in (18, 19)]
    students = [*NAMES[:18], *jans]
    assert set(table) == set(students)
    for who, student in enumerate(students):
        points, lessons = who % 4 + 2, 2 if who == 5 else 3
        first = (8 if who == 1 else points + (who in RESUBMITTED)) + 1  # with the mark
        deducted = 0.2 * first if who == 4 and platform != "Canvas" else 0.0
        total = first + (lessons - 1) * (points + 1) - deducted
        assert float(table[student]["total"]) == pytest.approx(total), student
        late = [table[student][f"{lesson} late"] for lesson in LESSONS.values()]
        assert late == ["yes" if who == 4 else "", "", ""]
        assert len(grader.earlier[student, LESSONS["04"]]) == (1 if who == 5 else 2)
    said = run("students", grades)
    assert "20 students" in said and f"{LOGINS[7]}@uni.example" in said
    del table[NAMES[2]]
    assert "is forgotten" in run("students", grades, "--forget", f"{LOGINS[2]}@uni.example")
    assert table_of(grades) == table


def test_without_a_sheet_equal_names_are_one_student_and_two_of_one_name_are_asked_about(grader, tmp_path):
    grades = tmp_path / "grades"
    for number in LESSONS:
        path, _ = download(tmp_path, "Moodle", number, dict.fromkeys(range(6), 0))
        said = run("grade", path, "--out", grades, "--lesson", number)
        assert ("Ada Kowalski_230000 is Ada Kowalski: the only student of this name" in said) == (
            number == "02"
        )
        assert f"{LESSONS[number]} has a deadline, and 6 of 6 submissions have no time: Ada" in said
    assert set(table_of(grades)) == set(NAMES[:6])
    both, _ = download(tmp_path, "Moodle", "01", dict.fromkeys((0, 18, 19), 0))
    assert "Jan Kowalski_130018" in run("grade", both, "--out", grades, "--lesson", "01")
    again, _ = download(tmp_path, "Moodle", "02", dict.fromkeys((0, 18, 19), 0))
    said = run("grade", again, "--out", grades, "--lesson", "02", status=1)
    asked = said.partition("WHO IS THIS")[2]
    assert asked.count("it may be Jan Kowalski_130018 or Jan Kowalski_130019") == 2
    for who in (18, 19):
        assert f"--same 'Jan Kowalski_2300{who}' STUDENT" in asked
        run("students", grades, "--same", f"Jan Kowalski_2300{who}", f"Jan Kowalski_1300{who}")
    run("grade", again, "--out", grades, "--lesson", "02")
    students = {*NAMES[:6], "Jan Kowalski_130018", "Jan Kowalski_130019"}
    assert set(table_of(grades)) == students
    # The two answers were wrong, so they are exchanged.
    said = run("students", grades, "--same", "Jan Kowalski_230018", "Jan Kowalski_130019")
    assert "Jan Kowalski_230018 is Jan Kowalski_130019 and not Jan Kowalski_130018" in said
    run("students", grades, "--same", "Jan Kowalski_230019", "Jan Kowalski_130018")
    run("grade", again, "--out", grades, "--lesson", "02")
    assert {student: row["total"] for student, row in table_of(grades).items() if "Jan" in student} == {
        "Jan Kowalski_130018": "9",
        "Jan Kowalski_130019": "9",
    }


def hand_in(folder, files, name="in"):
    """Pack notebooks with this many answers by their paths."""
    return packed(folder / f"{name}.zip", {path: answered(answers) for path, answers in files.items()})


def sheet_of(folder, text):
    path = folder / "class.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_most_trusted_time_counts_and_only_for_the_submission_that_it_is_of(grader, tmp_path):
    grades, lesson = tmp_path / "grades", LESSONS["01"]
    sheet = sheet_of(tmp_path, "name,login,handed in\nAda,ada,2026-11-21 10:00\n")
    path = hand_in(tmp_path, {f"Lab_ada_attempt_2026-11-20-10-00-00_{lesson}.ipynb": 1})
    assert "1 from the platform's names and files" in run("grade", path, "--out", grades)
    assert table_of(grades)["ada"][f"{lesson} handed in"] == "2026-11-20 10:00"
    assert "1 from the platform's sheet" in run("grade", path, "--out", grades, "--sheet", sheet)
    for again in (["grade", path, "--out", grades], ["regrade", grades, "--student", "ADA"]):
        run(*again)
        row = table_of(grades)["ada"]
        assert (row[f"{lesson} handed in"], row[f"{lesson} late"]) == ("2026-11-21 10:00", "yes")
    page = (grades / "feedback" / "ada" / f"{lesson}.html").read_text("utf-8")
    assert "You handed in at 2026-11-21 10:00+01:00" in page
    resubmitted = hand_in(tmp_path, {f"Lab_ada_attempt_2026-11-22-10-00-00_{lesson}.ipynb": 2}, "again")
    run("grade", resubmitted, "--out", grades)
    assert table_of(grades)["ada"][f"{lesson} handed in"] == "2026-11-22 10:00"
    said = run("students", grades, "--sheet", sheet, "--lesson", "01")
    assert f"{lesson}: 1 time new or changed" in said
    assert "name it with --lesson" in run("students", grades, "--sheet", sheet)


def test_a_platforms_folder_of_any_name_replaces_results_once_a_sheet_says_who_is_in_the_class(
    grader, tmp_path
):
    grades, sheet = tmp_path / "grades", sheet_of(tmp_path, "name,login\nAda Lovelace,ada\nBen Marsh,ben\n")
    people = ("Lovelace, Ada(ada)", "Marsh, Ben(ben)")
    names = [f"Robots/{name}/Submission attachment(s)/{LESSONS['01']}.ipynb" for name in people]
    run("grade", hand_in(tmp_path, dict.fromkeys(names, 1)), "--out", grades)
    again = hand_in(tmp_path, dict.fromkeys(names, 2), "again")
    assert "there is a result already" in run("grade", again, "--out", grades, status=1)
    run("grade", again, "--out", grades, "--sheet", sheet)
    assert [row["total"] for row in table_of(grades).values()] == ["2", "2"]
    forged = {names[0].replace("Robots", "Ben Marsh"): 3}  # a folder of a student's name stays that student's
    run("grade", hand_in(tmp_path, forged, "forged"), "--out", grades)
    totals = {student: row["total"] for student, row in table_of(grades).items()}
    assert totals == {"Lovelace, Ada(ada)": "2", "Marsh, Ben(ben)": "3"}


def test_whoever_is_in_no_sheet_is_asked_about_and_graded_after_the_answer(grader, tmp_path):
    grades, sheet = tmp_path / "grades", sheet_of(tmp_path, "name,login\nAda Lovelace,ada\n")
    names = [
        f"lesson-01-submissions/lesson-01-{login}/{LESSONS['01']}.ipynb" for login in ("ada", "lovely", "zoe")
    ]
    words = ("grade", hand_in(tmp_path, dict(zip(names, (1, 2, 3), strict=True))), "--out", grades)
    for dry in (["--dry-run"], []):
        said = run(*words, "--sheet", sheet, *dry, status=1)
        assert "lovely (GitHub Classroom): no sheet has this student" in said.partition("WHO IS THIS")[2]
    run("students", grades, "--same", "lovely", "ada")
    run("students", grades, "--new", "zoe")
    run(*words)
    assert {student: row["total"] for student, row in table_of(grades).items()} == {
        "Ada Lovelace": "2",
        "zoe": "3",
    }
    assert "there is no student 'nobody'" in run("students", grades, "--same", "x", "nobody", status=1)


def test_two_students_who_are_one_are_joined_renamed_and_forgotten(grader, tmp_path):
    grades = tmp_path / "grades"
    for number, name in (("01", "ada"), ("02", "Ada L")):
        run("grade", hand_in(tmp_path, {f"{name}/{LESSONS[number]}.ipynb": 2}, number), "--out", grades)
    run("students", grades, "--same", "ada", "Ada L")
    assert not (grades / "feedback" / "ada").exists()
    assert [(row["student"], row["total"]) for row in table_of(grades).values()] == [("Ada L", "4")]
    assert "Ada L is Ada Lovelace." in run("students", grades, "--rename", "ada", "Ada Lovelace")
    run("grade", hand_in(tmp_path, {f"ada/{LESSONS['02']}.ipynb": 3}, "02"), "--out", grades)
    assert [(row["student"], row["total"]) for row in table_of(grades).values()] == [("Ada Lovelace", "5")]
    run("grade", hand_in(tmp_path, {f"ben/{LESSONS['01']}.ipynb": 1}, "ben"), "--out", grades)
    assert "there is a student 'ben' already" in run("students", grades, "--rename", "ada", "ben", status=1)
    table_of(grades)
    said = run("students", grades, "--forget", "ada")
    assert (
        f"still names the student, write it again or delete it: {grades / 'exports' / 'grades.csv'}" in said
    )
    assert f"may contain work of the student: {tmp_path / '01.zip'}" in said
    assert set(table_of(grades)) == {"ben"} and "Ada" not in (grades / "students.csv").read_text("utf-8")
    assert not list((grades / "feedback").iterdir())


def test_the_sheets_of_a_term_mend_a_journal_in_which_every_moodle_number_was_a_student(grader, tmp_path):
    grades, everybody = tmp_path / "grades", dict.fromkeys(range(4), 0)
    sheets = {}
    for number in ("01", "02"):
        path, sheets[number] = download(tmp_path, "Moodle", number, everybody)
        run("grade", path, "--out", grades, "--lesson", number)
        with Journal(grades) as journal:
            for who in everybody:
                journal.rename(NAMES[who], f"{NAMES[who]}_{int(number)}300{who:02}")
    assert len(table_of(grades)) == 4
    for number, sheet in sheets.items():
        run("students", grades, "--sheet", sheet, "--lesson", number)
    table = table_of(grades)
    assert len(table) == 4 and all(row[f"{LESSONS['02']} handed in"] for row in table.values())


def test_the_names_in_personal_copies_are_found_by_any_name_and_in_the_sheet_that_release_was_given(tmp_path):
    known = Roster([Student("Ada", "Ada Kowalski", "ada@uni.example", aliases={"moodle 130000": "01"})])
    moodles = sheet_of(tmp_path, moodles_sheet("01", {0: 0}))
    assert students.names_in_copies(moodles, known) == {"Ada": "Ada Kowalski"}
    copies = {"Ada": "Ada Kowalski_130000"}
    own = sheet_of(tmp_path, "student,world\nada@uni.example,Ada Kowalski_130000\n")
    assert students.names_in_copies(own, known) == copies
    with pytest.raises(ValueError, match="world"):
        students.names_in_copies(sheet_of(tmp_path, "student,wolrd\nada,x\n"), known)
