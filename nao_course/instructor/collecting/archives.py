"""What lies in a folder or a zip: listed without following or trusting it, and unpacked only where it counts."""

import calendar
import os
import re
import stat
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO

from nao_course.exercises.notebook_text import MOST_BYTES

MOST_FILES = 1_000_000  # in a folder of submissions; more is the wrong folder
MOST_ENTRIES = 2000  # in a student's zip
MOST_DIRECTORY = 2**20  # bytes of a student's zip's table of contents
LARGEST_ZIP = 4 * MOST_BYTES
LARGEST_READ = 2 * 2**20  # bytes of the largest notebook that is read as it is, and whose lines are shown
DEEPEST = 6  # folders in folders
MOST_RATIO, SMALL = 200, 10 * 2**20  # how much smaller a file may be in a zip, where it is not small anyhow
_OTHERS = re.compile(r"\.(7z|rar|tar|gz|tgz|bz2|xz|zst|zipx|lzh|ace|cab|iso)$", re.IGNORECASE)
_NOBODYS = {"__MACOSX", ".DS_Store", ".git", ".gitkeep", ".ipynb_checkpoints"}  # in a folder of all students
_LEFT_OUT = {*_NOBODYS, "kept", "release", "__pycache__"}  # in a student's
_BAD = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    ValueError,
    NotImplementedError,
    RuntimeError,
    EOFError,
    LookupError,
    OverflowError,
)
_END, _LOCATOR = struct.Struct("<4s4H2LH"), b"PK\x06\x07"


class Refused(Exception):  # noqa: N818 - it is the submission's, not the program's
    """A file that is not taken; its text is the reason."""


@dataclass(frozen=True)
class Item:
    """A file in a folder or zip.

    `parts` is its name, by folders, `source` the file or the zip that it is in, and `size` in bytes. `time` is in
    seconds since 1970; a zip's is without time zone. `problem` says why it is not read. An `ignored` item is a
    program's, such as a checkpoint, or represents an empty folder, so it only shows whose folder it is.
    """

    parts: tuple[str, ...]
    source: Path
    size: int = 0
    time: float = 0.0
    entry: zipfile.ZipInfo | None = None
    problem: str = ""
    ignored: bool = False

    @property
    def folder(self) -> str:
        """The folder that it lies in, with the folders around all students."""
        return self.entry.filename.rpartition("/")[0] if self.entry else str(self.source.parent)

    def content(self, most: int) -> bytes:
        """Return its content; refuse what is larger than `most` bytes, is not a plain file, or cannot be read."""
        if self.problem:
            raise Refused(self.problem)
        if self.entry is None:
            return read_plain(self.source, most)
        with opened(self.source) as file, _errors_in_words(), zipfile.ZipFile(file) as archive:
            with archive.open(self.entry) as member:
                data = member.read(most + 1)
            if len(data) > most:
                raise Refused(too_large(most))
            return data


def other_archive(file: str) -> str:
    """Return why a file is not opened that is named like an archive of another kind than zip; empty for any other file.

    >>> other_archive("work.7z")
    'it is a 7z archive, and only zips are opened. Unpack it, or hand in the zip that `nao-course submit` makes'
    """
    found = _OTHERS.search(file)
    what = f"it is a {found[1].lower()} archive, and only zips are opened" if found else ""
    return what and f"{what}. Unpack it, or hand in the zip that `nao-course submit` makes"


def too_large(most: int) -> str:
    """Say that a file has more than a number of bytes."""
    return f"it is larger than {most / 2**20:g} MB"


@contextmanager
def opened(path: Path) -> Iterator[IO[bytes]]:
    """Open a plain file, and nothing that a link or device leads to.

    Raise Refused for anything else, and for a file that cannot be read.
    """
    flags = (
        os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    )
    try:
        descriptor = os.open(path, flags | getattr(os, "O_CLOEXEC", 0))
    except OSError as error:
        raise Refused(_unreadable(error)) from None
    with os.fdopen(descriptor, "rb") as file:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise Refused("it is no plain file")
        yield file


def read_plain(path: Path, most: int) -> bytes:
    """Read a plain file of at most some bytes; raise Refused for anything else, and for a file that cannot be read."""
    with in_parts(path, most) as (_, parts):
        return b"".join(parts)


@contextmanager
def in_parts(path: Path, most: int) -> Iterator[tuple[int, Iterator[bytes]]]:
    """Open a plain file of at most some bytes to read it in parts.

    Yield its size in bytes, and its content, exactly of this size. Raise Refused if it is larger, is not a plain file,
    cannot be read, or has changed meanwhile.
    """
    with opened(path) as file:
        size = os.fstat(file.fileno()).st_size
        if size > most:
            raise Refused(too_large(most))
        yield size, _parts(file, size)


def _parts(file: IO[bytes], size: int) -> Iterator[bytes]:
    left = size
    while left:
        try:
            part = file.read(min(left, 2**20))
        except OSError as error:
            raise Refused(_unreadable(error)) from None
        if not part:
            raise Refused("it was changed while the grader was running")
        left -= len(part)
        yield part


def _unreadable(error: OSError) -> str:
    """Say why a file cannot be read that was found before."""
    if isinstance(error, FileNotFoundError):
        return "it was removed or renamed while the grader was running"
    return f"it cannot be read: {error.strerror}"


def in_folder(root: Path) -> Iterator[Item]:
    """List the files of a folder and of those in it, in the order of their names; links are not followed.

    Raise a ValueError if there are more than MOST_FILES.
    """
    for number, item in enumerate(_walk(root, ()), start=1):
        if number > MOST_FILES:
            raise ValueError(f"{root} holds more than {MOST_FILES} files: is it the folder of submissions?")
        yield item


def _walk(folder: Path, parts: tuple[str, ...]) -> Iterator[Item]:
    try:
        with os.scandir(folder) as found:
            entries = sorted(found, key=lambda each: each.name)
    except OSError as error:
        yield Item(parts, folder, problem=f"the folder cannot be read: {error.strerror}")
        return
    if not entries:
        yield Item((*parts, ""), folder, ignored=True)
    for entry in entries:
        path, name = Path(entry.path), (*parts, entry.name)
        if _is_left_out(entry.name, named_by_students=bool(parts)):
            yield Item(name, path, ignored=True)
            continue
        notebook = entry.name.lower().endswith(".ipynb")
        if entry.is_dir(follow_symlinks=False) and not notebook:
            if len(name) < DEEPEST:
                yield from _walk(path, name)
            else:
                yield Item(name, path, problem=f"it is more than {DEEPEST} folders deep")
            continue
        info = entry.stat(follow_symlinks=False)
        yield Item(name, path, info.st_size, info.st_mtime, problem=_mode_problem(info.st_mode))


def _mode_problem(mode: int) -> str:
    kinds = {
        stat.S_IFREG: "",
        stat.S_IFLNK: "it is a symbolic link, not a file or folder",
        stat.S_IFDIR: "it is a folder, not a notebook",
    }
    return kinds.get(stat.S_IFMT(mode), "it is a device or pipe, not a file")


def _is_left_out(name: str, *, named_by_students: bool) -> bool:
    """Return True if a file or folder belongs to a program. Folders named after students never do."""
    if named_by_students:
        return name.startswith(".") or name in _LEFT_OUT
    return name in _NOBODYS


def in_zip(path: Path, *, students: bool) -> list[Item]:
    """List the files of a zip, without unpacking anything.

    A zip made by a student may hold no more than a student's work does. Raise Refused if it is not a zip, or holds too
    much.
    """
    with opened(path) as file, _errors_in_words():
        if students:
            _refuse_a_large_one(file)
        with zipfile.ZipFile(file) as archive:
            found = [(each, each.is_dir()) for each in archive.infolist()]
    items = [_item(path, each) for each, is_folder in found if not is_folder]
    folders = [_item(path, each) for each, is_folder in found if is_folder]
    listed = [
        replace(each, ignored=each.ignored or _is_ignored(each.parts, students))
        for each in (*items, *_empty_ones(folders, items))
    ]
    return [each for each in listed if each.parts[0] not in _NOBODYS]


def _empty_ones(folders: list[Item], files: list[Item]) -> list[Item]:
    """Return an ignored item for each folder without files, because an empty folder still names its student."""
    filled = {item.parts[:depth] for item in files for depth in range(1, len(item.parts))}
    return [
        replace(each, parts=(*each.parts, ""), ignored=True) for each in folders if each.parts not in filled
    ]


def _name_of(entry: zipfile.ZipInfo) -> str:
    """Return an entry's name. Some programs, such as the one of macOS, write UTF-8 without saying so."""
    if not entry.flag_bits & 0x800:
        with suppress(UnicodeError):
            return entry.filename.encode("cp437").decode("utf-8")
    return entry.filename


def _is_ignored(parts: tuple[str, ...], students: bool) -> bool:
    first, *others = parts
    return _is_left_out(first, named_by_students=students) or any(
        _is_left_out(each, named_by_students=True) for each in others
    )


def _refuse_a_large_one(file: IO[bytes]) -> None:
    """Look at a zip's last bytes, for its table of contents is read whole: it might fill the memory."""
    size = file.seek(0, os.SEEK_END)
    if size > LARGEST_ZIP:
        raise Refused(too_large(LARGEST_ZIP))
    file.seek(max(0, size - 2**16 - _END.size))
    tail = file.read()
    plain = tail[-_END.size :]
    at = len(tail) - _END.size if plain[:4] == b"PK\5\6" and plain[-2:] == b"\0\0" else tail.rfind(b"PK\5\6")
    if at < 0 or at + _END.size > len(tail):
        raise Refused("it is no zip")
    *_, count, directory, _, _ = _END.unpack_from(tail, at)
    if count > MOST_ENTRIES or directory > MOST_DIRECTORY or tail[max(at - 20, 0) : at].startswith(_LOCATOR):
        raise Refused(
            f"a zip with more than {MOST_ENTRIES} files, or with a table of contents too large for them"
        )


def _item(path: Path, entry: zipfile.ZipInfo) -> Item:
    names = re.split(r"[/\\]", _name_of(entry))
    parts = tuple(name for name in names if name not in ("", ".", ".."))
    try:
        time = float(calendar.timegm(entry.date_time))
    except (ValueError, OverflowError):
        time = 0.0
    return Item(parts or ("?",), path, entry.file_size, time, entry, _entry_problem(entry, names))


def _entry_problem(entry: zipfile.ZipInfo, names: list[str]) -> str:
    """Return the reason why an entry of a zip is not used."""
    mode = entry.external_attr >> 16
    if ".." in names or names[0] == "" or re.match(r"[A-Za-z]:", names[0]):
        return "its name in the zip leads outside of it"
    if stat.S_IFMT(mode) and (problem := _mode_problem(mode)):
        return problem
    if entry.flag_bits & 1:
        return "it is encrypted"
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        return "it uses an unusual compression; make a plain zip"
    if entry.file_size > SMALL and entry.file_size > MOST_RATIO * entry.compress_size:
        return (
            f"it is a zip bomb: unpacking turns {_megabytes(entry.compress_size)} into "
            f"{_megabytes(entry.file_size)}. Clear all outputs and hand in the notebook without a zip"
        )
    return ""


def _megabytes(size: int) -> str:
    return f"{size / 2**20:.2f} MB"


@contextmanager
def _errors_in_words() -> Iterator[None]:
    """Turn all that a broken zip can raise into a reason."""
    try:
        yield
    except (*_BAD, OSError):
        raise Refused("the zip is damaged and cannot be opened: hand it in again") from None
