"""The versions that a notebook was written with, where they are newer than the versions that run here."""

from __future__ import annotations

import platform
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version

_LIBRARIES = ("nao-course", "numpy", "opencv-python-headless", "scipy")
_SPOKEN = {"python": "Python", "numpy": "NumPy", "opencv-python-headless": "OpenCV", "scipy": "SciPy"}
_MODULES = {"numpy": "numpy", "cv2": "opencv-python-headless", "scipy": "scipy"}
# Of Python 3.14. A new submodule is in a package that is known.
_NEW_MODULES = {"annotationlib", "compression"}
_NUMBERS = re.compile(r"(\d{1,4})\.(\d{1,4})(?:[.\w+-]{0,20})?", re.ASCII)
_NO_ARGUMENT = re.compile(r"(?:unexpected|invalid) keyword argument")
_NEW_SYNTAX = re.compile(r"SyntaxError\b")
_LACKS = re.compile(r"(?:module|from|No module named) '(\w+)[\w.]*'")


@cache
def installed_versions() -> dict[str, str]:
    """Return the versions of Python and of the libraries that a lesson's numbers depend on."""
    found = {"python": platform.python_version()}
    for name in _LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # OpenCV has several package names
            continue
    return found


def numbers(text: str) -> tuple[int, int]:
    """Return the first two numbers of a version; (0, 0) for anything else, because a notebook may hold any text."""
    found = _NUMBERS.fullmatch(text)
    return (int(found[1]), int(found[2])) if found else (0, 0)


def stated_versions(given: object) -> dict[str, str]:
    """Return the versions in what a receipt or notebook states, which may be any value."""
    stated = given if isinstance(given, Mapping) else {}
    texts = {name: stated[name] for name in _SPOKEN if isinstance(stated.get(name), str)}
    return {name: text for name, text in texts.items() if numbers(text) > (0, 0)}


def in_words(versions: Mapping[str, str]) -> str:
    """Return versions such as "Python 3.14, NumPy 2.4"; only what is a version is named.

    >>> in_words({"numpy": "2.4.6", "python": "3.14.0", "scipy": "<b>"})
    'Python 3.14, NumPy 2.4'
    """
    return ", ".join(
        f"{_SPOKEN[name]} {'.'.join(map(str, numbers(version)))}"
        for name, version in stated_versions(versions).items()
    )


@dataclass(frozen=True)
class Newer:
    """Versions of a notebook that are newer than the installed ones, both by name; false if there are none.

    The names are "python", "numpy", "opencv-python-headless" and "scipy".
    """

    theirs: Mapping[str, str]
    here: Mapping[str, str]

    def __bool__(self) -> bool:
        """Return whether a version is newer."""
        return bool(self.theirs)

    def against(self, place: str) -> str:
        """Return the versions in words: "Python 3.14, and the grader has Python 3.11"."""
        return f"{in_words(self.theirs)}, and {place} has {in_words(self.here)}"

    def explains(self, error: str) -> bool:
        """Return whether an error may come from the older version here, and not from the notebook.

        The error is an exception's type and message, possibly within a longer text.
        """
        python = "python" in self.theirs
        if (python and _NEW_SYNTAX.search(error)) or (self and _NO_ARGUMENT.search(error)):
            return True
        return any(
            _MODULES.get(name) in self.theirs
            or (python and (name in _MODULES or name in _NEW_MODULES or name in sys.stdlib_module_names))
            for name in _LACKS.findall(error)
        )


def newer_than_here(versions: Mapping[str, str]) -> Newer:
    """Compare the versions of a notebook, which are untrusted, with the installed versions."""
    here = installed_versions()
    names = [
        name for name in _SPOKEN if name in here and numbers(versions.get(name, "")) > numbers(here[name])
    ]
    return Newer({name: versions[name] for name in names}, {name: here[name] for name in names})
