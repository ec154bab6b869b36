"""Each platform's names of files: one student whatever the attempt and the assignment, and no false alarms."""

from dataclasses import dataclass
from datetime import datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nao_course.exercises.running import alarm
from nao_course.instructor.collecting.files import read
from nao_course.instructor.collecting.layouts import canvas_name, handed_in
from nao_course.instructor.collecting.marks import read_marks, read_time
from nao_course.instructor.collecting.roster import Roster
from nao_course.instructor.collecting.submissions import gather
from tests.handed_in import HSL, LESSONS, answered, packed, put, who

NEXT = "02_goal_posts.ipynb"
METADATA = b"""---
submission_30000:
  :submitters:
  - :name: Ada Lovelace
    :sid: '77'
    :email: ada@uni.example
  :created_at: 2026-11-20 21:45:00.123 Z
  :results:
    :output: |-
      submission_40000:
        :submitters:
        - :name: Eve
submission_30001:
  :submitters:
  - :name: Ada Lovelace
    :email: ada@uni.example
  :created_at: 2026-11-21 08:00:00 Z
submission_30002:
  :submitters:
  - :name: Ada Lovelace
    :email: ada@uni.example
  :created_at: 2026-11-27 08:00:00 Z
"""


@dataclass(frozen=True)
class Sample:
    """Files of one student in a platform's download: the older attempt, the newer one, and the next assignment's."""

    student: str
    older: str
    newer: str
    following: str
    ignored: tuple[str, ...] = ()
    more: tuple[tuple[str, bytes], ...] = ()
    late: bool = False
    platform: str = ""


_BLACKBOARD = "Lab {}_s124_attempt_2024-10-{}-22-59-10"
_MOODLE = "Ada Lovelace_1234567_assignsubmission_file_"
_SAKAI = "Lovelace, Ada(adalovelace)"
_NBGRADER = "inbound/ada+01_hsl_filtering+2026-11-20 21:4"
OTHER = {"platform": "Files and folders"}
SAMPLES = {
    "Moodle, folders": Sample(
        "Ada Lovelace_1234567",
        f"{_MOODLE}/old {HSL}",
        f"{_MOODLE}/sub/{HSL}",
        f"{_MOODLE}/{NEXT}",
        ("Ada Lovelace_1234567_assignsubmission_onlinetext_/onlinetext.html",),
    ),
    "Moodle, no folders": Sample(
        "Ada Lovelace_1234567",
        f"{_MOODLE}a {HSL}",
        f"{_MOODLE}{HSL}",
        f"{_MOODLE}{NEXT}",
        ("Ada Lovelace_1234567_assignsubmission_onlinetext_onlinetext.html",),
    ),
    "Moodle, blind": Sample(
        "Participant_1234567",
        *(f"Participant_1234567_assignsubmission_file_/{name}" for name in (f"a {HSL}", HSL, NEXT)),
    ),
    "Moodle, groups": Sample(
        "Ada Lovelace_1234567", f"Group A-{_MOODLE}/a {HSL}", f"{_MOODLE}/{HSL}", f"Lab2-{_MOODLE}/{NEXT}"
    ),
    "Canvas": Sample(
        "lovelaceada_123456",
        f"lovelaceada_123456_789_{HSL}",
        f"lovelaceada_LATE_123456_788_{HSL[:-6]}-1.ipynb",
        f"lovelaceada_123456_800_{NEXT}",
        ("lovelaceada_123456_text.html", "bob_LATE_7_link.html"),
        late=True,
    ),
    "Canvas, anonymous": Sample(
        "anon_aB3dE",
        f"anon_aB3dE_789_{HSL}",
        f"LATE_anon_aB3dE_790_{HSL}",
        f"anon_aB3dE_800_{NEXT}",
        ("LATE_anon_aB3dE_text.html",),
        late=True,
    ),
    "Brightspace, folders": Sample(
        "Ada Lovelace",
        f"50000-600 - Ada Lovelace - Nov 20, 2026 932 PM/{HSL}",
        f"50000-600 - Ada Lovelace - Nov 21, 2026 1201 AM/{HSL}",
        f"50000-601 - Ada Lovelace - Dec 1, 2026 905 AM/{NEXT}",
        ("index.html",),
    ),
    "Brightspace, flat": Sample(
        "Ann - Marie Doe",
        f"397063-2557369 - Ann - Marie Doe - Sep 24, 2024 926 PM - {HSL}",
        f"397063-2557369 - Ann - Marie Doe - Sep 25, 2024 1149 AM - {HSL}",
        f"397063-2557370 - Ann - Marie Doe - 1 Oct, 2024 2149 - {NEXT}",
        ("index.html",),
    ),
    "Blackboard, flat": Sample(
        "s124",
        *(f"{_BLACKBOARD.format(1, day)}_{HSL}" for day in ("01", "02")),
        f"{_BLACKBOARD.format(2, '08')}_{NEXT}",
        tuple(f"{_BLACKBOARD.format(1, day)}.txt" for day in ("01", "02")),
    ),
    "Blackboard, folders": Sample(
        "s124",
        *(f"{_BLACKBOARD.format(1, day)}/{HSL}" for day in ("01", "02")),
        f"{_BLACKBOARD.format(2, '08')}/{NEXT}",
    ),
    "Sakai": Sample(
        _SAKAI,
        *(f"Lesson 01/{_SAKAI}/Submission attachment(s)/{name}" for name in (f"a {HSL}", HSL)),
        f"Lesson 02/{_SAKAI}/Submission attachment(s)/{NEXT}",
        (
            "Lesson 01/grades.csv",
            *(f"Lesson 01/{_SAKAI}/{name}" for name in ("timestamp.txt", "comments.txt")),
            f"Lesson 01/{_SAKAI}/Feedback Attachment(s)/note.pdf",
        ),
    ),
    "nbgrader, submitted": Sample(
        "ada",
        f"submitted/ada/ps1/old {HSL}",
        f"submitted/ada/ps1/{HSL}",
        f"submitted/ada/ps2/{NEXT}",
        ("submitted/ada/ps1/timestamp.txt", "submitted/ada/ps1/submission_secret.txt"),
        platform="nbgrader",
    ),
    "nbgrader, inbound": Sample(
        "ada",
        f"{_NBGRADER}5:00 UTC/{HSL}",
        f"{_NBGRADER}6:00.250000 UTC+aGVsbG8-_w==/{HSL}",
        f"inbound/ada+02_goal_posts+2026-11-27 21_45_00 UTC/{NEXT}",
        (f"{_NBGRADER}5:00 UTC/timestamp.txt",),
        platform="nbgrader",
    ),
    "Gradescope": Sample(
        "Ada Lovelace (ada@uni.example)",
        *(f"assignment_12_export/submission_3000{number}/{HSL}" for number in (0, 1)),
        f"assignment_12_export/submission_30002/{NEXT}",
        more=(("assignment_12_export/submission_metadata.yml", METADATA),),
    ),
    "Teams": Sample(
        "Ada Lovelace",
        *(f"Submitted files/Ada Lovelace/Lesson 01/Version {version}/{HSL}" for version in (9, 10)),
        f"Submitted files/Ada Lovelace/Lesson 02/Version 1/{NEXT}",
        (f"Working files/Ada Lovelace/Lesson 01/{HSL}",),
    ),
    "GitHub Classroom": Sample(
        "adalovelace",
        *(f"lesson-01-submissions/lesson-01-adalovelace/{name}" for name in (f"old {HSL}", HSL)),
        f"lesson-02-submissions/lesson-02-adalovelace/{NEXT}",
    ),
    "ILIAS": Sample(
        "Lovelace_Ada_adalovelace_1234567",
        *(f"Lovelace_Ada_adalovelace_1234567/202611{day}204500_{HSL}" for day in (20, 21)),
        f"Lovelace_Ada_adalovelace_1234567/{NEXT}",
    ),
    "Drive": Sample("Ben", f"Ben - Copy of {HSL}", f"Ben - {HSL}", f"Ben - Kopie von {NEXT}", **OTHER),
    "hub": Sample(
        "Ada_1234567",
        *(f"Ada_1234567/{name}" for name in (f"kept {HSL}", HSL, NEXT)),
        ("worlds.csv",),
        **OTHER,
    ),
    "unknown, with a date": Sample(
        "Ada Lovelace",
        *(f"Ada Lovelace_2026-11-20_214{minute}_{HSL}" for minute in (5, 6)),
        f"Ada Lovelace_2026-11-27_2146_{NEXT}",
        **OTHER,
    ),
    "unknown, with attempts": Sample(
        "Ada Lovelace",
        *(f"Ada Lovelace (attempt {number})/{HSL}" for number in (9, 10)),
        f"Ada Lovelace (attempt 1)/{NEXT}",
        **OTHER,
    ),
}


@pytest.mark.parametrize("kind", ["folder", "zip"])
@pytest.mark.parametrize("name", SAMPLES)
def test_every_layout_has_one_student_whose_newest_attempt_counts(tmp_path, name, kind):
    sample = SAMPLES[name]
    files = {sample.newer: answered(2), sample.older: answered(1), sample.following: answered(3)}
    files |= dict.fromkeys(sample.ignored, b"") | dict(sample.more)
    if kind == "zip":
        place = packed(tmp_path / "in.zip", files)
    else:
        place = tmp_path / "in"
        for (
            at,
            content,
        ) in files.items():  # the newest attempt is the oldest file, if nothing else orders them
            put(place, at.replace(":", "_"), content=content)
    first = {at: content for at, content in files.items() if at != sample.following}
    alone = packed(tmp_path / "first.zip", first)
    for path, lessons in ((place, [HSL, NEXT]), (alone, [HSL])):
        found = gather(path, tmp_path / "scratch" / path.name, LESSONS)
        assert who(found) == [(sample.student, lesson[:-6]) for lesson in lessons]
        assert (found.refused, found.unknown, found.wrapper) == ((), (), "")
        assert found.submissions[0].late == sample.late
        assert len(found.submissions[0].notes) == 1
        assert found.recognised[0].startswith(sample.platform or name.split(",")[0])
        assert "the newest of each counts" in found.recognised[0]
        if kind == "zip" and sample.older.rpartition("/")[0] != sample.newer.rpartition("/")[0]:
            assert read(found.submissions[0]).notebook == answered(2)


def test_the_next_week_has_the_same_students_and_no_guard_stops_a_platforms_own_folder(tmp_path):
    for number, sample in enumerate(SAMPLES.values()):
        following = packed(tmp_path / "next.zip", {sample.following: answered(1)} | dict(sample.more))
        found = gather(following, tmp_path / str(number), LESSONS, known=Roster.of([sample.student]))
        assert who(found) == [(sample.student, NEXT[:-6])] and not found.wrapper


WHEN = {  # by the platform
    "Brightspace, folders": "2026-11-21 00:01",
    "Brightspace, flat": "2024-09-25 11:49",
    "Blackboard, flat": "2024-10-02 22:59",
    "Blackboard, folders": "2024-10-02 22:59",
    "Sakai": "2026-11-20 20:15+00:00",
    "nbgrader, submitted": "2026-11-20 20:15+00:00",
    "nbgrader, inbound": "2026-11-20 21:46+00:00",
    "Gradescope": "2026-11-21 08:00+00:00",
    "ILIAS": "2026-11-21 20:45",
}


@pytest.mark.parametrize("name", SAMPLES)
def test_the_time_is_the_platforms_and_no_student_writes_it(tmp_path, name):
    sample = SAMPLES[name]
    folder = sample.newer.rpartition("/")[0].removesuffix("/Submission attachment(s)")
    forged = f"{sample.newer.rpartition('/')[0]}/deeper/timestamp.txt"
    files = {sample.newer: answered(1), f"{folder}/timestamp.txt": b"2026-11-20T20:15:00Z"} | dict(
        sample.more
    )
    found = gather(
        packed(tmp_path / "in.zip", files | {forged: b"2026-01-01 00:00:00 UTC"}), tmp_path / "s", LESSONS
    )
    (made,) = found.submissions
    assert (made.handed_in, made.timed_by) == (WHEN.get(name, ""), "platform" if name in WHEN else "")


@pytest.mark.parametrize(
    ("text", "time"),
    [
        ("Freitag, 20. November 2026, 21:32", "2026-11-20 21:32"),
        ("viernes, 20 de noviembre de 2026, 21:32", "2026-11-20 21:32"),
        ("20261120211500000", "2026-11-20 21:15+00:00"),
        ("2026-11-20 15:58:23.948203 America/Los_Angeles", "2026-11-20 15:58-08:00"),
        ("2026-11-20 15:58:23 -0800", "2026-11-20 15:58-08:00"),
        ("2026-11-20 15:58 Middle/Earth", "2026-11-20 15:58"),
        ("2026-11-20", ""),
        ("03/04/2026 10:00", ""),
        ("-", ""),
    ],
)
def test_times_are_read_as_platforms_write_them(text, time):
    assert read_time(text) == time


NOT_UNDERSTOOD = {
    "is a date or an attempt": ["2026-11-20/"],
    "submission_metadata.yml": ["submission_30000/"],
    "cannot be read": ["Ada 9:26 PM_"],
    "cannot be read ": ["Ada 03-04-2026/", "Ada 04-03-2026/"],
    "cannot be read  ": ["x+y+2026-13-20 21:45:00 UTC/"],
    "attempts of one student": ["ada_20261120_", "ada_20261121_"],
    "attempts of one student ": ["Ada/", "Ada (1)/"],
    "rename them": ["jan/", "jan_2/", "Jan-3/"],
    "rename them ": ["jan_", "jan 2_"],
    "different numbers": [f"5{k}-6 - Ada - Nov 2{k}, 2026 932 PM/" for k in (0, 1)],
    "cannot be distinguished": ["a_b_c_attempt_2024-10-01-22-59-10_"],
    "names no student": ["submission-20260301-120000.zip"],
}


@pytest.mark.parametrize("asked", NOT_UNDERSTOOD)
def test_what_is_not_understood_is_asked_about_and_never_guessed(tmp_path, asked):
    names = [each if each.endswith(".zip") else each + HSL for each in NOT_UNDERSTOOD[asked]]
    path = packed(tmp_path / "in.zip", dict.fromkeys([*names, f"zoe/{HSL}"], answered(1)))
    found = gather(path, tmp_path / "scratch", LESSONS)
    assert who(found) == [("zoe", HSL[:-6])]
    assert len(found.not_graded) == len(names)
    assert all(asked.strip() in line for line in found.not_graded)
    assert all("folder" in line or "names no" in line for line in found.not_graded)


NO_DATES = "20211123;ada_20211123;team_7;s124;lovelace2026;12-34-5678;Maja Novak;ada (1);v2"


@pytest.mark.parametrize("name", NO_DATES.split(";"))
def test_numbers_of_students_are_no_dates(tmp_path, name):
    found = gather(packed(tmp_path / "in.zip", {f"{name}/{HSL}": answered(1)}), tmp_path, LESSONS)
    assert who(found) == [(name, HSL[:-6])] and not found.unknown


def students_in(folder, name, files):
    """Gather a zip of notebooks, or of given contents, and return the students."""
    contents = files if isinstance(files, dict) else dict.fromkeys(files, answered(1))
    found = gather(packed(folder / f"{name}.zip", contents), folder / name, LESSONS)
    assert len(found.submissions) + len(found.not_graded) > 0
    return [student for student, _ in who(found)]


def test_blackboards_receipt_tells_a_title_from_a_user_that_both_have_underscores(tmp_path):
    start = "Lab_1_ada_l_attempt_2024-10-01-22-59-10"
    files = {f"{start}_{HSL}": answered(1)}
    receipt = {f"{start}.txt": b"Name: Ada (eve) (ada_l)\r\nAssignment: Lab_1 (eve)"}
    assert students_in(tmp_path, "receipt", files | receipt) == ["ada_l"]
    forged = (f"{start}_notes.txt", f"{start.replace('ada_l', 'l')}/{start}.txt")
    assert students_in(tmp_path, "forged", files | dict.fromkeys(forged, b"Name: Lovelace (l)")) == []
    lesson = [f"{HSL[:-6]}_ada_l_attempt_2024-10-01-22-59-10_{HSL}"]
    assert students_in(tmp_path, "lesson", lesson) == ["ada_l"]


STUDENTS = ["Ada Lovelace", "lovelace_ada", "s124", "José Núñez", "李明", "O'Brien, Mae", "nao 7"]
TIMES = ["{:%Y-%m-%d %H:%M}", "{:%Y%m%d-%H%M%S}", "{:%b %d, %Y %I%M %p}", "{:%d.%m.%Y %H.%M}"]
TIMES += ["{:%Y-%m-%dT%H:%M:%SZ}"]


@given(
    st.sampled_from(STUDENTS),
    st.sampled_from(TIMES),
    st.lists(st.datetimes(datetime(2026, 1, 13), datetime(2026, 1, 28)), min_size=2, max_size=2),
    st.integers(1, 99),
    st.sampled_from(["{0}_{1}", "{1} {0}", "{0} - {1}", "{0} ({1})"]),
    st.booleans(),
)
def test_no_date_time_or_attempt_changes_the_student(student, form, times, attempt, order, in_folder):
    for time in times:
        for mark in (form.format(time), f"attempt {attempt}", f"Version_{attempt}"):
            written = order.format(student, mark)
            parts = (written, HSL) if in_folder else (f"{written}_{HSL}",)
            made = handed_in(parts, LESSONS)
            assert made.problem or made.student == student
    early, late = sorted(time.replace(second=0, microsecond=0) for time in times)
    assert read_marks(f"x {form.format(early)}").time <= read_marks(f"x {form.format(late)}").time


@pytest.mark.parametrize(
    ("parts", "student", "file"),
    [
        (("ada", "deep", HSL), "ada", HSL),
        ((f"ada_{HSL}",), "ada", HSL),
        ((f"cc_123456\u00a0_22_{HSL}",), "cc_123456", HSL),
        ((f"mueller_123456_{HSL}",), "mueller_123456", HSL),
        ((f"team_7_01_{HSL}",), "team_7", HSL),
        ((f"eve_99_789_x_1234567{HSL}",), "eve_99", f"x_1234567{HSL}"),
        ((f"ada{HSL}",), "ada", HSL),
        (("ada_submission-20260301-120000.zip",), "ada", "submission-20260301-120000.zip"),
    ],
)
def test_the_name_before_the_lesson_is_the_students(parts, student, file):
    named = handed_in(parts, LESSONS)
    assert (named.student, named.file) == (student, file)


def test_a_file_that_its_student_named_like_one_of_moodles_passes_for_nobodys():
    theirs = f"Eve_99_assignsubmission_file_Ada Lovelace_12_assignsubmission_file_{HSL}"
    named = handed_in((theirs,), LESSONS)
    assert named is None
    inside = handed_in(("Eve_99_assignsubmission_file_", theirs), LESSONS)
    assert (inside.student, inside.file) == ("Eve_99", theirs)
    assert handed_in((HSL,), LESSONS) is None and handed_in((f"Kopie von {HSL}",), LESSONS) is None


def test_canvas_knows_its_own_names_again():
    for name in ("lovelaceada_LATE_1_2_x", "LATE_anon_aB3dE_2_x"):
        assert canvas_name(f"{name}.zip/{HSL}") == name
    assert canvas_name(f"ada/{HSL}") == ""


LONG = 60_000
PIECES = ["1", "a", "_", "-", " ", ".", "(1)", "_1", "-1", " copy", "copy of ", "-0a", "\n", HSL[:-6], "1-"]
PIECES += ["Nov 1, ", "_1_assignsubmission_file_", "_attempt_2024-", "+", "(a", " - ", "2026-11-", "attempt "]


@pytest.mark.parametrize("piece", PIECES)
@pytest.mark.parametrize(
    "before", ["", HSL[:-6], "x_1_2_01_hsl_filtering", "Ada_1_assignsubmission_file_", "1-2 - "]
)
def test_names_of_any_length_are_read_in_one_pass(piece, before):
    for name in (before + piece * (LONG // len(piece)) + "x.ipynb", before + piece * 60 + "x.ipynb"):
        with alarm(120.0):
            handed_in((name,), LESSONS)
            handed_in((name, name), LESSONS)
