"""Names of students, made safe: as names of files, on a terminal and on a page."""

import hashlib
import re
import unicodedata

LONGEST_NAME = 100
_PLAIN = re.compile(r"[a-z0-9_][a-z0-9_.-]{0,59}(?<![.])")
_HASHED = re.compile(r".*-[0-9a-f]{16}")
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?")


def safe_name(student: str) -> str:
    """Return a file name for a student: no two have one, whatever the file system makes of upper and lower case.

    >>> safe_name("ada_lovelace")
    'ada_lovelace'
    >>> safe_name("../Ada")
    'ada-4e4af21652b78501'
    """
    ordinary = (
        _PLAIN.fullmatch(student) and not _HASHED.fullmatch(student) and not _RESERVED.fullmatch(student)
    )
    if ordinary:
        return student
    letters = unicodedata.normalize("NFKD", student).encode("ascii", "ignore").decode().lower()
    start = re.sub(r"[^a-z0-9_]+", "-", letters).strip("-")[:40] or "student"
    return f"{start}-{hashlib.sha256(student.encode('utf-8', 'surrogatepass')).hexdigest()[:16]}"


def clean_name(name: str) -> str:
    """Return a name without control characters or halves of characters, not too long, and still its own."""
    name = name.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")
    blank = "".join(f"\\x{ord(each):02x}" for each in name)  # what a name of nothing but spaces is called
    name = unicodedata.normalize("NFC", name).strip() or blank
    name = "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in name)
    if len(name) > LONGEST_NAME:
        name = f"{name[: LONGEST_NAME - 20]}...{hashlib.sha256(name.encode()).hexdigest()[:16]}"
    return name
