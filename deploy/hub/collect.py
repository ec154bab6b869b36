"""Copy every student's notebooks from the home folders into a folder that `nao-course grade` takes.

sudo python3 collect.py SUBMISSIONS [--homes FOLDER] [--sheet SHEET]

With the learning platform's sheet of grades (Moodle's grading worksheet or Canvas's gradebook), each student's folder
is named after the student and the platform's number, so that `nao-course export` finds the student in that sheet. Needs
only Python. Students' files are not trusted: a link is never followed, and a file that belongs to another user is never
copied.
"""

from __future__ import annotations

import argparse
import csv
import os
import re
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from names import system_name

NOTEBOOKS = "notebooks"  # in each home folder
WANTED = re.compile(r"\d\d_\w+\.ipynb|[A-Za-z_]\w*\.py", re.ASCII)  # lessons, and what they may import
LARGEST = 50 * 2**20  # bytes; `grade` refuses larger notebooks, too
MOST_FILES = 100  # of a student
WORLDS = "worlds.csv"  # for `nao-course marks --worlds`: a personal world follows from the account's name


def main(arguments: list[str] | None = None) -> int:
    """Collect what the command line names; return the exit status."""
    parser = argparse.ArgumentParser(description="Copy every student's notebooks into a folder to grade.")
    parser.add_argument("submissions", type=Path, metavar="SUBMISSIONS", help="Folder to copy to.")
    parser.add_argument("--homes", type=Path, default=Path("/home"), help="Folder of the home folders.")
    parser.add_argument("--sheet", type=Path, help="Sheet of grades of Moodle or Canvas, CSV.")
    chosen = parser.parse_args(arguments)
    names = folder_names(chosen.sheet) if chosen.sheet else {}
    copied, problems = collect(chosen.homes, chosen.submissions, names)
    print(f"{sum(copied.values())} files of {len(copied)} students are in {chosen.submissions}")
    write_worlds(chosen.submissions / WORLDS, {names[home]: home for home in copied if home in names})
    if chosen.sheet and (unknown := sorted(set(copied) - set(names))):
        print(
            f"in no row of {chosen.sheet}, or in several, so the folder has the account's name: {', '.join(unknown)}"
        )
    for line in problems:
        print(f"NOT COPIED: {line}", file=sys.stderr)
    return 1 if problems else 0


def folder_names(sheet: Path) -> dict[str, str]:
    """Return a folder's name for each account that a cell of the sheet belongs to.

    Parameters
    ----------
    sheet : Path
        Has a student's name and number in each row: the number in Moodle's first column ("Participant 1234567"), or
        in Canvas's column "ID".

    Returns
    -------
    dict of str to str
        "Ada Lovelace_1234567" by "nao-ada-lovelace-3c6d023791".
    """
    with sheet.open(encoding="utf-8-sig", newline="") as file:
        header, *rows = csv.reader(file)
    columns = [each.strip().casefold() for each in header]
    is_canvas = columns[:2] == ["student", "id"]
    name_at, number_at = (0, 1) if is_canvas else (1, 0)
    names: dict[str, set[str]] = {}
    for row in rows:
        number = re.fullmatch(r"\D*(\d+)", row[number_at].strip()) if len(row) > 1 else None
        if number:
            student = row[name_at].replace("/", " ").replace("_", " ").strip() or "student"
            for cell in filter(str.strip, row):
                names.setdefault(system_name(cell), set()).add(f"{student}_{number[1]}")
    # Whoever calls themselves by a classmate's address does not get that classmate's work.
    return {account: found.pop() for account, found in names.items() if len(found) == 1}


def collect(homes: Path, out: Path, names: dict[str, str]) -> tuple[dict[str, int], list[str]]:
    """Copy the students' files; return the number of files by account, and a line for each file that was refused."""
    copied, problems = {}, []
    for home in sorted(each for each in os.listdir(homes) if each.startswith("nao-")):
        try:
            with opened(homes / home / NOTEBOOKS) as folder:
                files = sorted(each for each in os.listdir(folder) if WANTED.fullmatch(each))
                if len(files) > MOST_FILES:
                    problems.append(f"{home}: only the first {MOST_FILES} of {len(files)} files")
                for name in files[:MOST_FILES]:
                    try:
                        write(out / names.get(home, home) / name, read(name, folder))
                        copied[home] = copied.get(home, 0) + 1
                    except (OSError, ValueError) as error:
                        problems.append(f"{home}/{name}: {error}")
        except FileNotFoundError:
            continue  # the student has an account and has not opened a lesson yet
        except OSError as error:
            problems.append(f"{home}: {error}")
    return copied, problems


def write_worlds(path: Path, accounts: dict[str, str]) -> None:
    """Write the account of each student whose folder has another name."""
    if accounts:
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([("student", "world"), *sorted(accounts.items())])


@contextmanager
def opened(folder: Path) -> Iterator[int]:
    """Open a student's folder; fail if it, or the home folder, is a link."""
    home = os.open(folder.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        descriptor = os.open(folder.name, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=home)
    finally:
        os.close(home)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def read(name: str, folder: int) -> bytes:
    """Read an ordinary file of the folder's owner; not a link, not a second name of another user's file."""
    # Without O_NONBLOCK, a pipe of that name would wait for ever.
    descriptor = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=folder)
    with os.fdopen(descriptor, "rb") as file:
        state = os.fstat(descriptor)
        if not stat.S_ISREG(state.st_mode):
            raise ValueError("it is not a file")
        if state.st_uid != os.fstat(folder).st_uid or state.st_nlink > 1:
            raise ValueError("it belongs to another user, or has a second name")
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise ValueError(f"it is larger than {LARGEST // 2**20} MB")
    return content


def write(path: Path, content: bytes) -> None:
    """Write a file as a whole: a grader that reads at the same time finds the old one or the new one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.part")
    part.write_bytes(content)
    part.replace(path)


if __name__ == "__main__":
    sys.exit(main())
