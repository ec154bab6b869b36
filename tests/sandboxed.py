"""What the sandbox's tests share: a layer that is missing, and a notebook that runs what it is told."""

import os
from collections.abc import Iterable
from pathlib import Path

import pytest

from nao_course.exercises import Case
from nao_course.exercises.running import Outcome
from nao_course.instructor.sandbox.layers import Layer, Sandbox, probe
from nao_course.instructor.sandbox.worker import Worker
from tests.toy import toy

REQUIRE = "NAO_COURSE_REQUIRE_SANDBOX"
ATTACKER = """
import ctypes, errno, os, signal, socket, subprocess, sys, threading, time
libc = ctypes.CDLL(None, use_errno=True)

def checked(result):
    if result < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return result

def attempt(source, *args):
    lines = source.splitlines()
    names = globals() | {"args": args}
    exec("\\n".join(lines[:-1]), names)
    return repr(eval(lines[-1], names))
"""


def need(*layers: str) -> Sandbox:
    """The machine's sandbox; skips the test, or fails where it is required, if one of some layers is missing."""
    sandbox = probe()
    missing = [layer for layer in sandbox.layers if layer.name in layers and not layer.on]
    if missing:
        reason = "; ".join(f"no {layer.name}: {layer.detail}" for layer in missing)
        if os.environ.get(REQUIRE) == "1":
            pytest.fail(f"{REQUIRE}=1, but {reason}")
        pytest.skip(reason)
    return sandbox


def only(*layers: str) -> Sandbox:
    """A sandbox with no more of Linux's layers than some, so that none can hide behind another."""
    sandbox = need(*layers)
    return Sandbox(tuple(Layer(each.name, each.name in layers, each.detail) for each in sandbox.layers))


def attacker(folder: Path) -> Path:
    return toy.write(folder / "attacker.ipynb", ATTACKER)


def attempt(worker: Worker, source: str, *args: object) -> Outcome:
    """What the attacker's code comes to: its last line is an expression."""
    return worker.call("attempt", Case((source.strip(), *args)))


def denied(outcome: Outcome, *errors: str) -> bool:
    """Whether the kernel said no."""
    return outcome.status == "raised" and outcome.text.startswith(
        errors or ("PermissionError", "FileNotFoundError")
    )


def quickly(values: Iterable[object], *some: object) -> list[object]:
    """Values to parametrize with, of which all but some are for the slow tests."""
    return [value if value in some else pytest.param(value, marks=pytest.mark.slow) for value in values]


def crossed(first: Iterable[object], second: Iterable[object]) -> list[object]:
    """Pairs to parametrize with: each value comes once in the quick tests, the rest of the table in the slow ones."""
    first, second = list(first), list(second)
    return [
        pytest.param(one, other, marks=[] if one == first[0] or other == second[0] else pytest.mark.slow)
        for one in first
        for other in second
    ]
