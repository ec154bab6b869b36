"""What students hand in is found whatever a platform made of its name, and none of it is trusted."""

import json
import os
import random
import stat
import struct
import sys
import tempfile
import zipfile
import zlib
from pathlib import Path

import pytest

from nao_course import homework
from nao_course.instructor.collecting import archives, submissions
from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.names import LONGEST_NAME, clean_name, lesson_of, safe_name
from nao_course.instructor.collecting.submissions import Submission, gather, of_lessons, read

LESSONS = ["00_meet_the_nao", "01_hsl_filtering", "02_goal_posts"]
HSL = "01_hsl_filtering.ipynb"
NOTEBOOK = b'{"cells": [], "metadata": {}, "nbformat": 4, "nbformat_minor": 5}'
posix = pytest.mark.skipif(sys.platform == "win32", reason="links, pipes and modes of POSIX")


def put(root: Path, *names: str, content: bytes = NOTEBOOK) -> Path:
    for name in names:
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return root


def packed(path: Path, files: dict[str, bytes], **options) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, options.get("date", (2026, 3, 1, 12, 0, 0)))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = options.get("mode", 0o100644) << 16
            archive.writestr(entry, content)
    return path


@pytest.fixture
def look(tmp_path):
    """Gather, and see that nothing is written outside of the scratch folder."""

    def gathered(path, lessons=LESSONS):
        scratch = Path(tempfile.mkdtemp(prefix="scratch", dir=tmp_path))
        before = {each for each in tmp_path.rglob("*") if scratch not in each.parents}
        found = gather(path, scratch, lessons)
        assert {each for each in tmp_path.rglob("*") if scratch not in each.parents} == before
        for submission in found.submissions:
            assert read(submission).notebook
        return found

    return gathered


def who(found):
    return [(each.student, each.lesson) for each in found.submissions]


def reasons(found):
    return {(each.student, each.lesson): each.reason for each in found.refused}


# --- names ---


@pytest.mark.parametrize(
    ("name", "student"),
    [
        ("ada/01_hsl_filtering.ipynb", "ada"),
        ("ada/week 1/01_hsl_filtering.ipynb", "ada"),
        ("ada_01_hsl_filtering.ipynb", "ada"),
        ("ada_lovelace_01_hsl_filtering (1).ipynb", "ada_lovelace"),
        ("Ada Lovelace_1234567_assignsubmission_file_/01_hsl_filtering.ipynb", "Ada Lovelace_1234567"),
        ("Ada Lovelace_1234567_assignsubmission_file/01_hsl_filtering.ipynb", "Ada Lovelace_1234567"),
        ("Ada Lovelace_1234567_assignsubmission_file_01_hsl_filtering.ipynb", "Ada Lovelace_1234567"),
        ("lovelaceada_123456_7890123_01_hsl_filtering.ipynb", "lovelaceada_123456"),
        ("lovelaceada_LATE_123456_7890123_01_hsl_filtering-2.ipynb", "lovelaceada_123456"),
    ],
)
@pytest.mark.parametrize("kind", ["folder", "zip"])
def test_each_platforms_names_are_understood(look, tmp_path, name, student, kind):
    folder = kind == "folder"
    path = put(tmp_path / "in", name) if folder else packed(tmp_path / "in.zip", {name: NOTEBOOK})
    found = look(path)
    assert who(found) == [(student, "01_hsl_filtering")]
    assert (found.refused, found.unknown) == ((), ())
    assert found.submissions[0].file == name


@pytest.mark.parametrize(
    "name",
    [
        "01_hsl_filtering.ipynb",
        "01_hsl_filtering (1).ipynb",
        "01_hsl_filtering(12).ipynb",
        "01_hsl_filtering-2.ipynb",
        "01_hsl_filtering_copy.ipynb",
        "01_hsl_filtering-Copy1.ipynb",
        "01_HSL_Filtering.IPYNB",
        "01-hsl-filtering.ipynb",
        "01 hsl filtering v2.ipynb",
        "ada_01_hsl_filtering.ipynb",
    ],
)
def test_a_lesson_is_known_by_its_name_whatever_a_browser_added(name):
    assert lesson_of(name, LESSONS) == "01_hsl_filtering"


@pytest.mark.parametrize(
    "name", ["homework.ipynb", "101_hsl_filtering.ipynb", "01_hsl_filtering_old_stuff.ipynb", "01.ipynb", ""]
)
def test_a_file_that_is_named_after_no_lesson_is_of_none(name):
    assert lesson_of(name, LESSONS) == ""


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


def test_a_zip_of_the_whole_folder_is_looked_into(look, tmp_path):
    files = {f"submissions/{student}/{HSL}": NOTEBOOK for student in ("ada", "bob")}
    assert [student for student, _ in who(look(packed(tmp_path / "in.zip", files)))] == ["ada", "bob"]


# --- which one counts ---


def test_the_newest_counts_and_the_others_are_named(look, tmp_path):
    path = put(tmp_path / "in", "ada/old/01_hsl_filtering.ipynb", "ada/01_hsl_filtering (1).ipynb")
    os.utime(path / "ada/old/01_hsl_filtering.ipynb", (2e9, 2e9))
    os.utime(path / "ada/01_hsl_filtering (1).ipynb", (1e9, 1e9))
    (found,) = look(path).submissions
    assert found.file == "ada/old/01_hsl_filtering.ipynb"
    assert found.notes == ("ada/01_hsl_filtering (1).ipynb does not count: another one is newer",)


def test_canvas_counts_how_often_it_was_handed_in(look, tmp_path):
    names = [
        "x_1_20_01_hsl_filtering.ipynb",
        "x_1_19_01_hsl_filtering-2.ipynb",
        "x_1_21_01_hsl_filtering-1.ipynb",
    ]
    (found,) = look(packed(tmp_path / "in.zip", dict.fromkeys(names, NOTEBOOK))).submissions
    assert found.file == names[1]
    assert len(found.notes) == 2


def test_a_newer_one_that_cannot_be_taken_does_not_take_the_place_of_an_older_one(look, tmp_path):
    path = put(tmp_path / "in", f"ada/{HSL}")
    os.utime(path / "ada" / HSL, (1e9, 1e9))
    put(path, "ada/01_hsl_filtering (1).ipynb", content=b"")
    found = look(path)
    assert found.submissions[0].notes == ("ada/01_hsl_filtering (1).ipynb does not count: it is empty",)


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


@pytest.mark.parametrize(
    "receipt", [b"", b"[" * 60000, b'{"time": 7}', b'{"time": "soon"}', b"\xff", b"x" * 10**6]
)
def test_a_broken_receipt_harms_nobody(look, tmp_path, receipt):
    packed(tmp_path / "in" / "ada" / "submission.zip", {HSL: NOTEBOOK, "receipt.json": receipt})
    assert who(look(tmp_path / "in")) == [("ada", "01_hsl_filtering")]


@pytest.mark.parametrize(
    ("name", "student"),
    [
        ("submission-20260301-120000.zip", "submission-20260301-120000"),
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


# --- hostile ---


@posix
def test_what_is_no_plain_file_is_refused_with_its_reason(look, tmp_path):
    root = tmp_path / "in"
    (tmp_path / "secret").write_bytes(b"secret")
    for student in ("link", "pipe", "folder", "empty"):
        (root / student).mkdir(parents=True)
    (root / "link" / HSL).symlink_to(tmp_path / "secret")
    os.mkfifo(root / "pipe" / HSL)
    (root / "folder" / HSL).mkdir()
    (root / "empty" / HSL).touch()
    (root / "linked").symlink_to(tmp_path)
    found = look(root)
    assert found.submissions == ()
    assert {student: reason for (student, _), reason in reasons(found).items()} == {
        "link": "it is a symbolic link, not a file",
        "pipe": "it is a device or pipe, not a file",
        "folder": "it is a folder, not a notebook",
        "empty": "it is empty",
    }


@posix
def test_a_file_that_becomes_a_link_or_a_pipe_meanwhile_is_not_followed(tmp_path):
    (tmp_path / "secret").write_bytes(b"secret")
    (tmp_path / "link").symlink_to(tmp_path / "secret")
    os.mkfifo(tmp_path / "pipe")
    for name in ("link", "pipe", "gone"):
        with pytest.raises(Refused):
            read(Submission("ada", LESSONS[1], tmp_path / name))


@posix
@pytest.mark.skipif(hasattr(os, "geteuid") and os.geteuid() == 0, reason="nothing is unreadable for root")
def test_an_unreadable_file_is_refused(tmp_path):
    put(tmp_path, "a.ipynb")
    (tmp_path / "a.ipynb").chmod(0)
    with pytest.raises(Refused, match="cannot be read"):
        read(Submission("ada", LESSONS[1], tmp_path / "a.ipynb"))


def test_a_huge_notebook_is_refused_without_being_read(tmp_path):
    path = tmp_path / "in" / "ada" / HSL
    path.parent.mkdir(parents=True)
    with path.open("wb") as file:
        file.truncate(200 * 2**20)
    (found,) = gather(tmp_path / "in", tmp_path, LESSONS).submissions
    with pytest.raises(Refused, match="200.0 MB or more; 50 MB are the most"):
        read(found)


@pytest.mark.parametrize(
    "name", [f"../{HSL}", f"ada/../../{HSL}", f"/etc/{HSL}", f"C:\\ada\\{HSL}", f"ada\\..\\{HSL}"]
)
@pytest.mark.parametrize("inside", [True, False])
def test_names_that_lead_out_of_a_zip_lead_nowhere(look, tmp_path, name, inside):
    if inside:
        packed(tmp_path / "in" / "ada" / "my.zip", {name: NOTEBOOK})
        path = tmp_path / "in"
    else:
        path = packed(tmp_path / "in.zip", {name: NOTEBOOK})
    found = look(path)
    assert found.submissions == ()
    told = [*(each.reason for each in found.refused), *found.unknown]
    assert len(told) == 1
    if inside:
        assert reasons(found) == {("ada", "01_hsl_filtering"): "its name in the zip leads outside of it"}


def test_a_link_in_a_zip_is_refused(look, tmp_path):
    packed(tmp_path / "in" / "ada" / "my.zip", {HSL: b"/etc/passwd"}, mode=stat.S_IFLNK | 0o777)
    assert reasons(look(tmp_path / "in")) == {
        ("ada", "01_hsl_filtering"): "it is a symbolic link, not a file"
    }


def test_a_zip_bomb_is_refused_and_the_others_are_not(look, tmp_path):
    packed(tmp_path / "in" / "ada" / "my.zip", {HSL: bytes(40 * 2**20)})
    packed(tmp_path / "in" / "eve" / "my.zip", {HSL: bytes(60 * 2**20)})
    put(tmp_path / "in", f"bob/{HSL}")
    found = look(tmp_path / "in")
    assert who(found) == [("bob", "01_hsl_filtering")]
    assert all("zip bomb" in reason for reason in reasons(found).values())
    assert len(found.refused) == 2


def test_a_zip_that_lies_about_sizes_is_refused(look, tmp_path):
    content = bytes(archives.SMALL * 8)
    path = packed(tmp_path / "in" / "ada" / "my.zip", {HSL: content})
    data = bytearray(path.read_bytes())
    at = data.rfind(b"PK\1\2")
    data[at + 24 : at + 28] = struct.pack("<I", 1000)  # 1000 bytes, it says
    path.write_bytes(data)
    found = look(tmp_path / "in")
    assert found.submissions == ()
    assert "broken" in reasons(found)["ada", "01_hsl_filtering"]


def test_a_zip_within_a_zip_within_a_zip_is_not_opened(look, tmp_path):
    inner = packed(tmp_path / "1.zip", {HSL: NOTEBOOK}).read_bytes()
    outer = packed(tmp_path / "2.zip", {"1.zip": inner}).read_bytes()
    found = look(packed(tmp_path / "3.zip", {"ada/2.zip": outer}))
    assert found.submissions == ()
    assert found.unknown == ("ada/2.zip/1.zip: a zip within a zip is not opened",)


def test_a_zip_of_very_many_files_is_refused_before_its_contents_are_read(look, tmp_path, monkeypatch):
    with zipfile.ZipFile(tmp_path / "many.zip", "w") as archive:
        for number in range(archives.MOST_ENTRIES + 1):
            archive.writestr(str(number), b"")
    put(tmp_path / "in", "ada/01_hsl_filtering.zip", content=(tmp_path / "many.zip").read_bytes())
    monkeypatch.setattr(zipfile, "ZipFile", None)
    assert "more than 2000 files" in reasons(look(tmp_path / "in"))["ada", "01_hsl_filtering"]


def test_a_table_of_contents_larger_than_it_says_is_refused(look, tmp_path):
    path = packed(tmp_path / "in" / "ada" / "01_hsl_filtering.zip", {HSL: NOTEBOOK})
    data = bytearray(path.read_bytes())
    data[-10:-6] = struct.pack("<I", 2**31)
    path.write_bytes(data)
    assert who(look(tmp_path / "in")) == []


@pytest.mark.parametrize("seed", range(30))
def test_no_broken_zip_is_more_than_a_reason(look, tmp_path, seed):
    chance = random.Random(seed)
    data = bytearray(packed(tmp_path / "x.zip", {HSL: NOTEBOOK * 20, "receipt.json": b"{}"}).read_bytes())
    for _ in range(chance.randint(1, 8)):
        data[chance.randrange(len(data))] = chance.randrange(256)
    put(tmp_path / "in", "ada/my.zip", content=bytes(data[: chance.randint(len(data) // 2, len(data))]))
    look(tmp_path / "in")
    look(tmp_path / "in", ["01_hsl_filtering"])


def test_an_encrypted_or_oddly_packed_notebook_is_refused(look, tmp_path):
    with zipfile.ZipFile(tmp_path / "x.zip", "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr(HSL, NOTEBOOK)
    put(tmp_path / "in", "ada/x.zip", content=(tmp_path / "x.zip").read_bytes())
    data = bytearray(packed(tmp_path / "y.zip", {HSL: NOTEBOOK}).read_bytes())
    data[data.rfind(b"PK\1\2") + 8] |= 1
    put(tmp_path / "in", "bob/y.zip", content=bytes(data))
    told = reasons(look(tmp_path / "in"))
    assert "packed in an unusual way" in told["ada", "01_hsl_filtering"]
    assert "encrypted" in told["bob", "01_hsl_filtering"]


def test_a_broken_zip_of_which_the_lesson_is_known_is_refused_and_else_reported(look, tmp_path):
    put(tmp_path / "in", "ada/work.zip", content=b"PK")
    assert look(tmp_path / "in").unknown[0].startswith("ada/work.zip: it is no zip")
    found = gather(tmp_path / "in", tmp_path, LESSONS, ["01_hsl_filtering"])
    assert "no zip" in reasons(found)["ada", "01_hsl_filtering"]


@pytest.mark.parametrize("path", ["nothing", "in.zip"])
def test_what_is_no_folder_and_no_zip_is_said(tmp_path, path):
    (tmp_path / "in.zip").write_bytes(b"no zip")
    with pytest.raises(ValueError, match="a folder of submissions, or a zip of them, is wanted"):
        gather(tmp_path / path, tmp_path, LESSONS)


# --- students' names ---

HOSTILE = [
    "<script>alert(1)</script>",
    "ada\x1b[31m",
    "ada\n\r\t",
    "a" * 500,
    "a" * 499 + "b",
    "..",
    ".",
    "",
    "con",
    "CON",
    "ada/../eve",
    "ada",
    "Ada",
    "ADA",
    "ada ",
    "ada.",
    "Müller",
    "Mu\u0308ller",
    "\u202eada",
    "=1+1",
    "nul.txt",
    safe_name("Ada"),
    safe_name("Müller").upper(),
    "\udcff",
]


def test_safe_names_are_safe_and_none_is_anothers():
    names = [safe_name(name) for name in HOSTILE]
    assert len({name.lower() for name in names}) == len(names)
    for name in names:
        assert name.isascii() and name[0].isalnum() and not set(name) & set('/\\<>:"|?* \n')
        assert len(name) <= 60 and not name.endswith(".")
        assert name.split(".")[0] not in ("con", "nul")


def test_students_names_hold_nothing_that_a_terminal_obeys():
    names = [clean_name(name) for name in HOSTILE]
    assert all(name.isprintable() and len(name) <= LONGEST_NAME for name in names)
    assert all(name.encode() is not None for name in names)
    assert clean_name("a" * 500) != clean_name("a" * 499 + "b")
    assert clean_name("Mu\u0308ller") == clean_name("Müller")  # one student, two file systems
    assert clean_name("ada\x1b") != clean_name("ada")


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


def test_memory_stays_bounded_with_a_large_zip(look, tmp_path):
    import tracemalloc

    noise = zlib.compress(random.Random(1).randbytes(2**20), 0)
    packed(tmp_path / "in.zip", {f"s{number}/{HSL}": noise for number in range(40)})
    tracemalloc.start()
    found = gather(tmp_path / "in.zip", tmp_path / "scratch", LESSONS)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(found.submissions) == 40
    assert peak < 12 * 2**20
