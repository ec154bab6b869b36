"""Generated files that differ by rounding errors alone, because they were built on two kinds of processors."""

import json
import re
from base64 import b64decode
from collections.abc import Callable, Mapping, Sequence
from dataclasses import is_dataclass, replace
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import scipy.sparse

from nao_course.codec import encode
from nao_course.exercises.checking import unpack
from nao_course.exercises.earlier import EarlierCall
from nao_course.exercises.exercise import PublicExercise
from nao_course.exercises.judging import is_unstable

# Each tolerance has beside it the largest difference that the kernels for three kinds of processors made in a lesson.
DIGITS = 1e-5  # relative: 4e-6 where an iterative solver stops; the checks themselves compare with 1e-4
BESIDE = 1e-9  # of an array's largest element: 1e-10, in the small elements that sums of large ones leave
NOTHING = 1e-12  # absolute: 7e-18 where another processor has 0
PRINTED = 1e-6  # relative: none so far, so a number printed with six digits must be equal
MEAN = 0.05  # levels of 255 over a picture: 0.02; a line that is wider by a tenth of a point makes 0.08
# of 255 over a patch: 8; a curve moved by 0.3 pixels makes 17, a comma for a point in a title 12.
LEVELS = 10.0
PATCH = 8  # pixels: a block of a JPEG, and about as large as a digit or a marker in a figure
_DRAWN = re.compile(r"data:image/\w+;base64,([A-Za-z0-9+/=]+)")
_NUMBER = re.compile(r"(-?\d+(?:\.\d+)?(?:e[-+]?\d+)?)", re.IGNORECASE)


def same_but_for_rounding(suffix: str, there: bytes, built: bytes) -> bool:
    """Return whether a file has the same content as a newly built file.

    Check data, pictures and the outputs of notebooks may differ as two processors do. All that an author writes, such
    as cells, messages, tolerances and whole numbers, must be equal. Files of another kind than ".bin", ".ipynb", ".png"
    and ".jpeg" must be equal, too.
    """
    if there == built:
        return True
    compare = _KINDS.get(suffix)
    try:
        return compare is not None and compare(there, built)
    except Exception:  # noqa: BLE001 - a file that cannot be read, whyever, has to be written anew
        return False


# --- check data ---


def _lessons_alike(there: bytes, built: bytes) -> bool:
    """Return whether two lessons' check data are the same except for rounding."""
    lessons = [unpack(each) for each in (there, built)]
    calls = [[each.earlier for each in lesson.exercises] for lesson in lessons]
    rest = [
        replace(lesson, exercises=[replace(each, earlier=[], pairs=[]) for each in lesson.exercises])
        for lesson in lessons
    ]
    exercises = (lesson.exercises for lesson in lessons)
    return values_alike(*rest) and all(map(_calls_alike, *calls)) and all(map(_pairs_alike, *exercises))


def _pairs_alike(first: PublicExercise, second: PublicExercise) -> bool:
    """Return whether two exercises have the same pairs of mistakes; a pair with unstable answers may be absent."""
    one, other = ({pair.mistakes: pair for pair in each.pairs} for each in (first, second))
    unstable = {
        number
        for exercise in (first, second)
        for number, mistake in enumerate(exercise.mistakes)
        if any(map(is_unstable, mistake.answers.values()))
    }
    absent = one.keys() ^ other.keys()
    return all(values_alike(one[key], other[key]) for key in one.keys() & other.keys()) and all(
        unstable & set(key) for key in absent
    )


def _calls_alike(first: Sequence[EarlierCall], second: Sequence[EarlierCall]) -> bool:
    """Return whether the same calls were recorded; a call that repeats another up to rounding may be absent."""
    i = j = 0
    while i < len(first) or j < len(second):
        if i < len(first) and j < len(second) and values_alike(first[i], second[j]):
            i, j = i + 1, j + 1
        elif i < len(first) and any(values_alike(first[i], each) for each in first[:i]):
            i += 1
        elif j < len(second) and any(values_alike(second[j], each) for each in second[:j]):
            j += 1
        else:
            return False
    return True


def values_alike(first: Any, second: Any) -> bool:
    """Return whether two values are the same except for rounding; unstable answers of a mistake always are.

    Rounding may also decide whether an answer is unstable; then the answers are compared.
    """
    if is_unstable(first) and is_unstable(second):
        return True
    if is_unstable(first) or is_unstable(second):
        one, other = (each["unstable"] if is_unstable(each) else each for each in (first, second))
        return values_alike(one, other)
    if type(first) is not type(second):
        return False
    if scipy.sparse.issparse(first):
        return first.shape == second.shape and values_alike(first.toarray(), second.toarray())
    if isinstance(first, float | complex | np.inexact) or _holds_floats(first):
        one, other = np.asarray(first), np.asarray(second)
        return one.shape == other.shape and one.dtype == other.dtype and _near(one, other)
    if isinstance(first, Mapping):
        return first.keys() == second.keys() and all(values_alike(first[key], second[key]) for key in first)
    if isinstance(first, list | tuple):
        return len(first) == len(second) and all(map(values_alike, first, second))
    if is_dataclass(first):
        return values_alike(vars(first), vars(second))
    return encode(first) == encode(second)


def _holds_floats(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.kind in "fc"


def _near(first: npt.NDArray[Any], second: npt.NDArray[Any]) -> bool:
    """Return whether arrays are nearly equal; small elements of an array up to size 1 may differ by `BESIDE`."""
    size = float(np.max(np.abs(second[np.isfinite(second)]), initial=0.0))
    small = max(BESIDE * size, min(BESIDE, DIGITS * size), NOTHING) if first.ndim else NOTHING
    return np.allclose(first, second, DIGITS, small, equal_nan=True)


# --- outputs of notebooks ---


def _notebooks_alike(there: bytes, built: bytes) -> bool:
    first, second = json.loads(there), json.loads(built)
    outputs = [[cell.pop("outputs", None) for cell in each["cells"]] for each in (first, second)]
    return bool(first == second) and _outputs_alike(*outputs)


def _outputs_alike(first: Any, second: Any) -> bool:
    """Return whether two values of JSON are the same except for numbers and pictures in their texts."""
    if type(first) is not type(second):
        return False
    if isinstance(first, dict):
        return first.keys() == second.keys() and all(_outputs_alike(first[key], second[key]) for key in first)
    if isinstance(first, list):
        return len(first) == len(second) and all(map(_outputs_alike, first, second))
    return texts_alike(first, second) if isinstance(first, str) else bool(first == second)


def texts_alike(first: str, second: str) -> bool:
    """Return whether two outputs differ only in late digits of numbers and invisibly in pictures."""
    drawn = zip(*(map(b64decode, _DRAWN.findall(text)) for text in (first, second)), strict=True)
    parts = [_NUMBER.split(_DRAWN.sub("", text)) for text in (first, second)]
    return (
        parts[0][::2] == parts[1][::2]
        and all(map(_numbers_alike, parts[0][1::2], parts[1][1::2]))
        and all(pictures_alike(*both) for both in drawn)
    )


def _numbers_alike(first: str, second: str) -> bool:
    """Return whether two numbers in texts are equal, or nearly equal floats."""
    if first == second:
        return True
    floats = not (first.lstrip("-").isdigit() or second.lstrip("-").isdigit())
    return floats and bool(np.isclose(float(first), float(second), PRINTED, NOTHING))


# --- pictures ---


def pictures_alike(there: bytes, built: bytes) -> bool:
    """Return whether nobody sees a difference between two pictures, neither in a small patch nor overall."""
    if there == built:
        return True
    first, second = (
        cv2.imdecode(np.frombuffer(each, np.uint8), cv2.IMREAD_UNCHANGED) for each in (there, built)
    )
    if first is None or second is None or first.shape != second.shape:
        return False
    difference = np.abs(first.astype(np.float32) - second).reshape(*first.shape[:2], -1).max(axis=2)
    return bool(difference.mean() <= MEAN and cv2.blur(difference, (PATCH, PATCH)).max() <= LEVELS)


_KINDS: dict[str, Callable[[bytes, bytes], bool]] = {
    ".bin": _lessons_alike,
    ".ipynb": _notebooks_alike,
    ".png": pictures_alike,
    ".jpeg": pictures_alike,
}
