"""What a student's line gives in the oldest and in the newest versions of NumPy and OpenCV that the course supports.

docs/dependencies.md has the same lines with the message that the student gets. Run as a program, this prints what the
installed versions give.
"""

import json
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import cv2
import numpy as np


class Difference(NamedTuple):
    """A line of code, and what the oldest and the newest versions give: a value, or the name of an exception."""

    code: str
    oldest: Any
    newest: Any


PICTURE = cv2.line(np.zeros((60, 80), np.uint8), (5, 5), (70, 50), 255)
BOX = np.array([[0, 0], [2, 1], [1, 3], [-1, 2]], np.float32)
NAMES: dict[str, Any] = {"np": np, "cv2": cv2, "picture": PICTURE, "box": BOX, "one": np.array([1.5])}

DIFFERENCES = (
    Difference("float(one)", 1.5, "TypeError"),
    Difference("np.zeros(2).__setitem__(0, one)", None, "ValueError"),
    Difference("np.linalg.eig(np.eye(2))[0].dtype.name", "float64", "complex128"),
    Difference("np.cross([1, 0], [0, 1])", 1.0, "ValueError"),
    Difference("np.trapz([1, 2])", 1.5, "AttributeError"),
    Difference("np.row_stack([[1], [2]]).shape", [2, 1], "AttributeError"),
    Difference("cv2.HoughLinesP(picture, 1, np.pi / 180, 20, None, 10, 5).shape", [1, 1, 4], [1, 4]),
    Difference("cv2.createLineSegmentDetector().detect(picture)[0].shape", [2, 1, 4], [2, 4]),
    Difference("cv2.findNonZero(picture).shape", [66, 1, 2], [66, 2]),
    Difference("round(cv2.minAreaRect(box)[2])", 27.0, -63.0),
)


def result(code: str, run: Callable[..., Any] = eval) -> Any:
    """Return what a line gives: a number, text, list or None, or the name of an exception."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            value = run(code, dict(NAMES))
        except Exception as error:  # noqa: BLE001 - the exception is the result
            return type(error).__name__
    if value is None or isinstance(value, str):
        return value
    return list(value) if isinstance(value, tuple) else float(value)


if __name__ == "__main__":
    print(json.dumps({each.code: result(each.code) for each in DIFFERENCES}))
