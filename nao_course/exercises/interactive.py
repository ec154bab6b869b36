"""Calls that need a screen or a person, which a check in a notebook, a terminal and the grader treat alike."""

from __future__ import annotations

import builtins
import getpass  # noqa: F401 - so that its functions can be replaced before a student's code imports it
import io
import pdb  # noqa: F401 - so, too
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any, NoReturn

_PERSON = (
    "waits for a person to type or click, which the grader cannot do: use the function's arguments instead"
)
_DEBUGGER = "starts a debugger, which the grader does not have: remove it"
# What shows something does nothing in a check, and returns this value.
_SHOWS: dict[str, Any] = {
    **dict.fromkeys(
        f"cv2.{name}"
        for name in (
            *("imshow", "namedWindow", "destroyWindow", "destroyAllWindows", "moveWindow", "resizeWindow"),
            *("setWindowTitle", "setWindowProperty", "startWindowThread", "createTrackbar", "setTrackbarPos"),
            *("setTrackbarMin", "setTrackbarMax", "setMouseCallback"),
        )
    ),
    **dict.fromkeys(("cv2.waitKey", "cv2.waitKeyEx", "cv2.pollKey"), -1),  # no key was pressed
    "cv2.getTrackbarPos": 0,
    "cv2.getWindowProperty": -1.0,
    **dict.fromkeys(("matplotlib.pyplot.show", "matplotlib.pyplot.pause", "PIL.ImageShow.show")),
    **dict.fromkeys(("builtins.display", "IPython.display.display", "IPython.display.clear_output")),
    **dict.fromkeys(("google.colab.patches.cv2_imshow", "google.colab.files.download")),
    **dict.fromkeys(("google.colab.drive.mount", "google.colab.drive.flush_and_unmount")),
}
_ASKS: dict[str, str] = {
    **dict.fromkeys(("builtins.input", "getpass.getpass", "cv2.selectROI", "cv2.selectROIs"), _PERSON),
    "google.colab.files.upload": _PERSON,
    **dict.fromkeys(("matplotlib.pyplot.ginput", "matplotlib.pyplot.waitforbuttonpress"), _PERSON),
    **dict.fromkeys(("builtins.breakpoint", "pdb.set_trace", "pdb.post_mortem", "ipdb.set_trace"), _DEBUGGER),
    **dict.fromkeys(("code.interact", "IPython.embed"), _DEBUGGER),
}
_ENDS = ("builtins.exit", "builtins.quit")  # in Jupyter they only end the kernel after the cell
_COLAB = "google.colab"
_SPOKEN = {
    "builtins.": "",
    "matplotlib.pyplot.": "plt.",
    f"{_COLAB}.patches.": "",
    f"{_COLAB}.": "",
    "IPython.display.": "",
}
_shown: dict[str, None] = {}  # names of calls that did nothing in the running block


class InteractiveCall(RuntimeError):  # noqa: N818 - it is a call, and the message says what is wrong with it
    """Raised by a call that needs a person; the message is for the student."""


def _spoken(path: str) -> str:
    """Return the name by which students call a function."""
    return next(
        (short + path.removeprefix(long) for long, short in _SPOKEN.items() if path.startswith(long)), path
    )


def _stand_in(path: str) -> Callable[..., Any]:
    name = _spoken(path)

    def shows(*_: object, **__: object) -> Any:
        _shown[name] = None
        return _SHOWS[path]

    def asks(*_: object, **__: object) -> NoReturn:
        raise InteractiveCall(f"{name}() {_ASKS[path]}")

    def ends(*_: object) -> NoReturn:
        raise SystemExit

    function = shows if path in _SHOWS else asks if path in _ASKS else ends
    function.__name__ = function.__qualname__ = path.rpartition(".")[2]
    return function


_STAND_INS: dict[str, dict[str, Callable[..., Any]]] = {}  # by module and name
for _path in (*_SHOWS, *_ASKS, *_ENDS):
    _STAND_INS.setdefault(_path.rpartition(".")[0], {})[_path.rpartition(".")[2]] = _stand_in(_path)
SHOWS = frozenset(map(_spoken, _SHOWS))  # names that `remark_on` knows
_FAKE_COLAB = {name: ModuleType(name) for name in (_COLAB, *_STAND_INS) if name.startswith(_COLAB)}
for _name, _module in _FAKE_COLAB.items():
    vars(_module).update(_STAND_INS.get(_name, {}))
    vars(_FAKE_COLAB[_COLAB])[_name.rpartition(".")[2]] = _module
_MISSING = object()
_EMPTY_INPUT = io.StringIO()


class _NoShell:
    """What `get_ipython()` returns outside of IPython: each of its methods does nothing."""

    def __getattr__(self, name: str) -> Callable[..., None]:
        return lambda *_, **__: None


@contextmanager
def unattended(*functions: object) -> Iterator[dict[str, None]]:
    """Replace all interactive functions in the block.

    Functions that show something do nothing, and functions that ask a person raise `InteractiveCall`. Standard input is
    empty. Modules of the `functions` may hold interactive functions under other names, which are replaced too. The
    yielded dict grows with the names of the functions that did nothing.
    """
    global _shown
    before: list[tuple[dict[str, Any], str, Any]] = []
    stand_in_of: dict[int, Callable[..., Any]] = {}  # by the identity of the function that it replaces

    def put(space: dict[str, Any], name: str, value: Any) -> None:
        before.append((space, name, space.get(name, _MISSING)))
        space[name] = value

    outer, _shown = _shown, {}
    try:
        for module, functions_of in _STAND_INS.items():
            if home := sys.modules.get(module):
                for name, stand_in in functions_of.items():
                    put(vars(home), name, stand_in)
                    stand_in_of[id(before[-1][2])] = stand_in
        for space in map(_namespace, functions):
            for name in [name for name, value in space.items() if id(value) in stand_in_of]:
                put(space, name, stand_in_of[id(space[name])])
            for name in ("exit", "quit"):  # IPython puts its own into the notebook's namespace
                if type(space.get(name)).__module__.startswith("IPython."):
                    put(space, name, _STAND_INS["builtins"][name])
        if not hasattr(builtins, "get_ipython"):
            put(vars(builtins), "get_ipython", _NoShell)
        if _COLAB not in sys.modules:
            for name, fake in _FAKE_COLAB.items():
                put(sys.modules, name, fake)
        put(vars(sys), "stdin", _EMPTY_INPUT)
        yield _shown
    finally:
        _shown = outer
        for space, name, value in reversed(before):
            if value is _MISSING:
                space.pop(name, None)
            else:
                space[name] = value


def _namespace(function: object) -> dict[str, Any]:
    """Return the global names of a function, or of the module that defines a class."""
    module = sys.modules.get(str(getattr(function, "__module__", "")))
    found = getattr(function, "__globals__", None) or vars(module or object)
    return found if type(found) is dict else {}


def remark_on(shown: Iterable[str]) -> str:
    """Return a sentence about calls that did nothing; empty without any.

    Names of other calls are ignored, because an untrusted process may have sent them.
    """
    names = [name for name in dict.fromkeys(shown) if name in SHOWS]
    if not names:
        return ""
    listed = " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
    verb, them = ("opens", "it") if len(names) == 1 else ("open", "them")
    return (
        f"{listed} {verb} a window or show{'s' if len(names) == 1 else ''} a value, which checks and the grader leave "
        f"out: remove {them} before you hand in."
    )
