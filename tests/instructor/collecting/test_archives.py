"""What lies in a folder or zip is never followed, trusted or unpacked without bounds; what is refused has a reason."""

import os
import random
import re
import stat
import struct
import zipfile
import zlib

import pytest

from nao_course.instructor.collecting import archives
from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.files import read
from nao_course.instructor.collecting.submissions import Submission, gather
from tests.handed_in import HSL, LESSONS, NOTEBOOK, packed, posix, put, reasons, who


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
        "link": "it is a symbolic link, not a file or folder",
        "pipe": "it is a device or pipe, not a file",
        "folder": "it is a folder, not a notebook",
        "empty": "it is empty",
    }


@posix
def test_a_file_that_becomes_a_link_or_a_pipe_meanwhile_is_not_followed_nor_a_huge_one_read(tmp_path):
    (tmp_path / "secret").write_bytes(b"secret")
    (tmp_path / "link").symlink_to(tmp_path / "secret")
    os.mkfifo(tmp_path / "pipe")
    with (tmp_path / "huge").open("wb") as file:
        file.truncate(200 * 2**20)
    for name, said in {"link": None, "pipe": None, "gone": None, "huge": "it is larger than 50 MB"}.items():
        with pytest.raises(Refused, match=said):
            read(Submission("ada", LESSONS[1], tmp_path / name))


@posix
@pytest.mark.skipif(hasattr(os, "geteuid") and os.geteuid() == 0, reason="nothing is unreadable for root")
def test_an_unreadable_file_is_refused(tmp_path):
    put(tmp_path, "a.ipynb")
    (tmp_path / "a.ipynb").chmod(0)
    with pytest.raises(Refused, match="cannot be read"):
        read(Submission("ada", LESSONS[1], tmp_path / "a.ipynb"))


@pytest.mark.parametrize(
    "name", [f"../{HSL}", f"ada/../../{HSL}", f"/etc/{HSL}", f"C:\\ada\\{HSL}", f"ada\\..\\{HSL}"]
)
def test_names_that_lead_out_of_a_zip_lead_nowhere(look, tmp_path, name):
    packed(tmp_path / "in" / "ada" / "my.zip", {name: NOTEBOOK})
    found = look(tmp_path / "in")
    assert found.submissions == found.unknown == ()
    assert reasons(found) == {("ada", "01_hsl_filtering"): "its name in the zip leads outside of it"}
    found = look(packed(tmp_path / "in.zip", {name: NOTEBOOK}))
    assert found.submissions == () and len(found.refused) + len(found.unknown) == 1


def test_a_link_in_a_zip_is_refused(look, tmp_path):
    packed(tmp_path / "in" / "ada" / "my.zip", {HSL: b"/etc/passwd"}, mode=stat.S_IFLNK | 0o777)
    (reason,) = reasons(look(tmp_path / "in")).values()
    assert reason == "it is a symbolic link, not a file or folder"


def test_a_zip_bomb_is_refused_and_the_others_are_not(look, tmp_path):
    for student, size in (("ada", 40), ("eve", 60)):
        packed(tmp_path / "in" / student / "my.zip", {HSL: bytes(size * 2**20)})
    found = look(put(tmp_path / "in", f"bob/{HSL}"))
    assert who(found) == [("bob", "01_hsl_filtering")] and len(found.refused) == 2
    said = "zip bomb: unpacking turns 0.0. MB into [46]0.00 MB"
    assert all(re.search(said, reason) for reason in reasons(found).values())


def test_a_zip_that_lies_about_sizes_is_refused(look, tmp_path):
    content = bytes(archives.SMALL * 8)
    path = packed(tmp_path / "in" / "ada" / "my.zip", {HSL: content})
    data = bytearray(path.read_bytes())
    at = data.rfind(b"PK\1\2")
    data[at + 24 : at + 28] = struct.pack("<I", 1000)  # 1000 bytes, it says
    path.write_bytes(data)
    found = look(tmp_path / "in")
    assert found.submissions == ()
    assert "damaged" in reasons(found)["ada", "01_hsl_filtering"]


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
    assert "uses an unusual compression" in told["ada", "01_hsl_filtering"]
    assert "encrypted" in told["bob", "01_hsl_filtering"]


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


@pytest.mark.parametrize("encoding", ["utf-8", "cp437"])
def test_a_zips_names_are_read_in_utf_8_even_where_it_does_not_say_so(look, tmp_path, encoding):
    data = packed(tmp_path / "in.zip", {f"Mxxxller/{HSL}": NOTEBOOK, f"ada/{HSL}": NOTEBOOK}).read_bytes()
    (tmp_path / "in.zip").write_bytes(data.replace(b"xxx", "ü".encode(encoding).ljust(3, b"l")))
    found = look(tmp_path / "in.zip")
    assert [student[:2] for student, _ in who(found)] == ["Mü", "ad"]
