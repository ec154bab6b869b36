"""The files of a submission, read with bounded memory and hashed."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from nao_course.exercises.notebook_text import LARGEST_HELPER, MOST_BYTES
from nao_course.instructor.collecting.archives import LARGEST_READ, Refused, in_parts, read_plain
from nao_course.instructor.collecting.submissions import Submission


@dataclass(frozen=True)
class Files:
    """The contents of a submission: the notebook, a large one without its outputs, and its helpers by name.

    `earlier` are readable notebooks of earlier lessons and their helpers, by the lesson's name. `digest` is the SHA-256
    of the notebook as it was handed in; by default of `notebook`.
    """

    notebook: bytes
    helpers: Mapping[str, bytes] = field(default_factory=dict)
    earlier: Mapping[str, Files] = field(default_factory=dict)
    digest: bytes = b""

    @property
    def hash(self) -> str:
        """SHA-256 of all of it."""
        digest = hashlib.sha256(self.digest or hashlib.sha256(self.notebook).digest())
        for name in sorted(self.helpers):
            digest.update(name.encode() + b"\0" + hashlib.sha256(self.helpers[name]).digest())
        for lesson in sorted(self.earlier):
            digest.update(lesson.encode() + b"\0" + self.earlier[lesson].hash.encode())
        return digest.hexdigest()


Shorten = Callable[[str, int, Iterator[bytes]], bytes]


def read(submission: Submission, shorten: Shorten | None = None) -> Files:
    """Read a submission's files, each of a bounded size and none through a link.

    `shorten` is called with name, size in bytes and content of a notebook with more than LARGEST_READ bytes, and
    returns it without its outputs or raises Refused; by default such a notebook is only hashed. Refused has the reason
    as its text.
    """
    if submission.reason:
        raise Refused(submission.reason)
    notebook, digest = _read_notebook(submission, shorten)
    helpers = {name: read_plain(path, LARGEST_HELPER) for name, path in submission.helpers}
    earlier = {}
    for each in submission.earlier:
        with contextlib.suppress(Refused):  # it costs what uses it, and nothing else
            earlier[each.lesson] = read(each, shorten)
    return Files(notebook, helpers, earlier, digest)


def _read_notebook(submission: Submission, shorten: Shorten | None) -> tuple[bytes, bytes]:
    """Return a notebook, without its outputs if it is large, and the hash of the whole."""
    with in_parts(submission.path, MOST_BYTES) as (size, parts):
        if size > LARGEST_READ:
            digest = hashlib.sha256()

            def hashed() -> Iterator[bytes]:
                for part in parts:
                    digest.update(part)
                    yield part

            short = shorten(f"{submission.lesson}.ipynb", size, hashed()) if shorten else b""
            for _ in hashed():  # what was not asked for
                pass
            return short, digest.digest()
        notebook = b"".join(parts)
    if not notebook.strip():
        raise Refused("it is empty")
    return notebook, hashlib.sha256(notebook).digest()


def submission_hash(submission: Submission) -> str:
    """Return the hash of the submission, or of the reason if it cannot be read."""
    try:
        return read(submission).hash
    except Refused as refused:
        return hashlib.sha256(f"{submission.file}\0{refused}".encode()).hexdigest()
