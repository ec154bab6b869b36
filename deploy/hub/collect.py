"""Copy every student's notebooks from the home folders into a folder that `nao-course grade` takes.

sudo /opt/nao-course/current/.venv/bin/python collect.py SUBMISSIONS [--lesson 01] [--student WHO] [--sheet SHEET]

SUBMISSIONS is a new folder: what was collected before stays as it was. With the learning platform's sheet of grades
(Moodle's grading worksheet or Canvas's gradebook), each student's folder is named after the student and the platform's
number, so that `nao-course export` finds the student in that sheet. This needs the course; without a sheet, any Python
will do. With a lesson's number, a table says when each student last changed that lesson's notebook, by the system's
clock and not by the student's. Students' files are not trusted: a link is never followed, a file that belongs to
another user is never copied, and a student's files may have a limited size together.
"""

import argparse
import csv
import os
import re
import stat
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

from names import START, account_of, system_name

NOTEBOOKS = "notebooks"  # in each home folder
WANTED = re.compile(r"\d\d_\w+\.ipynb|[A-Za-z_]\w*\.py", re.ASCII)  # lessons, and what they may import
LARGEST = 50 * 2**20  # bytes; `grade` refuses larger notebooks, too
MOST_FILES = 100  # of a student
MOST_BYTES = 4 * LARGEST  # of a student's files together, holes in sparse files included
HOLE = bytes(2**16)  # what is written as a hole
WORLDS = "worlds.csv"  # for `nao-course marks --worlds`: a personal world follows from the account's name
TIMES = "handed_in.csv"  # for `nao-course grade --sheet`


def main(arguments: list[str] | None = None) -> int:
    """Collect what the command line names; return the exit status."""
    parser = argparse.ArgumentParser(description="Copy every student's notebooks into a folder to grade.")
    parser.add_argument("submissions", type=Path, metavar="SUBMISSIONS", help="Folder to copy to; a new one.")
    parser.add_argument("--homes", type=Path, default=Path("/home"), help="Folder of the home folders.")
    parser.add_argument("--sheet", type=Path, help="Sheet of grades of Moodle or Canvas, CSV.")
    parser.add_argument(
        "--lesson", metavar="01", help=f"Write the times of this lesson's notebooks into {TIMES}."
    )
    parser.add_argument(
        "--student", action="append", metavar="WHO", help="E-mail address or account; all by default."
    )
    chosen = parser.parse_args(arguments)
    if chosen.submissions.exists() and any(chosen.submissions.iterdir()):
        print(
            f"{chosen.submissions} is not empty, and what was collected stays as it is. Name a new folder.",
            file=sys.stderr,
        )
        return 1
    try:
        people = read_sheet(chosen.sheet) if chosen.sheet else {}
    except ModuleNotFoundError:
        print(
            "--sheet needs the course: use its Python, /opt/nao-course/current/.venv/bin/python",
            file=sys.stderr,
        )
        return 1
    except (OSError, ValueError) as error:
        print(f"{chosen.sheet} cannot be used, and nothing was copied: {error}", file=sys.stderr)
        return 1
    names = {account: folder for account, (folder, _) in people.items()}
    accounts = list(map(account_of, chosen.student)) if chosen.student else all_accounts(chosen.homes)
    copied, problems = collect(chosen.homes, accounts, chosen.submissions, names)
    print(f"{sum(copied.values())} files of {len(copied)} students are in {chosen.submissions}")
    worlds = [(names[home], home) for home in copied if home in names]
    write_table(chosen.submissions / WORLDS, ("student", "world"), worlds)
    if chosen.lesson:
        times = handing_in_times(chosen.homes, chosen.lesson, copied)
        said = ((*people.get(home, (home, "")), time) for home, time in times.items())
        write_table(chosen.submissions / TIMES, ("student", "email", "handed in"), said)
    if chosen.sheet and (unknown := sorted(set(copied) - set(names))):
        print(
            f"in no row of {chosen.sheet}, or in several, so the folder has the account's name: {', '.join(unknown)}"
        )
    for line in problems:
        print(f"NOT COPIED: {line}", file=sys.stderr)
    return 1 if problems else 0


def read_sheet(sheet: Path) -> dict[str, tuple[str, str]]:
    """Return folder names such as "Ada Lovelace_1234567" and addresses by account, "nao-ada-lovelace-3c6d023791".

    A row of the sheet has a student's name and number: the number in Moodle's first column ("Participant 1234567"), or
    in Canvas's column "ID". Any cell of it may be what the account is made from; an address is such a cell with "@".
    """
    from nao_course._internal.tables import read_people

    found: dict[str, dict[str, str]] = {}
    for person in read_people(sheet):
        student = person.name.replace("/", " ").replace("_", " ").strip() or "student"
        for cell in filter(None, person.cells if person.number else ()):
            address = cell.strip() if "@" in cell else ""
            found.setdefault(system_name(cell), {})[f"{student}_{person.number}"] = address
    # Whoever calls themselves by a classmate's address does not get that classmate's work.
    return {account: next(iter(folders.items())) for account, folders in found.items() if len(folders) == 1}


def all_accounts(homes: Path) -> list[str]:
    """Return the accounts of all students who have a home folder."""
    return sorted(each for each in os.listdir(homes) if each.startswith(START))


def collect(
    homes: Path, accounts: Iterable[str], out: Path, names: Mapping[str, str]
) -> tuple[dict[str, int], list[str]]:
    """Copy students' files; return the number of files by account, and a line for each file that was refused."""
    copied, problems = {}, []
    for home in accounts:
        if not os.path.lexists(homes / home):
            problems.append(f"{home}: there is no such account in {homes}")
            continue
        try:
            with opened(homes / home / NOTEBOOKS) as folder:
                files = sorted(each for each in os.listdir(folder) if WANTED.fullmatch(each))
                if len(files) > MOST_FILES:
                    problems.append(f"{home}: only the first {MOST_FILES} of {len(files)} files")
                left = MOST_BYTES
                for name in files[:MOST_FILES]:
                    try:
                        content = read(name, folder)
                        if len(content) > left:
                            raise ValueError(
                                f"the student's files are larger than {MOST_BYTES // 2**20} MB together"
                            )
                        write(out / names.get(home, home) / name, content)
                        left -= len(content)
                        copied[home] = copied.get(home, 0) + 1
                    except (OSError, ValueError) as error:
                        problems.append(f"{home}/{name}: {error}")
        except FileNotFoundError:
            continue  # the student has an account and has not opened a lesson yet
        except OSError as error:
            problems.append(f"{home}: {error}")
    return copied, problems


def handing_in_times(homes: Path, lesson: str, accounts: Iterable[str]) -> dict[str, str]:
    """Return when each student last changed the notebook of a lesson, in UTC, by account.

    It is the time at which the system noticed the change. The time that a file shows can be set by its owner.
    """
    times = {}
    for home in accounts:
        with suppress(OSError), opened(homes / home / NOTEBOOKS) as folder:
            names = [
                each
                for each in os.listdir(folder)
                if WANTED.fullmatch(each) and each.startswith(f"{lesson}_")
            ]
            if names:
                changed = max(os.stat(each, dir_fd=folder, follow_symlinks=False).st_ctime for each in names)
                times[home] = datetime.fromtimestamp(changed, UTC).isoformat(timespec="seconds")
    return times


def write_table(path: Path, header: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> None:
    """Write a table, if it has rows, that `nao-course` reads."""
    if rows := sorted(rows):
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([header, *rows])


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
    with part.open("wb") as file:
        for start in range(0, len(content), len(HOLE)):
            block = content[start : start + len(HOLE)]
            if block == HOLE:  # a sparse file stays sparse
                file.seek(len(block), os.SEEK_CUR)
            else:
                file.write(block)
        file.truncate(len(content))
    part.replace(path)


if __name__ == "__main__":
    sys.exit(main())
