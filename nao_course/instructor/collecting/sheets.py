"""The platforms' own sheets of a class: who is in it, under which numbers, and when each submission was made."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from nao_course._internal.tables import (
    NAMES_OF_MOODLE,
    NUMBERS_OF_MOODLE,
    TableError,
    read_rows,
    refuse_doubled_columns,
    unescape_formula,
)
from nao_course.instructor.collecting.marks import read_time
from nao_course.instructor.collecting.names import clean_name
from nao_course.instructor.collecting.roster import Student, first_name_first

# The columns of a class list, and what the platforms call them.
COLUMNS: Mapping[str, Sequence[str]] = {
    "student": ("student",),
    "name": ("name", *NAMES_OF_MOODLE),
    "first name": ("first name", "firstname", "given name", "vorname"),
    "last name": ("last name", "lastname", "surname", "family name", "nachname"),
    "email": (
        *("email", "e-mail", "email address", "e-mail-adresse", "adresse de courriel", "dirección de correo"),
    ),
    "login": ("login", "username", "user name", "sis login id", "anmeldename"),
    "section": ("section", "sections", "group", "gruppe"),
    "aliases": (
        *("aliases", "id number", "sis user id", "orgdefinedid", "student id", "sid", "github_username"),
    ),
    "handed in": ("handed in",),
}
_TIME_OF_MOODLE = re.compile(
    r"(?:last modified|zuletzt geändert|dernière modification|última modificación) \((?!grade|bewertung|note|calif).*"
)
_NOBODY = ("points possible", "student, test", "test student")  # rows of Canvas's gradebook


@dataclass(frozen=True)
class Sheet:
    """The rows of a sheet, and when they were handed in, by what identifies a row, as far as the sheet says so."""

    platform: str
    rows: tuple[Student, ...]
    times: Mapping[str, str] = field(default_factory=dict)


def read_sheet(path: Path, lesson: str = "") -> Sheet:
    """Read Moodle's grading worksheet, Canvas's gradebook, or a CSV file with some of the `COLUMNS`.

    Moodle's numbers belong to one assignment, which is the `lesson`'s. Raise a TableError if it is no such sheet, or a
    column or number is there twice.
    """
    table = [[unescape_formula(cell).strip() for cell in row] for row in read_rows(path)]
    header = [each.casefold() for each in table[0]] if table else []
    columns = {
        kind: [at for at, name in enumerate(header) if name in names] for kind, names in COLUMNS.items()
    }
    number, platform = None, ""
    if {"student", "id", "section"} <= set(header):
        number, platform = header.index("id"), "canvas"
        columns["name"], columns["student"] = columns["student"], []
    times_of_moodle = [at for at, name in enumerate(header) if _TIME_OF_MOODLE.fullmatch(name)]
    is_moodles = bool(times_of_moodle or {*NAMES_OF_MOODLE} & {*header})
    if is_moodles and (found := [name for name in NUMBERS_OF_MOODLE if name in header]):
        number, platform, columns["handed in"] = header.index(found[0]), "moodle", times_of_moodle
    if number is None and not any(columns[each] for each in ("student", "name", "last name")):
        raise TableError(
            f"{path.name} is not Moodle's grading worksheet or Canvas's gradebook, and it has no column 'student' or "
            f"'name'. A class list may have the columns {', '.join(COLUMNS)}"
        )
    used = [header[at] for kind in columns if kind != "aliases" for at in columns[kind]]
    refuse_doubled_columns(path.name, header, used + ([header[number]] if number is not None else []))
    rows, times = list[Student](), dict[str, str]()
    people = dict[tuple[str, str], int]()
    for line, cells in enumerate(table[1:], start=2):
        full = cells + [""] * (len(header) - len(cells))
        full = [each.removeprefix("#") for each in full]  # Brightspace marks texts so
        said = {kind: next((full[at] for at in found if full[at]), "") for kind, found in columns.items()}
        if not said["name"] and said["last name"]:
            said["name"] = f"{said['first name']} {said['last name']}".strip()
        identifier = dict(zip(header, full, strict=False)).get("identifier", "")
        if "@" in identifier:  # as in GitHub Classroom's roster
            said["email"] = said["email"] or identifier
        if not any(full) or said["name"].casefold().startswith(_NOBODY):
            continue
        digits = re.fullmatch(r"\D*(\d+)", full[number]) if number is not None else None
        if number is not None and digits is None:
            continue
        aliases = {f"{platform} {digits[1]}": lesson if platform == "moodle" else ""} if digits else {}
        for at in columns["aliases"]:
            aliases |= {clean_name(each): "" for each in re.split(r"[;|]", full[at]) if each.strip()}
        row = Student(
            clean_name(said["student"]) if said["student"] else "",
            clean_name(first_name_first(said["name"])) if said["name"] else "",
            email=said["email"],
            login=said["login"],
            section=said["section"],
            aliases=aliases,
            listed=True,
        )
        rows.append(row)
        for kind, value in {"number": digits[1] if digits else "", **said}.items():
            if kind in ("number", "student", "email", "login"):
                _refuse_doubled(path.name, kind, value, line, people)
        if time := read_time(said["handed in"]):
            times[key_of(row)] = time
    shared = Counter(alias for row in rows for alias in row.aliases)  # such as "n/a" for everybody
    unique = [replace(row, aliases={a: n for a, n in row.aliases.items() if shared[a] == 1}) for row in rows]
    return Sheet(platform, tuple(unique), times)


def _refuse_doubled(file: str, kind: str, value: str, line: int, people: dict[tuple[str, str], int]) -> None:
    """Raise a TableError if an earlier row belongs to the same person."""
    if value and (first := people.setdefault((kind, value.casefold()), line)) != line:
        raise TableError(
            f"{file}, rows {first} and {line}: both have the {kind} {value!r}, and a student has one row. "
            "Remove one of them"
        )


def key_of(row: Student) -> str:
    """Return what identifies a row: its first number or alias, or else the student's name."""
    return next(iter(row.aliases), row.student or row.email or row.name)
