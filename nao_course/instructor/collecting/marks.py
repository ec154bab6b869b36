"""Dates, times and attempts in names of folders and files: they order a student's work and belong to no name."""

import re
from calendar import timegm
from dataclasses import dataclass
from datetime import UTC, datetime, tzinfo
from zoneinfo import ZoneInfo

_MONTHS = {  # the beginnings of months in the languages of platforms, by number
    name: number
    for number, names in enumerate(
        (
            "jan ene gen",
            "feb fév fev",
            "mar mär mrz maa",
            "apr avr abr",
            "may mai mag maj mei",
            "jun juin giu",
            "jul juil lug",
            "aug aoû aou ago",
            "sep set",
            "oct okt out ott",
            "nov",
            "dec dez déc dic",
        ),
        start=1,
    )
    for name in names.split()
}
_MONTH = "|".join(sorted(_MONTHS, key=len, reverse=True))
_ALONE, _ENDS = r"(?<![^\W_])", r"(?![^\W_])"  # no letter or digit before, and none behind
_DATE = re.compile(
    rf"""{_ALONE}(?:
        (?P<year>(?:19|20)\d\d)([-_./ ])(?P<month>\d\d?)\2(?P<day>\d\d?)
        | (?P<first>\d\d?)(?P<between>[-_./ ])(?P<second>\d\d?)(?P=between)(?P<year2>20\d\d)
        | (?P<name>{_MONTH})[^\W\d_]*+\.?[ _-]*+(?P<day3>\d\d?),?[ _-]++(?P<year3>20\d\d)
        | (?P<day4>\d\d?)\.?[ _-]++(?P<name4>{_MONTH})[^\W\d_]*+\.?,?[ _-]*+(?P<year4>20\d\d)
        | (?P<stamp>20\d{{6}})(?=[-_T ]?\d{{4}})
    )
    (?:,?(?:[ ]at)?[-_T ]*(?P<hour>\d\d?)[-_:.h ]?(?P<minutes>\d\d)(?:[-_:.]?(?P<seconds>\d\d)(?:\.\d++)?)?
        (?:[ ]?(?P<half>[AP])\.?M\b\.?)?(?:[ ]?(?:UTC|GMT|Z|CET|CEST))?(?:[+-]\d\d:?\d\d)?
    )?{_ENDS}""",
    re.IGNORECASE | re.VERBOSE,
)
_TIME = re.compile(rf"{_ALONE}(?:\d\d?[:h]\d\d(?:[ ]?[AP]M)?|\d{{1,4}}[ ]?[AP]M){_ENDS}", re.IGNORECASE)
_WORD = "attempt|version|versuch|tentative|intento|tentativa|tentativo|poging|försök|try|resubmission|submission|abgabe"
_ATTEMPT = re.compile(
    rf"{_ALONE}(?:(?:{_WORD})[ _#.:-]*+(?P<after>\d{{1,9}})"
    rf"|(?P<before>\d{{1,3}})(?:st|nd|rd|th|\.)[ _-]?(?:{_WORD})){_ENDS}",
    re.IGNORECASE,
)
# May be a part of a name, such as a student's number, and may be a date, a copy or a version.
_WEAK = re.compile(
    rf"{_ALONE}(?:(?:19|20)\d\d(?:0[1-9]|1[0-2])(?:0[1-9]|[12]\d|3[01])|v ?\d{{1,3}}|copy ?\d*+|kopie ?\d*+"
    rf"|late|final|new|old){_ENDS}|\(\d++\)",
    re.IGNORECASE,
)
_ZONE = re.compile(r"(?:UTC|GMT|Z|(?P<offset>[+-]\d\d:?\d\d)|(?P<region>[A-Z]\w+(?:/[\w+-]+)+))$")
_SAKAIS = re.compile(r"20\d{15}")  # an older Sakai's timestamp.txt, in UTC and with milliseconds
_EDGES = " _-,;.()[]"


@dataclass(frozen=True)
class Marks:
    """A name without its dates, times and attempts, and what they mean; the whole name if there are none.

    The attempt and the time are 0 if none is named; `time` is in seconds since 1970 without a time zone, for
    comparisons. `is_clear` says whether every date and time could be read.
    """

    name: str
    attempt: int = 0
    time: float = 0.0
    is_clear: bool = True


def read_marks(text: str) -> Marks:
    """Take dates, times and attempts out of a name.

    >>> read_marks("Ada Lovelace - Nov 20, 2026 932 PM").name
    'Ada Lovelace'
    >>> read_marks("ada_attempt_2").attempt, read_marks("Ada 03/04/2026").is_clear
    (2, False)
    """
    times, attempts, clear = list[float](), list[int](), True

    def take_date(found: re.Match[str]) -> str:
        nonlocal clear
        moment = _moment(found)
        if moment is None:
            return found[0]
        clear &= moment > 0
        times.append(moment)
        return "\0"

    def take_time(found: re.Match[str]) -> str:
        nonlocal clear
        clear = False
        return "\0"

    def take_attempt(found: re.Match[str]) -> str:
        attempts.append(int(found["after"] or found["before"]))
        return "\0"

    rest = _DATE.sub(take_date, text)
    rest = _TIME.sub(take_time, rest)
    rest = _ATTEMPT.sub(take_attempt, rest)
    if rest == text:
        return Marks(text)
    pieces = [piece.strip(_EDGES) for piece in rest.split("\0")]
    clear &= len(times) < 2 and len(attempts) < 2
    return Marks(" ".join(filter(None, pieces)), max(attempts, default=0), max(times, default=0.0), clear)


def read_time(text: str) -> str:
    """Return the date and time in a platform's text, with the offset from UTC if the text has one; or an empty string.

    >>> read_time("Friday, 20 November 2026, 9:32 PM"), read_time("2026-11-20 21:45:00.25 UTC")
    ('2026-11-20 21:32', '2026-11-20 21:45+00:00')
    """
    text = " ".join(text.replace(" de ", " ").split())
    if _SAKAIS.fullmatch(text):
        text = f"{text[:14]} UTC"
    found = _DATE.search(text)
    moment = _moment(found) if found and found["hour"] else None
    if not moment:
        return ""
    zone: tzinfo | None = None
    if stated := _ZONE.search(text):
        try:
            region = stated["region"]
            zone = ZoneInfo(region) if region else UTC
            if stated["offset"]:
                zone = datetime.strptime(stated["offset"], "%z").tzinfo
        except (ValueError, LookupError, OSError):
            zone = None
    local = datetime.fromtimestamp(moment, UTC).replace(tzinfo=zone)
    return local.isoformat(" ", "minutes")


def without_weak_marks(name: str) -> str:
    """Return a name without what may be a date, a copy or a version; the whole name if nothing else is in it.

    >>> without_weak_marks("ada_20261120"), without_weak_marks("ada (1)"), without_weak_marks("20261120")
    ('ada', 'ada', '20261120')
    """
    rest = " ".join(filter(None, (piece.strip(_EDGES) for piece in _WEAK.split(name))))
    return rest if any(each.isalpha() for each in rest) and rest != name.strip(_EDGES) else name


def _moment(found: re.Match[str]) -> float | None:
    """Return the time of a date, 0 if day and month cannot be distinguished, and None if there is no such date."""
    if found["stamp"]:
        year, month, day = int(found["stamp"][:4]), int(found["stamp"][4:6]), int(found["stamp"][6:])
    elif found["name"] or found["name4"]:
        month = _MONTHS[(found["name"] or found["name4"]).lower()]
        year, day = int(found["year3"] or found["year4"]), int(found["day3"] or found["day4"])
    elif found["year"]:
        year, month, day = int(found["year"]), int(found["month"]), int(found["day"])
    else:
        year, day, month = int(found["year2"]), int(found["first"]), int(found["second"])
        if day <= 12 and month <= 12 and day != month and found["between"] != ".":
            return 0.0
        if month > 12:
            day, month = month, day
    hour, minutes, seconds = (int(found[each] or 0) for each in ("hour", "minutes", "seconds"))
    if found["half"]:
        hour = hour % 12 + (12 if found["half"].lower() == "p" else 0)
    if not (1 <= month <= 12 and 1 <= day <= 31 and hour < 24 and minutes < 60 and seconds < 61):
        return None
    return float(timegm((year, month, day, hour, minutes, seconds)))
