"""Who is who in a class: students with all the names and numbers that platforms give them."""

from __future__ import annotations

import re
import shlex
import unicodedata
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

from nao_course.instructor.collecting.names import clean_name

# Platforms whose number of a person is the same in every assignment.
_SAME_IN_EVERY_ASSIGNMENT = ("brightspace", "canvas", "ilias")
_NUMBERED = ("moodle", *_SAME_IN_EVERY_ASSIGNMENT)
# What blind marking writes in place of a name.
_NAMELESS = re.compile(r"(?:Participante?|Teilnehmer/?in|Deelnemer|Partecipante)[ _]?\d+|anon_\w+")
_LAST_NUMBER = re.compile(r"_(\d+)$")


@dataclass(frozen=True)
class Student:
    """A student: `student` is the key of the journal, and the rest is what platforms and sheets say of the student.

    `aliases` are further names, and numbers such as "moodle 1234567", with the lesson that a number belongs to, or an
    empty string. `listed` says whether the student is in a sheet.
    """

    student: str
    name: str = ""
    email: str = ""
    login: str = ""
    section: str = ""
    aliases: Mapping[str, str] = field(default_factory=dict)
    listed: bool = False

    def joined(self, other: Student) -> Student:
        """Return this student with what the other record adds; a text of the other replaces this one's."""
        texts = ("name", "email", "login", "section")
        said = {each: getattr(other, each) or getattr(self, each) for each in texts}
        numbers = {alias: lesson or self.aliases.get(alias, "") for alias, lesson in other.aliases.items()}
        return Student(
            self.student, **said, aliases={**self.aliases, **numbers}, listed=self.listed or other.listed
        )


@dataclass(frozen=True)
class Person:
    """A person as one download names them: `identity` is the same for all of their files in it.

    `number` is the platform's, and `lessons` are the lessons whose files they handed in.
    """

    identity: str
    platform: str = ""
    number: str = ""
    name: str = ""
    login: str = ""
    email: str = ""
    lessons: frozenset[str] = frozenset()

    @property
    def alias(self) -> str:
        """What identifies the person on the platform: its number, or else the identity."""
        return f"{self.platform.lower()} {self.number}" if self.number else self.identity


@dataclass(frozen=True)
class Recognised:
    """Which students the people of a download are, by identity.

    `asked` has the people of whom nobody can say it, with the reason and the command that answers. `by_name` are lines
    about those who were recognised by their name alone, and `new` those who are in no earlier download. `learned` are
    the students with what the download says of them.
    """

    students: Mapping[str, str]
    asked: Mapping[str, str]
    by_name: tuple[str, ...] = ()
    new: tuple[str, ...] = ()
    learned: Mapping[str, Student] = field(default_factory=dict)


def is_nameless(identity: str) -> bool:
    """Return whether a platform gave a number in place of a name, as in blind marking.

    >>> is_nameless("Participant_1234567"), is_nameless("Ada Lovelace_1234567")
    (True, False)
    """
    return bool(_NAMELESS.fullmatch(identity))


class Roster:
    """The students of a class."""

    def __init__(self, students: Iterable[Student] = ()) -> None:
        self.students = {each.student: each for each in students}
        self._by: dict[str, dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
        for each in self.students.values():
            self._by["student"][fold(each.student)].add(each.student)
            for alias in each.aliases:
                self._by["alias"][fold(alias)].add(each.student)
            for kind in ("login", "email"):
                if said := getattr(each, kind):
                    self._by[kind][fold(said)].add(each.student)
            for name in filter(None, (each.name, each.student)):
                for spelling in _spellings(name):
                    self._by["name"][spelling].add(each.student)

    @classmethod
    def of(cls, names: Iterable[str]) -> Roster:
        """Return a roster of students of whom only the names are known."""
        return cls(Student(each, each) for each in names)

    @property
    def is_listed(self) -> bool:
        """Whether a sheet says who is in the class."""
        return any(each.listed for each in self.students.values())

    def is_known(self, name: str) -> bool:
        """Return whether a student has this name, alias, login or e-mail address."""
        return any(fold(name) in self._by[kind] for kind in ("student", "alias", "login", "email", "name"))

    def meant(self, word: str) -> str | None:
        """Return the only student whom a word means: a name in the gradebook, an alias, a login or an e-mail address.

        A name with a platform's number behind it, such as "Ada Lovelace_1234567", means the student of that number.
        """
        if word in self.students:
            return word
        for kind in ("alias", "email", "login", "student", "name"):
            if len(found := self._by[kind].get(fold(word), ())) == 1:
                return next(iter(found))
        if number := _LAST_NUMBER.search(word):
            found = {
                student
                for platform in ("moodle", "canvas")
                for student in self._by["alias"].get(f"{platform} {number[1]}", ())
            }
            return found.pop() if len(found) == 1 else None
        return None

    def recognise(self, people: Sequence[Person]) -> Recognised:
        """Find out which student each person of a download is; a person who may be several students is asked about."""
        here = Counter(fold(each.name) for each in people if each.name)
        students, asked, learned = dict[str, str](), dict[str, str](), dict[str, Student]()
        by_name, new = list[str](), list[str]()
        for person in sorted(people, key=lambda each: each.identity):
            nameless = is_nameless(person.identity)
            student = self._certainly(person)
            alike = sorted(self._by["name"].get(_spelling(person), ())) if person.name else []
            if student is None and alike:
                is_sure = len(alike) == 1 and here[fold(person.name)] == 1
                if not is_sure or self._is_other(alike[0], person.alias, person.lessons, person.email):
                    asked[person.identity] = _question(person, alike)
                    continue
                student = alike[0]
                by_name.append(f"{clean_name(person.identity)} is {student}: the only student of this name")
            elif student is None and self.is_listed and not nameless:
                asked[person.identity] = _question(person, ())
                continue
            elif student is None:
                is_free = here[fold(person.name)] == 1 and not self.is_known(person.name)
                # Moodle's number is another one in the next assignment.
                is_named = person.platform == "Moodle" and is_free and not nameless
                student = person.name if is_named else person.identity
                if self.students:
                    new.append(clean_name(student))
            elif is_nameless(student) and alike and student not in alike:
                by_name.append(
                    f"{clean_name(person.identity)} is {student} by the number. If that is {alike[0]}, say nao-course "
                    f"students GRADES --same {student} {shlex.quote(alike[0])}"
                )
            students[person.identity] = student
            key = clean_name(student)
            said = said_of(key, person)
            known = learned.get(key) or self.students.get(key)
            learned[key] = _filled(known, said) if known else said
        return Recognised(students, asked, tuple(by_name), tuple(new), learned)

    @staticmethod
    def is_alias(alias: str, name: str) -> bool:
        """Return whether an alias is a name in a download, or the platform's number in it."""
        number = _LAST_NUMBER.search(name)
        return fold(alias) == fold(name) or bool(number and alias.endswith(f" {number[1]}"))

    def _certainly(self, person: Person) -> str | None:
        """Return the student who has the person's number, name in the gradebook, alias, login or e-mail address."""
        for kind, word in (
            ("alias", person.alias),
            ("student", person.identity),
            ("alias", person.identity),
            ("email", person.email or person.identity),
            ("login", person.login or person.identity),
        ):
            found = self._by[kind].get(fold(word), set()) if word else set()
            if kind == "student" and found:
                if person.identity in found:
                    return person.identity
            elif len(found) == 1:
                return next(iter(found))
        if not (number := _LAST_NUMBER.search(person.identity)):
            return None
        name, student = fold(person.identity[: number.start()]), self.meant(person.identity)
        fits = any(student in self._by["name"].get(each, ()) for each in (name, f"canvas {name}"))
        return student if fits else None

    def _is_other(self, student: str, alias: str, lessons: Collection[str], email: str) -> bool:
        """Return whether another number on a platform, or another address, shows that a name is not this student's."""
        there = self.students[student]
        if email and there.email and fold(email) != fold(there.email):
            return True
        platform, space, _ = alias.partition(" ")
        numbers = {each: lesson for each, lesson in there.aliases.items() if each.startswith(f"{platform} ")}
        is_numbered = bool(space) and platform in _NUMBERED and alias not in numbers
        return is_numbered and (
            (bool(numbers) and platform in _SAME_IN_EVERY_ASSIGNMENT)
            or any(lesson in lessons for lesson in numbers.values())
        )

    def with_sheet(self, rows: Sequence[Student]) -> tuple[Roster, dict[str, str], list[str]]:
        """Return the roster with what a sheet says, the students who are others by it, and lines about equal names.

        The students who are others are given by their names before, with the names that they have now. Of a row without
        a name, only the number is used. Raise a ValueError if a row belongs to two students.
        """
        here = Counter(fold(row.name) for row in rows)
        joined, renamed, by_name = dict(self.students), dict[str, str](), list[str]()
        for row in rows:
            found = self._of_row(row)
            named = [each for each in found if not is_nameless(each)]
            if len(named) > 1 and all(fold(self.students[each].name) == fold(row.name) for each in named):
                named = sorted(named, key=lambda each: (not self.students[each].email, each))
            elif len(named) > 1:
                raise ValueError(
                    f"the sheet says that {' and '.join(map(repr, named))} are one student "
                    f"({row.name or row.student}). If so, say nao-course students GRADES --same "
                    f"{shlex.quote(named[0])} {shlex.quote(named[1])}, and read the sheet again"
                )
            if not named and row.name and here[fold(row.name)] == 1:
                alike = sorted(self._by["name"].get(fold(row.name), ()))
                numbers = row.aliases.items()
                if len(alike) == 1 and not any(
                    self._is_other(alike[0], alias, [lesson] if lesson else (), row.email)
                    for alias, lesson in numbers or {"": ""}.items()
                ):
                    named = alike
                    found += alike
                    by_name.append(f"the sheet's {row.name} is {alike[0]}: the only student of this name")
            if not (row.name or row.student or found):
                continue
            student = named[0] if named else (self._key(row, here) if row.name or row.student else found[0])
            said = joined.get(student) or Student(student)
            for each in found:
                if each != student and each in joined:
                    said = joined.pop(each).joined(said)
                    renamed[each] = student
            joined[student] = replace(replace(said, student=student).joined(row), student=student)
        return Roster(joined.values()), renamed, by_name

    def _of_row(self, row: Student) -> list[str]:
        """Return the students to whom a row of a sheet belongs by its numbers, address or login."""
        words = [("alias", alias) for alias in row.aliases]
        words += [("email", row.email), ("login", row.login), ("student", row.login), ("alias", row.login)]
        if row.student not in self.students:
            words += [("student", row.student), ("login", row.student), ("alias", row.student)]
        found = [row.student] if row.student in self.students else []
        found += [each for kind, word in words if word for each in sorted(self._by[kind].get(fold(word), ()))]
        return list(dict.fromkeys(found))

    def _key(self, row: Student, here: Mapping[str, int]) -> str:
        """Return the name in the gradebook of a student who is new.

        Raise a ValueError if two rows have the same name and nothing else.
        """
        if row.student:
            return row.student
        if here[fold(row.name)] == 1 and not self._by["student"].get(fold(row.name)):
            return row.name
        if known := row.email or row.login or next(iter(row.aliases), ""):
            return f"{row.name} ({known})"
        raise ValueError(
            f"the sheet has two students {row.name!r}: give their e-mail addresses or logins, too"
        )


@lru_cache(100_000)
def fold(name: str) -> str:
    """Return a name without differences of case, white space and composed characters; empty if it is no text."""
    try:
        return " ".join(unicodedata.normalize("NFKC", clean_name(name)).casefold().split()) if name else ""
    except UnicodeEncodeError:  # half of a character
        return ""


def first_name_first(name: str) -> str:
    """Return a name that may be written with the last name first.

    >>> first_name_first("Lovelace, Ada")
    'Ada Lovelace'
    """
    last, comma, first = name.partition(",")
    return f"{first.strip()} {last.strip()}" if comma and "," not in first else name.strip()


def _spellings(name: str) -> Iterator[str]:
    """Yield a name as it is, and as Canvas writes it before its numbers: the last name first, in one word."""
    words = fold(first_name_first(name)).split()
    yield " ".join(words)
    for at in range(1, len(words)):
        letters = "".join(words[at:] + words[:at])
        yield f"canvas {''.join(filter(str.isalnum, letters))}"


def _spelling(person: Person) -> str:
    return f"canvas {fold(person.name)}" if person.platform == "Canvas" else fold(person.name)


def said_of(student: str, person: Person) -> Student:
    """Return what a download says of a student."""
    (lesson, *more) = sorted(person.lessons) or [""]
    alias = clean_name(person.alias)
    return Student(
        student,
        "" if is_nameless(person.identity) or person.platform == "Canvas" else clean_name(person.name),
        person.email,
        person.login,
        aliases={alias: "" if more else lesson} if alias != student else {},
    )


def _filled(known: Student, said: Student) -> Student:
    """Return a known student with what a download adds; what a sheet or an earlier download said stays."""
    aliases = {alias: known.aliases.get(alias) or lesson for alias, lesson in said.aliases.items()}
    return replace(said, aliases=aliases).joined(
        replace(known, aliases={a: lesson for a, lesson in known.aliases.items() if a not in aliases})
    )


def _question(person: Person, alike: Sequence[str]) -> str:
    """Return the question who a person is, with the commands that answer it."""
    name = shlex.quote(person.identity)
    reason = (
        f"it may be {' or '.join(alike[:3])}, or another student" if alike else "no sheet has this student"
    )
    return (
        f"{person.identity} ({person.platform}): {reason}. Give the platform's sheet with --sheet, or say "
        f"nao-course students GRADES --same {name} STUDENT or --new {name}"
    )
