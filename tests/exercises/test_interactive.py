"""Calls that need a screen or a person do nothing or name themselves, and leave no trace in the process."""

import builtins
import sys
from types import FunctionType, SimpleNamespace

import cv2
import IPython.display
import matplotlib.pyplot as plt
import pytest

from nao_course.exercises import Case, call
from nao_course.exercises.interactive import _ASKS, _ENDS, _SHOWS, InteractiveCall, remark_on, unattended
from nao_course.exercises.running import outcome_of

HOMES = {"cv2": cv2, "matplotlib.pyplot": plt, "builtins": builtins, "IPython.display": IPython.display}


def spaces():
    held = {name: dict(vars(sys.modules[name])) for name in (*HOMES, "pdb", "code", "getpass")}
    return held, sys.stdin, [name for name in sys.modules if name.startswith("google.colab")]


@pytest.mark.parametrize("path", [*_SHOWS, *_ASKS, *_ENDS])
@pytest.mark.parametrize("renamed", [False, True], ids=["by its name", "by a name of its own"])
def test_each_call_is_found_by_any_name_and_everything_is_as_before_afterwards(path, renamed):
    home, _, name = path.rpartition(".")
    __import__(home) if home in sys.modules or home in HOMES else None
    if home not in sys.modules and not home.startswith("google.colab"):
        pytest.skip(f"{home} is not imported")
    before = spaces()
    space = {"mine": getattr(HOMES.get(home), name, None)}
    inside = f"import sys\n    return sys.modules[{home!r}].{name}(*x)"
    exec(f"def f(*x):\n    {'return mine(*x)' if renamed and space['mine'] else inside}", space)
    outcome = call(space["f"], Case((3,)))
    assert spaces() == before
    if path in _SHOWS:
        assert (outcome.status, outcome.value) == ("value", _SHOWS[path])
        assert outcome.shown == tuple(outcome.shown) and remark_on(outcome.shown)
    elif path in _ASKS:
        assert (outcome.status, outcome.errors[0]) == ("raised", InteractiveCall.__name__)
    else:
        assert outcome.errors[0] == "SystemExit"


def test_nothing_is_read_from_standard_input_there_is_no_shell_and_colabs_drive_fails_nowhere():
    class Quitter:
        def __call__(self):
            return "in Jupyter, it only ends the kernel later"

    Quitter.__module__ = "IPython.core.autocall"
    function = FunctionType((lambda x: exit()).__code__, {"exit": Quitter(), "__builtins__": builtins})
    assert call(function, Case((3,))).errors[0] == "SystemExit"
    assert call(lambda x: (sys.stdin.read(), get_ipython().system("ls")), Case((3,))).value == ("", None)  # noqa: F821

    def mounts(x):
        from google.colab import drive  # type: ignore[import-untyped]

        drive.mount("/content/drive")
        return x

    assert call(mounts, Case((3,))).value == 3


def test_a_block_leaves_an_outer_one_as_it_was_and_a_thread_replaces_nothing_in_the_process():
    with unattended() as outer:
        cv2.imshow("a", None)
        with unattended(SimpleNamespace()) as inner:
            plt.show()
        cv2.waitKey(1)
    assert (list(outer), list(inner)) == (["cv2.imshow", "cv2.waitKey"], ["plt.show"])
    before = builtins.input, sys.stdin
    assert outcome_of(lambda: (builtins.input, sys.stdin)).value == before
    assert call(lambda: builtins.input is before[0], Case(())).value is False
    assert (builtins.input, sys.stdin) == before
    assert remark_on(["42.1 hidden", "cv2.imshow"]) == remark_on(["cv2.imshow"]) != ""
    assert remark_on(["42.1 hidden"]) == remark_on([]) == ""
