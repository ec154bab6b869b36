"""What students hand in is found whatever a platform made of its name, and none of it is trusted."""

import json
import os
import random
import re
import zipfile
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import pytest

from nao_course import homework
from nao_course.exercises.answered import BLANK as BLANK_NOTE
from nao_course.instructor.collecting import submissions
from nao_course.instructor.collecting.archives import LARGEST_READ, Refused
from nao_course.instructor.collecting.files import read
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.collecting.submissions import Submission, gather, of_lessons
from tests.handed_in import HSL, LESSONS, NOTEBOOK, answered, packed, posix, put, reasons, who
from tests.paths import PROJECT

# --- names ---


def test_lateness_and_the_time_of_a_receipt_are_kept(look, tmp_path):
    put(tmp_path / "work", HSL)
    receipt = homework.submit(tmp_path / "work", tmp_path)
    zipped = receipt.path.read_bytes()
    names = {
        f"ada_LATE_1_11_{HSL}": NOTEBOOK,
        f"ben_2_12_{HSL}": NOTEBOOK,
        "eve_LATE_3_13_submission-20261120-120000.zip": zipped,
        f"Zed_4_assignsubmission_file_/{HSL}": NOTEBOOK,
    }
    found = {each.student: each for each in look(packed(tmp_path / "in.zip", names)).submissions}
    assert {name: each.late for name, each in found.items()} == {
        "ada_1": True,
        "ben_2": False,
        "eve_3": True,
        "Zed_4": False,
    }
    assert [each.handed_in for each in found.values() if each.student != "eve_3"] == ["", "", ""]
    told = datetime.fromisoformat(found["eve_3"].handed_in)
    assert told == datetime.fromisoformat(receipt.time).replace(second=0, microsecond=0)


# --- names that are not the lesson's ---

STAMPED = b'{"cells": [], "metadata": {"nao_course": {"lesson": "01_hsl_filtering", "version": "1"}}, "nbformat": 4}'
CLAIMED = json.dumps(
    {"cells": [{"source": '"nao_course": {"lesson": "01_hsl_filtering"}'}], "metadata": {}}
).encode()


@pytest.mark.parametrize("name", ["ada/homework1.ipynb", "ada_1_assignsubmission_file_/homework1.ipynb"])
def test_a_notebook_of_another_name_counts_where_its_metadata_name_the_only_wanted_lesson(tmp_path, name):
    put(tmp_path / "in", name, content=STAMPED)
    (one,) = gather(tmp_path / "in", tmp_path / "s", LESSONS, ["01_hsl_filtering"]).submissions
    assert one.lesson == "01_hsl_filtering"
    assert one.notes == (f"{name} counts as 01_hsl_filtering, because its metadata name that lesson",)
    for wanted in (None, ["02_goal_posts"], ["01_hsl_filtering", "02_goal_posts"]):
        found = gather(tmp_path / "in", tmp_path / "s", LESSONS, wanted)
        assert found.submissions == () and "named after no lesson" in found.not_graded[0]


@pytest.mark.parametrize("content", [NOTEBOOK, CLAIMED, STAMPED + STAMPED.replace(b"01_hsl", b"02_hsl"), b""])
def test_a_notebook_of_another_name_whose_metadata_do_not_name_the_lesson_is_reported(tmp_path, content):
    put(tmp_path / "in", "ada/homework1.ipynb", content=content)
    found = gather(tmp_path / "in", tmp_path / "s", LESSONS, ["01_hsl_filtering"])
    assert found.submissions == () and "named after no lesson" in found.not_graded[0]


def test_a_notebook_with_the_lessons_name_counts_before_a_newer_one_without(tmp_path):
    put(tmp_path / "in", f"ada/{HSL}", "ada/homework1.ipynb", content=STAMPED)
    os.utime(tmp_path / "in" / "ada" / HSL, (1, 1))
    (one,) = gather(tmp_path / "in", tmp_path / "s", LESSONS, ["01_hsl_filtering"]).submissions
    assert one.file == f"ada/{HSL}"
    assert one.notes == ("ada/homework1.ipynb does not count: another one has the lesson's name",)


@pytest.mark.parametrize("content", [b"", b"<p>Dear Sir</p>"])
@pytest.mark.parametrize("text", ["onlinetext_/onlinetext.html", "onlinetext_onlinetext.html"])
def test_what_a_student_typed_into_moodles_text_field_is_no_alarm(look, tmp_path, text, content):
    start = "Ada_1_assignsubmission_"
    found = look(packed(tmp_path / "in.zip", {f"{start}file_/{HSL}": NOTEBOOK, f"{start}{text}": content}))
    assert who(found) == [("Ada_1", "01_hsl_filtering")] and found.unknown == ()
    alone = look(packed(tmp_path / "other.zip", {f"{start}{text}": content}))
    assert alone.not_graded == ("Ada_1: there is no notebook of a lesson",)


def test_another_notebook_is_called_newer_only_where_it_is(look, tmp_path):
    names = (f"ada/{HSL}", "ada/01_hsl_filtering (1).ipynb")
    put(tmp_path / "in", *names)
    for name, time in zip(names, (2, 1), strict=True):
        os.utime(tmp_path / "in" / name, (time, time))
    assert look(tmp_path / "in").submissions[0].notes == (f"{names[1]} does not count: another one is newer",)
    os.utime(tmp_path / "in" / names[1], (2, 2))
    assert look(tmp_path / "in").submissions[0].notes == (f"{names[1]} does not count: another one counts",)


def test_the_times_in_moodles_zip_are_those_of_the_download_and_say_nothing_about_age(look, tmp_path):
    start = "Ada_1_assignsubmission_file_"
    path = tmp_path / "in.zip"
    with zipfile.ZipFile(path, "w") as archive:
        for second, name in enumerate((f"{start}/a/{HSL}", f"{start}/b/{HSL}")):
            archive.writestr(zipfile.ZipInfo(name, (2026, 3, 1, 12, 0, 2 * second)), NOTEBOOK)
    assert look(path).submissions[0].notes == (f"{start}/a/{HSL} does not count: another one counts",)


def test_what_is_named_after_nothing_is_reported_by_its_name(look, tmp_path):
    path = put(tmp_path / "in", "ada/homework.ipynb", "stray.ipynb", "ada/essay.pdf", f"ada/{HSL}", HSL)
    found = look(path)
    assert who(found) == [("ada", "01_hsl_filtering")]
    assert sorted(each.split(":")[0] for each in found.unknown) == [
        HSL,
        "ada/essay.pdf",
        "ada/homework.ipynb",
        "stray.ipynb",
    ]


def test_all_lessons_of_all_students_come_in_order_whatever_the_folders_order(look, tmp_path):
    names = [f"{student}/{lesson}.ipynb" for student in ("b", "a", "c") for lesson in LESSONS]
    random.Random(1).shuffle(names)
    found = look(put(tmp_path / "in", *names))
    assert who(found) == [(student, lesson) for student in "abc" for lesson in LESSONS]
    chosen = gather(tmp_path / "in", tmp_path, LESSONS, ["02_goal_posts"])
    assert who(chosen) == [(student, "02_goal_posts") for student in "abc"]
    assert chosen.unknown == ()
    put(tmp_path / "in", "d/01_hsl_filtering.ipynb", content=b"")
    everything = of_lessons(gather(tmp_path / "in", tmp_path, LESSONS), LESSONS)
    assert [each.student for each in everything] == [*"aaabbbccc", "d"]


def test_two_students_of_one_name_or_in_other_case_stay_two(look, tmp_path):
    found = look(
        packed(
            tmp_path / "in.zip",
            {
                f"Ada_1_assignsubmission_file_/{HSL}": NOTEBOOK,
                f"Ada_2_assignsubmission_file_/{HSL}": NOTEBOOK,
                f"bob/{HSL}": NOTEBOOK,
                f"Bob/{HSL}": NOTEBOOK,
            },
        )
    )
    students = [student for student, _ in who(found)]
    assert students == ["Ada_1", "Ada_2", "Bob", "bob"]
    assert len({safe_name(each).lower() for each in students}) == 4


@pytest.mark.parametrize("kind", ["folder", "zip"])
def test_one_folder_around_all_students_is_taken_away_and_a_students_own_is_not(look, tmp_path, kind):
    def students(*names):
        path = tmp_path / f"in{len(list(tmp_path.iterdir()))}"
        folder = kind == "folder"
        found = look(
            put(path, *names) if folder else packed(path.with_suffix(".zip"), dict.fromkeys(names, NOTEBOOK))
        )
        return [student for student, _ in who(found)]

    assert students(*(f"wrapper/{student}/{HSL}" for student in ("ada", "bob", "cleo"))) == [
        "ada",
        "bob",
        "cleo",
    ]
    alone = "Ada Lovelace_1234567_assignsubmission_file_"
    assert students(f"{alone}/eve/{HSL}", f"{alone}/bob/{HSL}") == ["Ada Lovelace_1234567"]
    assert students("ada/week 1/00_meet_the_nao.ipynb", f"ada/week 2/{HSL}") == ["ada", "ada"]
    assert students(f"ada/{HSL}", f"ada/old/{HSL}") == ["ada"]


def test_the_folder_of_one_student_is_hers_whatever_is_in_it(tmp_path):
    put(tmp_path / "in", f"submission/a/{HSL}", f"submission/b/{HSL}")
    assert who(gather(tmp_path / "in", tmp_path / "scratch", LESSONS, one_student=True)) == [
        ("submission", HSL[:-6])
    ]


@pytest.mark.parametrize("student", ["release", "kept", "__pycache__", ".x"])
def test_a_student_may_be_called_as_a_program_calls_its_folders(look, tmp_path, student):
    assert who(look(put(tmp_path / "in", f"{student}/{HSL}"))) == [(student, "01_hsl_filtering")]
    assert who(look(packed(tmp_path / "in.zip", {f"{student}/{HSL}": NOTEBOOK}))) == [
        (student, "01_hsl_filtering")
    ]


@pytest.mark.parametrize(
    "name", [".git/config", ".ipynb_checkpoints/stray.ipynb", "__MACOSX/ada/._x.ipynb", ".DS_Store"]
)
def test_what_programs_leave_beside_all_students_is_nobodys(look, tmp_path, name):
    found = look(put(tmp_path / "in", f"ada/{HSL}", name))
    assert who(found) == [("ada", "01_hsl_filtering")] and found.unknown == ()
    assert look(packed(tmp_path / "in.zip", {f"ada/{HSL}": NOTEBOOK, name: b"x"})).unknown == ()


def test_students_whose_names_look_alike_are_refused_and_neither_has_the_others_work(look, tmp_path):
    alike = [("Ada", "Ada "), ("M\u00fcller", "Mu\u0308ller")]
    names = [f"{student}/{HSL}" for pair in alike for student in pair]
    found = look(packed(tmp_path / "in.zip", dict.fromkeys([*names, f"bob/{HSL}"], NOTEBOOK)))
    assert who(found) == [("bob", "01_hsl_filtering")]
    assert {student for student, _ in reasons(found)} == {"Ada", "Müller"}
    assert all(
        "2 folders or files have names that are too similar" in reason for reason in reasons(found).values()
    )


def test_whoever_is_not_graded_is_named_before_what_nobody_misses(look, tmp_path):
    put(
        tmp_path / "in",
        f"ada/{HSL}",
        "bob/mine.py",
        "cleo/essay.pdf",
        "dan/kept/01_hsl_filtering.ipynb",
        "eve/work.ipynb",
    )
    put(tmp_path / "in", *(f"ada/junk{number}.txt" for number in range(25)))
    (tmp_path / "in" / "fay").mkdir()
    found = look(tmp_path / "in")
    assert [each.split("/")[0].split(":")[0] for each in found.not_graded] == [
        "eve",
        "bob",
        "cleo",
        "dan",
        "fay",
    ]
    assert found.unknown[:5] == found.not_graded and len(found.unknown) == 5 + 26


def test_a_file_beside_the_students_folders_that_may_be_somebodys_work_is_named_as_not_graded(look, tmp_path):
    spoiled = ("", ".ipynb.txt", ".ipynb.download", ".ipynb.bak", ".zip.part", ".ipynb.json")
    named = [f"s{at}_01_hsl_filtering{suffix}" for at, suffix in enumerate(spoiled)]
    put(tmp_path / "in", f"ada/{HSL}", "marks.xlsx", "READ_ME", *named)
    found = look(tmp_path / "in")
    assert [each.partition(": ")[0] for each in found.not_graded] == named
    assert {each.partition(": ")[2] for each in found.not_graded} == {"it is no notebook"}
    assert [each.partition(": ")[0] for each in found.unknown[len(named) :]] == ["READ_ME", "marks.xlsx"]


def test_a_student_with_many_lost_files_hides_nobody(look, tmp_path):
    put(tmp_path / "in", *(f"ada/{number:02}.zip" for number in range(40)), "bob/essay.pdf", content=b"")
    found = look(put(tmp_path / "in", "zoe/work.ipynb", "zoe/more.ipynb"))
    assert [each.partition(": ")[0] for each in found.not_graded[:4]] == [
        "ada/00.zip",
        "zoe/more.ipynb",
        "bob",
        "ada/01.zip",
    ]


@posix
def test_a_link_in_the_place_of_a_students_folder_is_named_as_not_graded(look, tmp_path):
    put(tmp_path / "in", f"ada/{HSL}")
    (tmp_path / "in" / "ben").symlink_to(tmp_path / "in" / "ada")
    (tmp_path / "in" / "cleo").symlink_to("nowhere")
    found = look(tmp_path / "in")
    reason = "it is a symbolic link, not a file or folder"
    assert found.not_graded == (f"ben: {reason}", f"cleo: {reason}")


def test_a_file_that_went_away_before_it_was_read_is_refused_in_plain_words(tmp_path):
    with pytest.raises(Refused, match="^it was removed or renamed while the grader was running$"):
        read(Submission("ada", LESSONS[1], tmp_path / "gone.ipynb"))


# --- which one counts ---


def test_what_submit_packs_is_taken_and_the_later_receipt_counts(look, tmp_path):
    put(tmp_path / "work", HSL, "helper.py", content=NOTEBOOK)
    receipt = homework.submit(tmp_path / "work", tmp_path / "in" / "ada")
    early = packed(
        tmp_path / "in" / "ada" / "submission-20200101-120000.zip",
        {HSL: b"old", "receipt.json": json.dumps({"time": "2020-01-01T12:00:00+00:00"}).encode()},
    )
    os.utime(receipt.path, (1e9, 1e9))  # copied about: the file's time says nothing
    os.utime(early, (2e9, 2e9))
    (found,) = look(tmp_path / "in").submissions
    assert read(found).notebook == NOTEBOOK
    assert list(read(found).helpers) == ["helper.py"]
    assert found.file.startswith(f"ada/{receipt.path.name}/")


TIMES = ("0001-01-01T00:00:00+14:00", "9999-12-31T23:59:59.999999+00:00", "1999-01-01T00:00:00+00:00")


@pytest.mark.parametrize(
    "receipt",
    [
        *(b"", b"[" * 60000, b'{"time": 7}', b'{"time": "soon"}', b"\xff", b"x" * 10**6, b"[7]"),
        json.dumps({"versions": ["numpy"], "time": None}).encode(),
        *(json.dumps({"time": time}).encode() for time in (*TIMES, "2026-11-20T23:59:00", "2026-11-20")),
    ],
)
def test_a_receipt_without_a_plausible_time_harms_nobody_and_is_named(look, tmp_path, receipt):
    packed(tmp_path / "in" / "ada" / "submission.zip", {HSL: NOTEBOOK, "receipt.json": receipt})
    found = look(put(tmp_path / "in", f"ben/{HSL}"))
    assert who(found) == [("ada", HSL[:-6]), ("ben", HSL[:-6])]
    assert found.submissions[0].handed_in == "" and "does not count" in found.submissions[0].notes[0]


def test_one_students_odd_file_or_notebook_stops_nobody_else(look, tmp_path, monkeypatch):
    def fail(*_):
        raise MemoryError("odd")

    inner = packed(tmp_path / "inner.zip", {HSL: NOTEBOOK}).read_bytes()
    names = {f"ada/{HSL}": NOTEBOOK, "ben/work.zip": inner, f"eve/{HSL}": NOTEBOOK, f"eve/a {HSL}": NOTEBOOK}
    path = packed(tmp_path / "in.zip", names)
    monkeypatch.setattr(submissions, "_receipt", fail)
    monkeypatch.setattr(submissions, "inspect_notebook", fail)
    found = look(path)
    assert who(found) == [("ada", HSL[:-6])]
    assert [line.split(":")[0] for line in found.not_graded] == ["ben/work.zip", f"eve, {HSL[:-6]}"]
    assert all("MemoryError: odd" in line for line in found.not_graded)


# --- which of several notebooks counts ---

GOOD, BLANK = answered(3), answered(0)
UNREADABLE = {
    "page": b"<!DOCTYPE html><html></html>",
    "half": GOOD[: len(GOOD) // 2],
    "empty": b"",
    "zip": b"PK\x03\x04 and more",
    "number": b"7",
    "many brackets": b"[" * (LARGEST_READ + 1),
}


@pytest.mark.parametrize("worse", [*UNREADABLE, "blank"])
@pytest.mark.parametrize("better", ["good", "blank", "large"])
def test_a_notebook_with_less_in_it_never_counts_before_one_with_more(look, tmp_path, worse, better):
    contents = {"good": GOOD, "blank": BLANK, "large": GOOD[:-1] + b" " * LARGEST_READ + b"}"}
    older, newer = f"ada/{HSL}", f"ada/{HSL[:-6]} (1).ipynb"
    for name, content, time in ((older, contents[better], 1e9), (newer, (UNREADABLE | contents)[worse], 2e9)):
        put(tmp_path / "in", name, content=content)
        os.utime(tmp_path / "in" / name, (time, time))
    found = look(tmp_path / "in")
    expected = newer if (worse, better) == ("blank", "blank") else older
    assert found.submissions[0].file == expected
    assert len(found.older) == (expected == older) and len(found.submissions[0].notes) == 1
    together = packed(tmp_path / "one.zip", {older: contents[better], newer: (UNREADABLE | contents)[worse]})
    if worse != better:
        assert look(together).submissions[0].file == older


def test_of_notebooks_of_one_time_the_one_with_more_answers_counts_whatever_they_are_called(look, tmp_path):
    names = [f"ada/{HSL}", f"ada/{HSL[:-6]}-Copy1.ipynb", f"ada/a {HSL}"]
    for turn in range(3):
        contents = dict(zip(names, [answered((turn + at) % 3 + 1) for at in range(3)], strict=True))
        found = look(packed(tmp_path / f"{turn}.zip", contents))
        assert read(found.submissions[0]).notebook == answered(3)


@pytest.mark.parametrize("keeps", [True, False])
def test_what_only_repeats_the_release_is_no_answer_with_or_without_its_metadata(look, tmp_path, keeps):
    blank, solved = (json.loads((PROJECT / each / HSL).read_bytes()) for each in ("notebooks", "solutions"))
    for cell in () if keeps else (*blank["cells"], *solved["cells"]):
        cell["metadata"] = {}
    put(tmp_path / "in", f"ada/older {HSL}", content=json.dumps(solved).encode())
    put(tmp_path / "in", f"ada/{HSL}", content=json.dumps(blank).encode())
    os.utime(tmp_path / "in" / f"ada/older {HSL}", (1e9, 1e9))
    (found,) = look(tmp_path / "in").submissions
    assert "older" in found.file and found.notes[0].endswith(BLANK_NOTE)


def test_in_a_students_zip_the_newest_answered_copy_counts_with_and_without_a_receipt(look, tmp_path):
    names = [HSL, f"Kopie von {HSL}", f"{HSL[:-6]} (1).ipynb"]
    for at, (name, answers) in enumerate(zip(names, (3, 1, 0), strict=True)):
        put(tmp_path / "work", name, content=answered(answers))
        os.utime(tmp_path / "work" / name, (1.7e9 + 100 * at, 1.7e9 + 100 * at))
    zipped = homework.submit(tmp_path / "work", tmp_path / "in" / "ada").path
    with zipfile.ZipFile(zipped) as whole, zipfile.ZipFile(tmp_path / "plain.zip", "w") as plain:
        for entry in whole.infolist():
            if entry.filename != "receipt.json":
                plain.writestr(entry, whole.read(entry))
    put(tmp_path / "in", "ben/work.zip", content=(tmp_path / "plain.zip").read_bytes())
    for found in look(tmp_path / "in").submissions:
        assert read(found).notebook == answered(1) and len(found.notes) == 2


def test_another_lessons_notebook_under_this_lessons_name_never_counts_before_an_answer(look, tmp_path):
    other = json.loads((PROJECT / "solutions" / "02_goalposts.ipynb").read_bytes())
    pasted = {"cell_type": "code", "metadata": {}, "source": "def hue_mask(hue):\n    return hue > 1"}
    for cells, counts in ((other["cells"], "older"), ([*other["cells"], pasted], "newer")):
        path = put(tmp_path / counts, f"ada/older {HSL}", content=answered(1))
        put(path, f"ada/{HSL}", content=json.dumps(other | {"cells": cells}).encode())
        os.utime(path / f"ada/older {HSL}", (1e9, 1e9))
        (found,) = look(path).submissions
        assert ("older" in found.file) == (counts == "older")


def test_words_behind_the_lesson_are_one_students_or_asked_about(look, tmp_path):
    mine = [f"ada/{HSL[:-6]}_ada.ipynb", f"ada/{HSL[:-6]}_ada (1).ipynb"]
    assert who(look(put(tmp_path / "in", *mine))) == [("ada", HSL[:-6])]
    found = look(put(tmp_path / "in", f"ada/{HSL[:-6]}_ben.ipynb", f"zoe/{HSL}"))
    assert who(found) == [("zoe", HSL[:-6])] and "different words" in found.not_graded[0]


@pytest.mark.parametrize(
    ("name", "student"),
    [
        ("ada_submission-20260301-120000.zip", "ada"),
        ("ada/submission-20260301-120000.zip", "ada"),
        ("lovelaceada_LATE_12_34_submission-20260301-120000-1.zip", "lovelaceada_12"),
        ("Ada L_12_assignsubmission_file_/submission-20260301-120000.zip", "Ada L_12"),
    ],
)
def test_zips_of_students_are_looked_into_wherever_they_are(look, tmp_path, name, student):
    inner = packed(tmp_path / "inner.zip", {HSL: NOTEBOOK}).read_bytes()
    assert who(look(put(tmp_path / "in", name, content=inner))) == [(student, "01_hsl_filtering")]
    assert who(look(packed(tmp_path / "in.zip", {name: inner}))) == [(student, "01_hsl_filtering")]


def test_helpers_come_along_by_the_name_they_are_imported_by(look, tmp_path):
    put(tmp_path / "in", f"ada/{HSL}", "ada/mine.py", "bob/other.py", f"bob/sub/{HSL}", "ada/not-a-module.py")
    ada, bob = look(tmp_path / "in").submissions
    assert [name for name, _ in ada.helpers] == ["mine.py"]
    assert bob.helpers == ()  # it lies elsewhere
    names = ["x_1_20_01_hsl_filtering.ipynb", "x_1_21_mine.py", "y_2_22_mine.py"]
    (found,) = look(packed(tmp_path / "in.zip", dict.fromkeys(names, NOTEBOOK))).submissions
    assert [name for name, _ in found.helpers] == ["mine.py"]


def test_no_more_helpers_come_along_than_a_student_needs(look, tmp_path):
    put(tmp_path / "in", f"ada/{HSL}", *(f"ada/m{number}.py" for number in range(30)))
    put(tmp_path / "in", "ada/big.py", content=b"#" * (submissions.LARGEST_HELPER + 1))
    (found,) = look(tmp_path / "in").submissions
    assert len(found.helpers) == submissions.MOST_HELPERS
    assert len(found.notes) == 11


def test_the_hash_is_of_all_that_was_handed_in(tmp_path):
    put(tmp_path, "a.ipynb", "h.py")
    plain = Submission("ada", LESSONS[1], tmp_path / "a.ipynb")
    helped = Submission("ada", LESSONS[1], tmp_path / "a.ipynb", (("h.py", tmp_path / "h.py"),))
    renamed = Submission("ada", LESSONS[1], tmp_path / "a.ipynb", (("g.py", tmp_path / "h.py"),))
    hashes = [read(each).hash for each in (plain, helped, renamed)]
    put(tmp_path, "h.py", content=b"other")
    assert len({*hashes, read(helped).hash}) == 4
    assert read(plain).hash == hashes[0]
    put(tmp_path, "earlier.ipynb")
    after = replace(plain, earlier=(Submission("ada", LESSONS[0], tmp_path / "earlier.ipynb"),))
    first = read(after).hash
    put(tmp_path, "earlier.ipynb", content=b"other")
    assert len({hashes[0], first, read(after).hash}) == 3


# --- several students where one is expected ---


def test_who_handed_in_nothing_that_counts_is_named_however_the_platform_packs_it(look, tmp_path):
    empty = packed(tmp_path / "empty.zip", {}).read_bytes()
    only_ours = packed(
        tmp_path / "ours.zip", {f"release/{HSL}": NOTEBOOK, f"kept/{HSL}": NOTEBOOK}
    ).read_bytes()
    hidden = packed(tmp_path / "hidden.zip", {f"__MACOSX/{HSL}": b"x", ".x/y.ipynb": b"x"}).read_bytes()
    essay = packed(tmp_path / "essay.zip", {"essay.pdf": b"x"}).read_bytes()
    for at, content in enumerate((empty, only_ours, hidden, essay)):
        for name in (
            f"s{at}_{at}_9_work.zip",
            f"S{at}_{at}_assignsubmission_file_work.zip",
            f"s{at}/work.zip",
        ):
            found = look(put(tmp_path / f"in{at}-{len(name)}", name, f"ada/{HSL}", content=NOTEBOOK))
            put(tmp_path / f"in{at}-{len(name)}", name, content=content)
            found = look(tmp_path / f"in{at}-{len(name)}")
            assert who(found) == [("ada", HSL[:-6])]
            assert len(found.not_graded) == 1 and found.not_graded[0].startswith(name), found
    found = look(put(tmp_path / "in", f"x_1_2_{HSL}", "y_3_4_essay.pdf"))
    assert found.not_graded == ("y_3: there is no notebook of a lesson",)


def test_an_empty_folder_in_a_zip_names_its_student(look, tmp_path):
    moodle = "_assignsubmission_file_/"
    found = look(packed(tmp_path / "in.zip", {f"Ada_1{moodle}{HSL}": NOTEBOOK, f"Gil_7{moodle}": b""}))
    assert who(found) == [("Ada_1", HSL[:-6])]
    assert found.not_graded == ("Gil_7: there is no notebook of a lesson",)
    found = look(packed(tmp_path / "in2.zip", {f"ada/{HSL}": NOTEBOOK, "ada/": b"", "hal/sub/": b""}))
    assert found.not_graded == ("hal: there is no notebook of a lesson",)


OF_OTHER_LESSONS = (
    "ben/02_goal_posts.ipynb",
    "cleo/02_goal_posts.zip",
    "dan/02_goal_posts.ipynb.txt",
    "eve_02_goal_posts.rar",
    "02_goal_posts.ipynb",
    "Fay 03-04-2026_02_goal_posts.ipynb",
    "gil/02_goal_posts_a.ipynb",
    "gil/02_goal_posts_b.ipynb",
    "02_goal_posts/hal/02_goal_posts.ipynb",
)


def test_other_lessons_are_named_and_only_what_may_be_of_a_wanted_lesson_is_not_graded(tmp_path):
    path = packed(tmp_path / "in.zip", dict.fromkeys([f"ada/{HSL}", *OF_OTHER_LESSONS], NOTEBOOK))
    found = gather(path, tmp_path / "scratch", LESSONS, ["01_hsl_filtering"])
    assert who(found) == [("ada", HSL[:-6])] and found.not_graded == () and found.refused == ()
    listed = "\n".join(found.unknown)
    assert all(re.split("[/_ ]", name)[0] in listed for name in OF_OTHER_LESSONS)
    assert "ben: nothing was handed in for 01_hsl_filtering, only for 02_goal_posts" in listed
    unclear = {"cid/x.zip": b"", "ida/homework.ipynb": NOTEBOOK, "jo/": b"", "kim/01_hsl_filtering.txt": b""}
    path = packed(tmp_path / "unclear.zip", {f"ada/{HSL}": NOTEBOOK} | unclear)
    found = gather(path, tmp_path / "scratch2", LESSONS, ["01_hsl_filtering"])
    lines = [*found.not_graded, *(each.student for each in found.refused)]
    assert sorted(re.split("[/:]", line)[0] for line in lines) == ["cid", "ida", "jo", "kim"]


def test_a_student_cannot_pass_for_the_folder_around_all_students(tmp_path):
    put(tmp_path / "in", f"Eve/Ada/{HSL}", f"Eve/Eve/{HSL}")
    found = gather(tmp_path / "in", tmp_path / "scratch", LESSONS)
    assert not found.submissions and found.not_graded[0].startswith(
        "Eve: it holds the work of several students"
    )
    put(tmp_path / "in2", f"Eve/Ada/{HSL}", f"Eve/Bob/{HSL}")
    found = gather(tmp_path / "in2", tmp_path / "scratch2", LESSONS, known={"Ada", "Eve"})
    assert [student for student, _ in who(found)] == ["Eve"] and not found.wrapper
    found = gather(tmp_path / "in2", tmp_path / "scratch3", LESSONS, known={"Ada", "Bob"})
    assert [student for student, _ in who(found)] == ["Ada", "Bob"] and found.wrapper == "Eve"


@pytest.mark.parametrize(
    "names",
    [
        [f"class/{student}/{HSL}" for student in ("Ada", "Ben", "Zoe")],
        [f"late/Ben_7_assignsubmission_file_/{HSL}"],
        [f"late/Ben_7_assignsubmission_file_{HSL}", f"late/Zoe_8_assignsubmission_file_{HSL}"],
        [f"canvas/ben_1_2_{HSL}", f"canvas/zoe_3_4_{HSL}"],
        ["class/Ada/work.zip", "class/Ben/work.zip"],
        [f"class/Ada_{HSL}", f"class/Ben_{HSL}"],
        [f"a/b/Ada/{HSL}", f"a/b/Ben/{HSL}"],
        [f"late/ben_2_22_{HSL}"],
        [f"late/Ben_7_assignsubmission_file_{HSL}"],
        ["class/Ada/x.zip", f"class/Ben/{HSL}"],
        [f"class/Ada_{HSL[:-6]}.zip", f"class/Ben_{HSL[:-6]}.zip"],
        [f"class/Ada/{HSL}", f"class/Ben_{HSL}"],
    ],
)
def test_a_folder_of_several_students_is_no_student(look, tmp_path, names):
    inner = packed(tmp_path / "inner.zip", {HSL: NOTEBOOK}).read_bytes()
    files = {name: inner if name.endswith(".zip") else NOTEBOOK for name in names}
    alone = look(packed(tmp_path / "alone.zip", files))
    assert len(alone.submissions) == len(names) and alone.wrapper in ("class", "a/b", "late", "canvas")
    for beside in ("readme.txt", f"Carl/{HSL}"):
        found = look(packed(tmp_path / "beside.zip", files | {beside: NOTEBOOK}))
        assert "several students" in found.not_graded[0] and len(found.not_graded) == 1
        assert who(found) == ([("Carl", HSL[:-6])] if "Carl" in beside else [])


@pytest.mark.parametrize("beside", [{}, {"readme.txt": b"x"}, {f"Carl/{HSL}": NOTEBOOK}])
@pytest.mark.parametrize("folder", ["class/", "class/monday/"])
def test_plain_zips_of_one_lesson_in_a_folder_are_not_graded_as_one_student(look, tmp_path, folder, beside):
    inner = packed(tmp_path / "inner.zip", {HSL: NOTEBOOK}).read_bytes()
    files = {f"{folder}{student}.zip": inner for student in ("Ada", "Ben")}
    found = look(packed(tmp_path / "in.zip", files | beside))
    assert who(found) == ([("Carl", HSL[:-6])] if f"Carl/{HSL}" in beside else [])
    (line,) = found.not_graded
    assert line == (
        f"{folder[:-1]}: it holds the work of several students (Ada, Ben), not of one. "
        "Put each zip into a folder that is named after its student"
    )
    apart = {f"{student}/{student}.zip": inner for student in ("Ada", "Ben")}
    assert [student for student, _ in who(look(packed(tmp_path / "apart.zip", apart)))] == ["Ada", "Ben"]
    moodles = {f"Eve_7_assignsubmission_file_/{student}.zip": inner for student in ("Ada", "Ben")}
    assert [student for student, _ in who(look(packed(tmp_path / "moodle.zip", moodles)))] == ["Eve_7"]


@pytest.mark.parametrize("name", ["late_01_hsl_filtering.zip", "late/moodle.zip"])
def test_a_zip_of_several_students_is_no_student(look, tmp_path, name):
    for folder in ("{}", "{}_7_assignsubmission_file_"):
        files = {f"{folder.format(student)}/{HSL}": NOTEBOOK for student in ("Ada", "Ben")}
        inner = packed(tmp_path / "inner.zip", files).read_bytes()
        found = look(packed(tmp_path / "in.zip", {name: inner, f"Cleo/{HSL}": NOTEBOOK}))
        assert who(found) == [("Cleo", HSL[:-6])] and "several students" in found.not_graded[0]


def test_a_wrapper_is_compared_with_students_in_any_case(look, tmp_path):
    assert not look(put(tmp_path / "in", f"Eve/Ada/{HSL}", f"Eve/eve/{HSL}")).submissions
    put(tmp_path / "in2", f"eve/Ada/{HSL}", f"eve/Ben/{HSL}")
    assert not gather(tmp_path / "in2", tmp_path / "scratch", LESSONS, known={"Eve"}).wrapper


@pytest.mark.parametrize(
    "names",
    [
        [f"Ada/old/{HSL}", f"Ada/new/{HSL}"],
        [f"Ada/nao/v1/{HSL}", f"Ada/nao/v2/{HSL}"],
        [f"Ada/{HSL}", f"Ada/backup/{HSL}"],
        [f"Ada/my_{HSL}", f"Ada/old_{HSL}"],
        [f"Ada/ada_{HSL}", f"Ada/Ada Lovelace_{HSL}"],
        [f"Ada/mueller_123456_{HSL}"],
        [f"Ada/ada_123456_1234567_{HSL}"],
        ["Ada/lesson 0/a.zip", "Ada/lesson 1/b.zip"],
        ["Ada/00.zip", "Ada/01.zip"],
        ["Ada/Ada.zip", "Ada/homework.zip", "Ada/submission-20260301-120000.zip", "Ada/hsl.zip"],
    ],
)
def test_copies_in_a_students_own_folder_are_that_students(look, tmp_path, names):
    inner = packed(tmp_path / "inner.zip", {HSL: NOTEBOOK}).read_bytes()
    files = {name: inner if name.endswith(".zip") else NOTEBOOK for name in names}
    for beside in ({}, {f"Ben/{HSL}": NOTEBOOK}):  # also the only student of a class
        found = look(packed(tmp_path / "in.zip", files | beside))
        assert [student for student, _ in who(found)] == ["Ada", "Ben"][: len(beside) + 1]
        assert not found.not_graded and not found.wrapper
    if not any(name.endswith(".zip") for name in names):
        own = {name.removeprefix("Ada/"): content for name, content in files.items()}
        handed_in = packed(tmp_path / "own.zip", own).read_bytes()
        found = look(packed(tmp_path / "in.zip", {"Ada/own.zip": handed_in}))
        assert [student for student, _ in who(found)] == ["Ada"] and not found.not_graded


def test_a_platforms_name_in_another_order_is_the_folders_own(look, tmp_path):
    found = look(put(tmp_path / "in", f"Ada Lovelace/lovelaceada_1_22_{HSL}", f"late/benklein_2_33_{HSL}"))
    assert who(found) == [("Ada Lovelace", HSL[:-6])] and found.not_graded[0].startswith("late: ")


@pytest.mark.parametrize("kind", ["folder", "zip"])
@pytest.mark.parametrize(
    ("first", "second"), [(HSL[:-6], "02_goal_posts"), ("Lesson 01", "lesson 02"), ("week1", "week2")]
)
def test_a_folder_for_each_lesson_is_around_the_students_and_is_none(look, tmp_path, kind, first, second):
    """Each lesson's helper stays with that lesson, because a zip has one folder for both otherwise."""
    files = {
        "readme.txt": b"",
        f"{first}/Ben_{HSL}": NOTEBOOK,
        f"{first}/Eve_7_assignsubmission_file_/{HSL}": b"{}",
    }
    for folder, lesson in ((first, HSL), (second, "02_goal_posts.ipynb")):
        files |= {f"{folder}/Ada/{lesson}": NOTEBOOK, f"{folder}/Ada/mine.py": folder.encode()}
    path = packed(tmp_path / "in.zip", files)
    if kind == "folder":
        zipfile.ZipFile(path).extractall(tmp_path / "in")
        path = tmp_path / "in"
    found = look(path)
    assert who(found) == [("Ada", HSL[:-6]), ("Ada", "02_goal_posts"), ("Ben", HSL[:-6]), ("Eve_7", HSL[:-6])]
    assert not found.not_graded and not found.wrapper
    assert [dict(read(each).helpers) for each in found.submissions[:2]] == [
        {"mine.py": folder.encode()} for folder in (first, second)
    ]
    alone = look(packed(tmp_path / "alone.zip", {f"{first}/Ada/{HSL}": NOTEBOOK}))
    assert who(alone) == [("Ada", HSL[:-6])] and alone.wrapper == first


@pytest.mark.parametrize("folder", [HSL[:-6], "Lesson 01", "week1"])
def test_a_folder_of_a_lesson_is_no_student(look, tmp_path, folder):
    """Beside a student it may be anybody's, and what lies in it without a name is nobody's."""
    for names in ([f"{folder}/Ada/{HSL}", f"Ben/{HSL}"], [f"{folder}/{HSL}", f"Ben/{HSL}"]):
        found = look(packed(tmp_path / "in.zip", dict.fromkeys(names, NOTEBOOK)))
        assert who(found) == [("Ben", HSL[:-6])]
        assert found.not_graded[0].startswith(f"{folder}: it is named after a lesson") or "no student" in str(
            found.not_graded
        )
    weeks = look(packed(tmp_path / "weeks.zip", {f"week 1/{HSL}": NOTEBOOK, f"week 2/old/{HSL}": NOTEBOOK}))
    assert not weeks.submissions and len(weeks.not_graded) == 2
    own = look(
        packed(tmp_path / "own.zip", {f"Ada/week 1/{HSL}": NOTEBOOK, f"Ada/{folder}/x {HSL}": NOTEBOOK})
    )
    assert who(own) == [("Ada", HSL[:-6])]


@pytest.mark.parametrize("suffix", ["7z", "rar", "tar.gz", "TGZ"])
def test_an_archive_that_is_no_zip_is_refused_by_its_name_with_what_to_do(look, tmp_path, suffix):
    names = [f"ada/01_hsl_filtering.{suffix}", f"ben/work.{suffix}", f"cid_01_hsl_filtering.{suffix}"]
    path = put(tmp_path / "in", *names, content=b"7z")
    put(tmp_path / "in", f"ada/old {HSL}", f"dan/{HSL}", f"dan/data.{suffix}")
    found = gather(path, tmp_path / "scratch", LESSONS, ["01_hsl_filtering"])
    assert who(found) == [("ada", HSL[:-6]), ("dan", HSL[:-6])]
    lines = {each.file: each.reason for each in found.refused}
    lines |= dict(line.split(": ", 1) for line in found.not_graded)
    assert sorted(lines) == names[1:]
    assert all("archive, and only zips are opened. Unpack it" in line for line in lines.values())
    assert names[0] in found.submissions[0].notes[0]  # it does not count before a notebook that can be read


def test_a_folder_of_several_students_in_a_wrapper_is_no_student(look, tmp_path):
    groups = [f"class/monday/Ada/{HSL}", f"class/monday/Ben/{HSL}", f"class/Cleo/{HSL}"]
    found = look(put(tmp_path / "in", *groups))
    assert who(found) == [("Cleo", HSL[:-6])] and found.wrapper == "class"
    assert found.not_graded[0].startswith("monday: it holds the work of several students (Ada, Ben)")
    groups = [*groups[:2], "class/tuesday/Cleo/02_goal_posts.ipynb", "stray.txt"]
    found = look(put(tmp_path / "in2", *groups))
    assert not found.submissions and found.not_graded[0].startswith("class: it holds the work of several")


def test_an_empty_folder_beside_an_inner_wrapper_is_named(look, tmp_path):
    files = {f"a/b/Ada/{HSL}": NOTEBOOK, f"a/b/Ben/{HSL}": NOTEBOOK, "a/gil/": b""}
    found = look(packed(tmp_path / "in.zip", files))
    assert len(found.submissions) == 2 and found.not_graded == ("gil: there is no notebook of a lesson",)


# --- hostile ---


def test_a_broken_zip_of_which_the_lesson_is_known_is_refused_and_else_reported(look, tmp_path):
    put(tmp_path / "in", "ada/work.zip", content=b"PK")
    assert look(tmp_path / "in").unknown[0].startswith("ada/work.zip: it is no zip")
    found = gather(tmp_path / "in", tmp_path, LESSONS, ["01_hsl_filtering"])
    assert "no zip" in reasons(found)["ada", "01_hsl_filtering"]


@pytest.mark.parametrize("path", ["nothing", "in.zip"])
def test_what_is_no_folder_and_no_zip_is_said(tmp_path, path):
    (tmp_path / "in.zip").write_bytes(b"no zip")
    with pytest.raises(ValueError, match="a folder of submissions or a zip of them"):
        gather(tmp_path / path, tmp_path, LESSONS)


# --- students' names ---


@posix
def test_a_file_name_that_is_no_text_is_a_student_like_others(look, tmp_path):
    folder = os.fsencode(tmp_path / "in") + b"/\xff\xfe"
    try:
        os.makedirs(folder)
    except OSError:
        pytest.skip("this file system takes no such names")
    Path(os.fsdecode(folder), HSL).write_bytes(NOTEBOOK)
    ((student, _),) = who(look(tmp_path / "in"))
    assert student.encode() == b"\\xff\\xfe"
