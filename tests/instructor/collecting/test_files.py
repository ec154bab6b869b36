"""Files are read in parts, hashed as they were handed in, and large notebooks lose their outputs on the way."""

import hashlib
import json
import tracemalloc
from dataclasses import replace

import pytest

from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.files import LARGEST_READ, Files, read, submission_hash
from nao_course.instructor.collecting.submissions import Submission

LARGE = b"x" * (20 * LARGEST_READ)


def handed_in(path, content):
    path.write_bytes(content)
    return Submission("ada", "01_hsl_filtering", path)


def test_a_large_notebook_is_shortened_and_hashed_as_it_was_handed_in(tmp_path):
    given = []

    def shorten(name, size, parts):
        given.append((name, size, b"".join(parts)))
        return b"short"

    submission = handed_in(tmp_path / "in.ipynb", LARGE)
    files = read(submission, shorten)
    assert files.notebook == b"short"
    assert given == [("01_hsl_filtering.ipynb", len(LARGE), LARGE)]
    assert files.hash == submission_hash(submission) == Files(LARGE).hash
    assert read(submission, lambda name, size, parts: next(parts)).hash == files.hash, "of all that is there"


def test_a_small_notebook_is_read_as_it_is(tmp_path):
    submission = handed_in(tmp_path / "in.ipynb", b"x" * LARGEST_READ)
    files = read(submission, lambda *_: pytest.fail("it is not large"))
    assert files == Files(b"x" * LARGEST_READ, digest=hashlib.sha256(b"x" * LARGEST_READ).digest())


def test_earlier_notebooks_are_shortened_too_and_unreadable_ones_left_out(tmp_path):
    def shorten(name, size, parts):
        if name.startswith("02"):
            raise Refused("no notebook")
        return b"short"

    earlier = [handed_in(tmp_path / f"{n}.ipynb", LARGE) for n in (1, 2)]
    earlier[1] = replace(earlier[1], lesson="02_goalposts")
    submission = replace(
        handed_in(tmp_path / "3.ipynb", b"{}"), lesson="03_hough_corners", earlier=tuple(earlier)
    )
    files = read(submission, shorten)
    assert {lesson: each.notebook for lesson, each in files.earlier.items()} == {"01_hsl_filtering": b"short"}


def test_a_notebook_that_is_cut_while_it_is_read_is_refused(tmp_path):
    submission = handed_in(tmp_path / "in.ipynb", LARGE)

    def shorten(name, size, parts):
        next(parts)
        submission.path.write_bytes(b"")
        return b"".join(parts)

    with pytest.raises(Refused, match="it was changed while the grader was running"):
        read(submission, shorten)


def test_a_notebook_of_50_mb_takes_little_memory(tmp_path):
    text = "y" * (49 * 2**20)
    submission = handed_in(tmp_path / "in.ipynb", json.dumps({"cells": [], "metadata": {"a": text}}).encode())
    tracemalloc.start()
    try:
        read(submission, lambda name, size, parts: b"%d" % sum(map(len, parts)))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 4 * 2**20
