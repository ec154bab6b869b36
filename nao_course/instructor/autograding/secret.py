"""The instructor's secret, from which hidden cases are drawn: outside the repository, and made at first use."""

import hashlib
import hmac
import os
import secrets
import stat
import sys
from pathlib import Path

import typer

VARIABLE = "NAO_COURSE_SECRET"
FEWEST = 16  # bytes


class SecretError(ValueError):
    """A secret that cannot be used; the message says what to do."""


def secret_path() -> Path:
    """Return the path of the secret: $NAO_COURSE_SECRET, or a file in the user's configuration."""
    named = os.environ.get(VARIABLE)
    return Path(named) if named else Path(typer.get_app_dir("nao-course")) / "secret"


def load_secret() -> bytes:
    """Read the secret; where nothing names one and there is none, make it, for this user's eyes only.

    It has at least 16 bytes. Raise a SecretError if it cannot be read or made, is too short, or other users may read
    it.
    """
    path = secret_path()
    try:
        if not path.exists() and not os.environ.get(VARIABLE):
            _make(path)
        with path.open("rb") as file:
            mode = os.fstat(file.fileno()).st_mode
            content = file.read(2**16).strip()
    except FileNotFoundError:
        raise SecretError(
            f"{VARIABLE} names {path}, which does not exist. Copy your secret there, because with another one "
            f"everything is graded again, or unset {VARIABLE}; a new secret is created only in your configuration"
        ) from None
    except OSError as error:
        raise SecretError(
            f"cannot read the secret {path} ({error.strerror}): hidden cases are drawn from it"
        ) from None
    if sys.platform != "win32" and stat.S_IMODE(mode) & 0o077:
        raise SecretError(f"others may read the secret {path}: say `chmod 600 {path}`")
    if len(content) < FEWEST:
        raise SecretError(
            f"the secret {path} has {len(content)} bytes; it must have at least {FEWEST} random bytes"
        )
    return content


def _make(path: Path) -> None:
    """Write a new secret, whole or not at all; if another grader is faster, its secret stays."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f".{path.name}.{secrets.token_hex(8)}")
    descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(secrets.token_hex(32).encode() + b"\n")
        try:
            os.link(beside, path)
        except FileExistsError:
            return
    finally:
        beside.unlink(missing_ok=True)


def keyed(secret: bytes, *words: str) -> str:
    """Return the HMAC-SHA256 of words under a secret, in hexadecimal: the same each time, and of no use without it."""
    return hmac.new(secret, "\0".join(words).encode(), hashlib.sha256).hexdigest()


def student_code(secret: bytes, student: str) -> str:
    """Return a code that replaces a student's name where marking is anonymous; without the secret it names nobody.

    >>> student_code(b"0123456789abcdef", "ada")
    'student-8d789114d3'
    """
    return f"student-{keyed(secret, 'anonymous marking', student)[:10]}"
