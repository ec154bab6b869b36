"""What students hand in is found whatever a platform made of its name, and none of it is trusted."""

import json
import os
import random
import re
import shutil
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
from nao_course.instructor.collecting.roster import Roster
from nao_course.instructor.collecting.submissions import Submission, gather, of_lessons
from tests.handed_in import HSL, LESSONS, NOTEBOOK, answered, packed, posix, put, reasons, who
from tests.paths import PROJECT


def test_lateness_and_the_time_of_a_receipt_are_kept(look, tmp_path):
    put(tmp_path / "work", HSL)
    receipt = homework.submit(tmp_path / "work", tmp_path)
    zipped = "eve_LATE_3_13_submission-20261120-120000.zip"
    names = (f"ada_LATE_1_11_{HSL}", f"ben_2_12_{HSL}", f"Zed_4_assignsubmission_file_/{HSL}")
    files = dict.fromkeys(names, NOTEBOOK) | {zipped: receipt.path.read_bytes()}
    found = {each.student: each for each in look(packed(tmp_path / "in.zip", files)).submissions}
    late = {"ada_1": True, "ben_2": False, "eve_3": True, "Zed_4": False}
    assert {name: each.late for name, each in found.items()} == late
    told = datetime.fromisoformat(found.pop("eve_3").handed_in)
    assert told == datetime.fromisoformat(receipt.time).replace(second=0, microsecond=0)
    assert {each.handed_in for each in found.values()} == {""}


STAMPED = b'{"cells": [], "metadata": {"nao_course": {"lesson": "01_hsl_filtering", "version": "1"}}, "nbformat": 4}'
CLAIMED = json.dumps(
    {"cells": [{"source": '"nao_course": {"lesson": "01_hsl_filtering"}'}], "metadata": {}}
).encode()
ONLY_01 = ["01_hsl_filtering"]


@pytest.mark.parametrize("name", ["ada/homework1.ipynb", "ada_1_assignsubmission_file_/homework1.ipynb"])
def test_a_notebook_of_another_name_counts_where_its_metadata_name_the_only_wanted_lesson(tmp_path, name):
    put(tmp_path / "in", name, content=STAMPED)
    (one,) = gather(tmp_path / "in", tmp_path / "s", LESSONS, ONLY_01).submissions
    assert one.lesson == "01_hsl_filtering"
    assert one.notes == (f"{name} counts as 01_hsl_filtering, because its metadata name that lesson",)
    others = [NOTEBOOK, CLAIMED, STAMPED + STAMPED.replace(b"01_hsl", b"02_hsl"), b""]
    wanted = [(STAMPED, each) for each in (None, ["02_goal_posts"], [*ONLY_01, "02_goal_posts"])]
    for content, lessons in [*wanted, *((each, ONLY_01) for each in others)]:
        put(tmp_path / "in", name, content=content)
        found = gather(tmp_path / "in", tmp_path / "s", LESSONS, lessons)
        assert found.submissions == () and "named after no lesson" in found.not_graded[0]


def test_a_notebook_with_the_lessons_name_counts_before_a_newer_one_without(tmp_path):
    put(tmp_path / "in", f"ada/{HSL}", "ada/homework1.ipynb", content=STAMPED)
    os.utime(tmp_path / "in" / "ada" / HSL, (1, 1))
    (one,) = gather(tmp_path / "in", tmp_path / "s", LESSONS, ONLY_01).submissions
    assert one.file == f"ada/{HSL}"
    assert one.notes == ("ada/homework1.ipynb does not count: another one has the lesson's name",)


@pytest.mark.parametrize("text", ["onlinetext_/onlinetext.html", "onlinetext_onlinetext.html"])
def test_what_a_student_typed_into_moodles_text_field_is_no_alarm(look, tmp_path, text):
    start = "Ada_1_assignsubmission_"
    for content in (b"", b"<p>Dear Sir</p>"):
        typed = {f"{start}{text}": content}
        found = look(packed(tmp_path / "in.zip", {f"{start}file_/{HSL}": NOTEBOOK} | typed))
        assert who(found) == [("Ada_1", "01_hsl_filtering")] and found.unknown == ()
        alone = look(packed(tmp_path / "other.zip", typed))
        assert alone.not_graded == ("Ada_1: there is no notebook of a lesson",)


def test_another_notebook_is_called_newer_only_where_it_is(look, tmp_path):
    names = (f"ada/{HSL}", "ada/01_hsl_filtering (1).ipynb")
    put(tmp_path / "in", *names)
    for times, which in (((2, 1), "is newer"), ((2, 2), "counts")):
        for name, time in zip(names, times, strict=True):
            os.utime(tmp_path / "in" / name, (time, time))
        notes = look(tmp_path / "in").submissions[0].notes
        assert notes == (f"{names[1]} does not count: another one {which}",)
    # The times in Moodle's zip are those of the download.
    start, path = "Ada_1_assignsubmission_file_", tmp_path / "in.zip"
    with zipfile.ZipFile(path, "w") as archive:
        for second, name in enumerate((f"{start}/a/{HSL}", f"{start}/b/{HSL}")):
            archive.writestr(zipfile.ZipInfo(name, (2026, 3, 1, 12, 0, 2 * second)), NOTEBOOK)
    assert look(path).submissions[0].notes == (f"{start}/a/{HSL} does not count: another one counts",)


def test_what_is_named_after_nothing_is_reported_by_its_name(look, tmp_path):
    lost = [HSL, "ada/essay.pdf", "ada/homework.ipynb", "stray.ipynb"]
    found = look(put(tmp_path / "in", *lost, f"ada/{HSL}"))
    assert who(found) == [("ada", "01_hsl_filtering")]
    assert sorted(each.split(":")[0] for each in found.unknown) == lost


def test_all_lessons_of_all_students_come_in_order_whatever_the_folders_order(look, tmp_path):
    names = [f"{student}/{lesson}.ipynb" for student in ("b", "a", "c") for lesson in LESSONS]
    random.Random(1).shuffle(names)
    found = look(put(tmp_path / "in", *names))
    assert who(found) == [(student, lesson) for student in "abc" for lesson in LESSONS]
    chosen = gather(tmp_path / "in", tmp_path, LESSONS, ["02_goal_posts"])
    assert who(chosen) == [(student, "02_goal_posts") for student in "abc"] and chosen.unknown == ()
    put(tmp_path / "in", "d/01_hsl_filtering.ipynb", content=b"")
    everything = of_lessons(gather(tmp_path / "in", tmp_path, LESSONS), LESSONS)
    assert [each.student for each in everything] == [*"aaabbbccc", "d"]


def test_two_students_of_one_name_or_in_other_case_stay_two(look, tmp_path):
    folders = [f"Ada_{number}_assignsubmission_file_" for number in (1, 2)] + ["bob", "Bob"]
    files = {f"{folder}/{HSL}": NOTEBOOK for folder in folders}
    students = [student for student, _ in who(look(packed(tmp_path / "in.zip", files)))]
    assert students == ["Ada_1", "Ada_2", "Bob", "bob"]
    assert len({safe_name(each).lower() for each in students}) == 4


@pytest.mark.parametrize("kind", ["folder", "zip"])
def test_one_folder_around_all_students_is_taken_away_and_a_students_own_is_not(look, tmp_path, kind):
    alone, three = "Ada Lovelace_1234567_assignsubmission_file_", ["ada", "bob", "cleo"]
    for number, (names, expected) in enumerate(
        [
            ([f"wrapper/{student}/{HSL}" for student in three], three),
            ([f"{alone}/eve/{HSL}", f"{alone}/bob/{HSL}"], ["Ada Lovelace_1234567"]),
            (["ada/week 1/00_meet_the_nao.ipynb", f"ada/week 2/{HSL}"], ["ada", "ada"]),
            ([f"ada/{HSL}", f"ada/old/{HSL}"], ["ada"]),
        ]
    ):
        path = tmp_path / f"in{number}"
        files = dict.fromkeys(names, NOTEBOOK)
        path = put(path, *names) if kind == "folder" else packed(path.with_suffix(".zip"), files)
        assert [student for student, _ in who(look(path))] == expected
    put(tmp_path / "one", f"submission/a/{HSL}", f"submission/b/{HSL}")
    found = gather(tmp_path / "one", tmp_path / "scratch", LESSONS, one_student=True)
    assert who(found) == [("submission", HSL[:-6])]


def test_a_student_may_be_called_as_programs_call_folders_and_their_own_are_nobodys(look, tmp_path):
    for student in ("release", "kept", "__pycache__", ".x"):
        name = f"{student}/{HSL}"
        for path in (put(tmp_path / student, name), packed(tmp_path / "in.zip", {name: NOTEBOOK})):
            assert who(look(path)) == [(student, "01_hsl_filtering")]
    left = [".git/config", ".ipynb_checkpoints/stray.ipynb", "__MACOSX/ada/._x.ipynb", ".DS_Store"]
    found = look(put(tmp_path / "in", f"ada/{HSL}", *left))
    assert who(found) == [("ada", "01_hsl_filtering")] and found.unknown == ()
    files = {f"ada/{HSL}": NOTEBOOK} | dict.fromkeys(left, b"x")
    assert look(packed(tmp_path / "in.zip", files)).unknown == ()


def test_students_whose_names_look_alike_are_refused_and_neither_has_the_others_work(look, tmp_path):
    names = [f"{student}/{HSL}" for student in ("Ada", "Ada ", "M\u00fcller", "Mu\u0308ller", "bob")]
    found = look(packed(tmp_path / "in.zip", dict.fromkeys(names, NOTEBOOK)))
    assert who(found) == [("bob", "01_hsl_filtering")]
    assert {student for student, _ in reasons(found)} == {"Ada", "Müller"}
    assert all("names that are too similar" in reason for reason in reasons(found).values())


def test_whoever_is_not_graded_is_named_before_what_nobody_misses(look, tmp_path):
    named = ["bob/mine.py", "cleo/essay.pdf", "dan/kept/01_hsl_filtering.ipynb", "eve/work.ipynb"]
    put(tmp_path / "in", f"ada/{HSL}", *named, *(f"ada/junk{number}.txt" for number in range(25)))
    (tmp_path / "in" / "fay").mkdir()
    found = look(tmp_path / "in")
    assert [re.split("[/:]", each)[0] for each in found.not_graded] == ["eve", "bob", "cleo", "dan", "fay"]
    assert found.unknown[:5] == found.not_graded and len(found.unknown) == 5 + 26


def test_a_student_with_many_lost_files_hides_nobody(look, tmp_path):
    put(tmp_path / "in", *(f"ada/{number:02}.zip" for number in range(40)), "bob/essay.pdf", content=b"")
    found = look(put(tmp_path / "in", "zoe/work.ipynb", "zoe/more.ipynb"))
    first = ["ada/00.zip", "zoe/more.ipynb", "bob", "ada/01.zip"]
    assert [each.partition(": ")[0] for each in found.not_graded[:4]] == first


def test_a_file_beside_the_students_folders_that_may_be_somebodys_work_is_named_as_not_graded(look, tmp_path):
    spoiled = ("", ".ipynb.txt", ".ipynb.download", ".ipynb.bak", ".zip.part", ".ipynb.json")
    named = [f"s{at}_01_hsl_filtering{suffix}" for at, suffix in enumerate(spoiled)]
    put(tmp_path / "in", f"ada/{HSL}", "marks.xlsx", "READ_ME", *named)
    found = look(tmp_path / "in")
    assert [each.partition(": ")[0] for each in found.not_graded] == named
    assert {each.partition(": ")[2] for each in found.not_graded} == {"it is no notebook"}
    assert [each.partition(": ")[0] for each in found.unknown[len(named) :]] == ["READ_ME", "marks.xlsx"]


@posix
def test_a_link_or_a_file_that_went_away_is_named_as_not_graded(look, tmp_path):
    put(tmp_path / "in", f"ada/{HSL}")
    (tmp_path / "in" / "ben").symlink_to(tmp_path / "in" / "ada")
    (tmp_path / "in" / "cleo").symlink_to("nowhere")
    reason = "it is a symbolic link, not a file or folder"
    assert look(tmp_path / "in").not_graded == (f"ben: {reason}", f"cleo: {reason}")
    with pytest.raises(Refused, match="^it was removed or renamed while the grader was running$"):
        read(Submission("ada", LESSONS[1], tmp_path / "gone.ipynb"))


def test_what_submit_packs_is_taken_and_the_later_receipt_counts(look, tmp_path):
    put(tmp_path / "work", HSL, "helper.py", content=NOTEBOOK)
    receipt = homework.submit(tmp_path / "work", tmp_path / "in" / "ada")
    old = {HSL: b"old", "receipt.json": json.dumps({"time": "2020-01-01T12:00:00+00:00"}).encode()}
    early = packed(tmp_path / "in" / "ada" / "submission-20200101-120000.zip", old)
    os.utime(receipt.path, (1e9, 1e9))  # copied about: the file's time says nothing
    os.utime(early, (2e9, 2e9))
    (found,) = look(tmp_path / "in").submissions
    assert read(found).notebook == NOTEBOOK and list(read(found).helpers) == ["helper.py"]
    assert found.file.startswith(f"ada/{receipt.path.name}/")


TIMES = ("0001-01-01T00:00:00+14:00", "9999-12-31T23:59:59.999999+00:00", "1999-01-01T00:00:00+00:00")
TIMES += ("2026-11-20T23:59:00", "2026-11-20", "soon", 7, None)


@pytest.mark.parametrize(
    "receipt",
    [
        *(b"", b"[" * 60000, b"\xff", b"x" * 10**6, b"[7]"),
        *(json.dumps({"versions": ["numpy"], "time": time}).encode() for time in TIMES),
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
        contents = {name: answered((turn + at) % 3 + 1) for at, name in enumerate(names)}
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


def test_zips_of_students_are_looked_into_wherever_they_are(look, tmp_path):
    inner = packed(tmp_path / "inner.zip", {HSL: NOTEBOOK}).read_bytes()
    for name, student in {
        "ada_{}.zip": "ada",
        "ada/{}.zip": "ada",
        "lovelaceada_LATE_12_34_{}-1.zip": "lovelaceada_12",
        "Ada L_12_assignsubmission_file_/{}.zip": "Ada L_12",
    }.items():
        file = name.format("submission-20260301-120000")
        for path in (
            put(tmp_path / name[:9], file, content=inner),
            packed(tmp_path / "in.zip", {file: inner}),
        ):
            assert who(look(path)) == [(student, "01_hsl_filtering")]


def test_helpers_come_along_by_the_name_they_are_imported_by_and_no_more_than_are_needed(look, tmp_path):
    put(tmp_path / "in", f"ada/{HSL}", "ada/mine.py", "bob/other.py", f"bob/sub/{HSL}", "ada/not-a-module.py")
    ada, bob = look(tmp_path / "in").submissions
    assert [name for name, _ in ada.helpers] == ["mine.py"]
    assert bob.helpers == ()  # it lies elsewhere
    names = ["x_1_20_01_hsl_filtering.ipynb", "x_1_21_mine.py", "y_2_22_mine.py"]
    (found,) = look(packed(tmp_path / "in.zip", dict.fromkeys(names, NOTEBOOK))).submissions
    assert [name for name, _ in found.helpers] == ["mine.py"]
    put(tmp_path / "many", f"ada/{HSL}", *(f"ada/m{number}.py" for number in range(30)))
    put(tmp_path / "many", "ada/big.py", content=b"#" * (submissions.LARGEST_HELPER + 1))
    (found,) = look(tmp_path / "many").submissions
    assert len(found.helpers) == submissions.MOST_HELPERS and len(found.notes) == 11


def test_the_hash_is_of_all_that_was_handed_in(tmp_path):
    put(tmp_path, "a.ipynb", "h.py", "earlier.ipynb")
    plain = Submission("ada", LESSONS[1], tmp_path / "a.ipynb")
    helped, renamed = (replace(plain, helpers=((name, tmp_path / "h.py"),)) for name in ("h.py", "g.py"))
    after = replace(plain, earlier=(Submission("ada", LESSONS[0], tmp_path / "earlier.ipynb"),))
    hashes = [read(each).hash for each in (plain, helped, renamed, after)]
    put(tmp_path, "h.py", "earlier.ipynb", content=b"other")
    assert len({*hashes, read(helped).hash, read(after).hash}) == 6
    assert read(plain).hash == hashes[0]


def test_who_handed_in_nothing_that_counts_is_named_however_the_platform_packs_it(look, tmp_path):
    empty = [{}, {f"release/{HSL}": NOTEBOOK, f"kept/{HSL}": NOTEBOOK}, {"essay.pdf": b"x"}]
    for at, files in enumerate([*empty, {f"__MACOSX/{HSL}": b"x", ".x/y.ipynb": b"x"}]):
        content = packed(tmp_path / "packed.zip", files).read_bytes()
        for name in (
            f"s{at}_{at}_9_work.zip",
            f"S{at}_{at}_assignsubmission_file_work.zip",
            f"s{at}/work.zip",
        ):
            place = put(tmp_path / f"in{at}-{len(name)}", f"ada/{HSL}")
            found = look(put(place, name, content=content))
            assert who(found) == [("ada", HSL[:-6])]
            assert len(found.not_graded) == 1 and found.not_graded[0].startswith(name), found
    found = look(put(tmp_path / "in", f"x_1_2_{HSL}", "y_3_4_essay.pdf"))
    assert found.not_graded == ("y_3: there is no notebook of a lesson",)


@pytest.mark.parametrize(
    ("files", "lost"),
    [
        ([f"Ada_1_assignsubmission_file_/{HSL}", "Gil_7_assignsubmission_file_/"], "Gil_7"),
        ([f"ada/{HSL}", "ada/", "hal/sub/"], "hal"),
        ([f"a/b/Ada/{HSL}", f"a/b/Ben/{HSL}", "a/gil/"], "gil"),
    ],
)
def test_an_empty_folder_in_a_zip_names_its_student(look, tmp_path, files, lost):
    contents = {name: b"" if name.endswith("/") else NOTEBOOK for name in files}
    found = look(packed(tmp_path / "in.zip", contents))
    assert len(found.submissions) == sum(name.endswith(HSL) for name in files)
    assert found.not_graded == (f"{lost}: there is no notebook of a lesson",)


OF_OTHER_LESSONS = [f"{name}.ipynb" for name in ("ben/02_goal_posts", "02_goal_posts", "dan/02_goal_posts")]
OF_OTHER_LESSONS += ["cleo/02_goal_posts.zip", "eve_02_goal_posts.rar", "Fay 03-04-2026_02_goal_posts.ipynb"]
OF_OTHER_LESSONS += [f"gil/02_goal_posts_{name}.ipynb" for name in "ab"]
OF_OTHER_LESSONS += ["jil/02_goal_posts.ipynb.txt", "02_goal_posts/hal/02_goal_posts.ipynb"]


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
    def gathered(*names, **known):
        folder = put(tmp_path / str(len(list(tmp_path.iterdir()))), *names)
        found = gather(folder, tmp_path / "scratch", LESSONS, **known)
        shutil.rmtree(tmp_path / "scratch", ignore_errors=True)
        return [student for student, _ in who(found)], found.wrapper, found.not_graded

    for own in ("Eve", "eve"):
        students, _, (line, *_) = gathered(f"Eve/Ada/{HSL}", f"Eve/{own}/{HSL}")
        assert not students and line.startswith("Eve: it holds the work of several students")
    both = (f"Eve/Ada/{HSL}", f"Eve/Bob/{HSL}")
    assert gathered(*both, known=Roster.of({"Ada", "Eve"}))[:2] == (["Eve"], "")
    assert gathered(*both, known=Roster.of({"Ada", "Bob"}))[:2] == (["Ada", "Bob"], "Eve")
    assert not gathered(f"eve/Ada/{HSL}", f"eve/Ben/{HSL}", known=Roster.of({"Eve"}))[1]


@pytest.mark.parametrize(
    "names",
    [
        [f"class/{student}/{HSL}" for student in ("Ada", "Ben", "Zoe")],
        [f"late/Ben_7_assignsubmission_file_/{HSL}"],
        [f"late/Ben_7_assignsubmission_file_{HSL}"],
        [f"canvas/ben_1_2_{HSL}", f"canvas/zoe_3_4_{HSL}"],
        ["class/Ada/work.zip", f"class/Ben/{HSL}"],
        [f"class/Ada_{HSL}", f"class/Ben_{HSL}"],
        [f"a/b/Ada/{HSL}", f"a/b/Ben/{HSL}"],
        [f"late/ben_2_22_{HSL}"],
        [f"class/Ada_{HSL[:-6]}.zip", f"class/Ben_{HSL[:-6]}.zip"],
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
@pytest.mark.parametrize("folder", ["class", "class/monday"])
def test_plain_zips_of_one_lesson_in_a_folder_are_not_graded_as_one_student(look, tmp_path, folder, beside):
    inner = packed(tmp_path / "inner.zip", {HSL: NOTEBOOK}).read_bytes()

    def zips(name):
        files = {name.format(student): inner for student in ("Ada", "Ben")}
        return look(packed(tmp_path / "in.zip", files | beside))

    carl = [("Carl", HSL[:-6])] if f"Carl/{HSL}" in beside else []
    found = zips(f"{folder}/{{}}.zip")
    assert who(found) == carl
    assert found.not_graded == (
        f"{folder}: it holds the work of several students (Ada, Ben), not of one. "
        "Put each zip into a folder that is named after its student",
    )
    assert who(zips("{0}/{0}.zip")) == sorted([("Ada", HSL[:-6]), ("Ben", HSL[:-6]), *carl])
    moodles = who(zips("Eve_7_assignsubmission_file_/{}.zip"))
    assert ("Eve_7", HSL[:-6]) in moodles and len(moodles) == 1 + len(carl)


@pytest.mark.parametrize("name", ["late_01_hsl_filtering.zip", "late/moodle.zip"])
def test_a_zip_of_several_students_is_no_student(look, tmp_path, name):
    for folder in ("{}", "{}_7_assignsubmission_file_"):
        files = {f"{folder.format(student)}/{HSL}": NOTEBOOK for student in ("Ada", "Ben")}
        inner = packed(tmp_path / "inner.zip", files).read_bytes()
        found = look(packed(tmp_path / "in.zip", {name: inner, f"Cleo/{HSL}": NOTEBOOK}))
        assert who(found) == [("Cleo", HSL[:-6])] and "several students" in found.not_graded[0]


OWN_COPIES = [
    [f"old/{HSL}", f"new/{HSL}"],
    [f"nao/v1/{HSL}", f"nao/v2/{HSL}"],
    [HSL, f"backup/{HSL}"],
    [f"my_{HSL}", f"old_{HSL}"],
    [f"ada_{HSL}", f"Ada Lovelace_{HSL}"],
    [f"mueller_123456_{HSL}"],
    [f"ada_123456_1234567_{HSL}"],
    ["lesson 0/a.zip", "lesson 1/b.zip"],
    ["00.zip", "01.zip"],
    ["Ada.zip", "homework.zip", "submission-20260301-120000.zip", "hsl.zip"],
]


@pytest.mark.parametrize("names", OWN_COPIES)
def test_copies_in_a_students_own_folder_are_that_students(look, tmp_path, names):
    inner = packed(tmp_path / "inner.zip", {HSL: NOTEBOOK}).read_bytes()
    own = {name: inner if name.endswith(".zip") else NOTEBOOK for name in names}
    files = {f"Ada/{name}": content for name, content in own.items()}
    for beside in ({}, {f"Ben/{HSL}": NOTEBOOK}):  # also the only student of a class
        found = look(packed(tmp_path / "in.zip", files | beside))
        assert [student for student, _ in who(found)] == ["Ada", "Ben"][: len(beside) + 1]
        assert not found.not_graded and not found.wrapper
    if inner not in own.values():
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
    files = {"readme.txt": b"", f"{first}/Ben_{HSL}": NOTEBOOK}
    files[f"{first}/Eve_7_assignsubmission_file_/{HSL}"] = b"{}"
    for folder, lesson in ((first, HSL), (second, "02_goal_posts.ipynb")):
        files |= {f"{folder}/Ada/{lesson}": NOTEBOOK, f"{folder}/Ada/mine.py": folder.encode()}
    path = packed(tmp_path / "in.zip", files)
    if kind == "folder":
        zipfile.ZipFile(path).extractall(path := tmp_path / "in")
    found = look(path)
    assert who(found) == [("Ada", HSL[:-6]), ("Ada", "02_goal_posts"), ("Ben", HSL[:-6]), ("Eve_7", HSL[:-6])]
    assert not found.not_graded and not found.wrapper
    helpers = [dict(read(each).helpers) for each in found.submissions[:2]]
    assert helpers == [{"mine.py": folder.encode()} for folder in (first, second)]
    alone = look(packed(tmp_path / "alone.zip", {f"{first}/Ada/{HSL}": NOTEBOOK}))
    assert who(alone) == [("Ada", HSL[:-6])] and alone.wrapper == first


@pytest.mark.parametrize("folder", [HSL[:-6], "Lesson 01", "week1"])
def test_a_folder_of_a_lesson_is_no_student(look, tmp_path, folder):
    """Beside a student it may be anybody's, and what lies in it without a name is nobody's."""

    def students(*names):
        found = look(packed(tmp_path / "in.zip", dict.fromkeys(names, NOTEBOOK)))
        return [student for student, _ in who(found)], found.not_graded

    for name in (f"Ada/{HSL}", HSL):
        found, (line, *_) = students(f"{folder}/{name}", f"Ben/{HSL}")
        assert found == ["Ben"] and line.startswith(f"{folder}: it is named after a lesson")
    found, lines = students(f"week 1/{HSL}", f"week 2/old/{HSL}")
    assert not found and len(lines) == 2
    assert students(f"Ada/week 1/{HSL}", f"Ada/{folder}/x {HSL}")[0] == ["Ada"]


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


def test_a_broken_zip_of_which_the_lesson_is_known_is_refused_and_else_reported(look, tmp_path):
    put(tmp_path / "in", "ada/work.zip", content=b"PK")
    assert look(tmp_path / "in").unknown[0].startswith("ada/work.zip: it is no zip")
    found = gather(tmp_path / "in", tmp_path, LESSONS, ["01_hsl_filtering"])
    assert "no zip" in reasons(found)["ada", "01_hsl_filtering"]
    for path in ("nothing", "in/ada/work.zip"):
        with pytest.raises(ValueError, match="a folder of submissions or a zip of them"):
            gather(tmp_path / path, tmp_path, LESSONS)


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
