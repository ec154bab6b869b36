"""One reader of text for all files that people made, and an output that no character can stop."""

from __future__ import annotations

import codecs
import io
import re
from typing import TextIO

_MARKS = (  # UTF-32 first, because its mark begins with the one of UTF-16
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    (codecs.BOM_UTF8, "utf-8-sig"),
)
_PLAIN = {  # signs of the course's own messages, for outputs whose encoding lacks them
    **dict(zip("✔✘○●•→←×", "+xo**><x", strict=True)),
    "…": "...",
    "≤": "<=",
    "≥": ">=",
    "²": "^2",
    "\u2212": "-",
    "\u2013": "-",
    "\u2014": "-",
    "\u2019": "'",
    **dict.fromkeys(map(chr, range(0x2500, 0x2580)), "+"),  # frames
    **dict.fromkeys("─━═", "-"),
    **dict.fromkeys("│┃║", "|"),
    **dict.fromkeys(map(chr, range(0x2800, 0x2900)), "*"),  # what turns while a command works
}
_HANDLER = "nao_course"
_BEYOND_ASCII = re.compile("[^\0-\x7f]")
_CONTROL = re.compile("[\0-\x08\x0e-\x1f\x7f]")


class NotTextError(ValueError):
    """Bytes (`data`) that are not text in a known encoding; the message says how to save the file."""

    def __init__(self, data: bytes | bytearray) -> None:
        super().__init__("it is not text in UTF-8, UTF-16 or Windows-1252. Save it as UTF-8")
        self.data = data


def decode_text(data: bytes | bytearray) -> str:
    r"""Decode text in UTF-8, UTF-16, UTF-32 or Windows-1252, with or without a byte order mark.

    Line ends are unchanged. Raise a NotTextError for other bytes, and if two encodings are mixed.

    >>> decode_text("café".encode("utf-16")), decode_text("café".encode("cp1252"))
    ('café', 'café')
    >>> decode_text(b"\x89PNG\r\n\x1a\n")
    Traceback (most recent call last):
    nao_course._internal.text_encodings.NotTextError: it is not text in UTF-8, UTF-16 or Windows-1252. Save it as UTF-8
    """
    encodings = [name for mark, name in _MARKS if data.startswith(mark)]
    if not encodings and b"\0" in data[:2]:
        encodings = ["utf-16-be" if data[0] == 0 else "utf-16-le"]
    for encoding in encodings[:1] or ("utf-8", "cp1252"):
        try:
            # A computer that lost power leaves zeros at a file's end
            text = data.decode(encoding).rstrip("\0")
        except UnicodeDecodeError:
            continue
        if "\0" in text or (encoding == "cp1252" and (_CONTROL.search(text) or _has_utf_8(data))):
            break
        return text
    raise NotTextError(data)


def _has_utf_8(data: bytes | bytearray) -> bool:
    """Return whether bytes that are not UTF-8 as a whole hold letters in UTF-8, as in two files that were joined."""
    return bool(_BEYOND_ASCII.search(data.decode("utf-8", "ignore")))


def write_any_character(*streams: TextIO) -> None:
    """Let streams replace each character that their encoding lacks, by a plain sign or a backslash escape."""
    codecs.register_error(_HANDLER, _replace_unencodable)
    for stream in streams:
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_HANDLER)


def _replace_unencodable(error: UnicodeError) -> tuple[str, int]:
    """Return what is written in place of the characters that cannot be encoded, and where to go on."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    plain = (_PLAIN.get(each) or each.encode("ascii", "backslashreplace").decode() for each in lacking)
    return "".join(plain), error.end
