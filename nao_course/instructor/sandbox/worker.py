"""The grader's end of a worker: a student's functions, called in a process of their own that is killed as a whole.

Whatever the process says or does, its caller gets an `Outcome` in time.
"""

import contextlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any, Self

import numpy as np

from nao_course.codec import CodecError, encode
from nao_course.exercises.case import Case
from nao_course.exercises.definitions import Skipped
from nao_course.exercises.notebook_text import MOST_BYTES, MOST_WRITTEN
from nao_course.exercises.running import Outcome
from nao_course.instructor.sandbox.processes import start_process, wait_until_ready
from nao_course.instructor.sandbox.protocol import (
    MOST_NOTES,
    MOST_OUTPUT,
    UNREADABLE,
    Allowance,
    Channel,
    EarlierNotebook,
    Ended,
    ended_from_outside,
    printable,
)
from nao_course.instructor.sandbox.warm_server import WarmServer

MOST_TEXT = 1000  # characters of an exception's message
MOST_SKIPPED = 1000  # statements that are listed as not run
MOST_WRITTEN_ANSWERS = 100
MOST_REMARKS = 5  # on an exercise or question
MOST_LEFT_OUT = 5  # statements that may end a process while it loads; each is left out in the next one
MOST_LEFT_OUT_EARLIER = 2  # of an earlier lesson's notebook; then all of it is
MOST_ASKED = 20_000  # requests of one call for reference functions,
MOST_ASKED_BYTES = 512 * 2**20  # and their size
TOO_OFTEN = "too often"  # how the reason ends when there were more
_SAID = ("value", "not attempted", "raised", "interrupted", "unsendable")  # all else only the grader can know


@dataclass(frozen=True)
class Found:
    """The functions and classes in a worker's notebook, statements that did not run, and written answers by cell name.

    `lesson`, `version` and `python` are what the notebook says it is a copy of, and which Python it was written with.
    `remarks` say what is unusual about the cells of an exercise or question, by its name.
    """

    names: tuple[str, ...] = ()
    skipped: tuple[Skipped, ...] = ()
    written: Mapping[str, str] = field(default_factory=dict)
    lesson: str = ""
    version: str = ""
    python: str = ""
    remarks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


@dataclass
class Worker:
    """A notebook's functions, in a process that starts when it is needed, and again after it had to be killed.

    `overrides`, sources of functions that replace the notebook's, and `allowance`, for its calls, may be changed
    between calls. `seconds` limit loading the notebook, and each call, in which the worker runs or sleeps. Workers of
    the server see copies of notebook and `helpers`, Python files handed in beside it, in a folder of their own; without
    a server, for notebooks that are trusted, the worker is a new Python with the notebook's folder as its working
    folder. The imports of `setup`, a cell's source, run before the notebook. `earlier` are the notebooks of earlier
    lessons, in their order, whose functions it uses, and `instead` sources of classes that replace the notebook's while
    it is loaded. `loading` is an allowance for every time that a process has to be started. `call` and `definitions`
    raise a SandboxError if a worker could not be confined, and ServerEnded if the warm server died: grade the
    submission again.

    ::

        with Worker(Path("solutions/01_hsl_filtering.ipynb")) as worker:
            outcome = worker.call("white_threshold", Case((120.0,)))
    """

    notebook: Path
    overrides: Mapping[str, str] = field(default_factory=dict)
    seconds: float = 10.0
    server: WarmServer | None = None
    setup: str = ""
    helpers: Sequence[Path] = ()
    earlier: Sequence[EarlierNotebook] = ()
    instead: Mapping[str, str] = field(default_factory=dict)
    allowance: Allowance = field(default_factory=Allowance)
    loading: Allowance | None = None
    _channel: Channel | None = field(default=None, init=False, repr=False)
    _lent: dict[str, Callable[[tuple[Any, ...], dict[str, Any]], Outcome]] = field(
        default_factory=dict, init=False, repr=False
    )
    _defined: tuple[dict[str, str], list[str]] = field(
        default_factory=lambda: ({}, []), init=False, repr=False
    )
    _found: Found = field(default_factory=Found, init=False, repr=False)
    _failed: Ended | None = field(default=None, init=False, repr=False)
    _left_out: dict[tuple[int, int], str] = field(default_factory=dict, init=False, repr=False)
    _announces: bool = field(default=False, init=False, repr=False)
    _left_out_earlier: dict[str, list[tuple[int, int]]] = field(default_factory=dict, init=False, repr=False)
    _noted: dict[str, None] = field(default_factory=dict, init=False, repr=False)
    _deaths: int = field(default=0, init=False, repr=False)
    _calls: int = field(default=0, init=False, repr=False)
    _served: set[str] = field(default_factory=set, init=False, repr=False)

    def __enter__(self) -> Self:
        """Return the worker; its process starts with the first call."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the process and all that it started."""
        self.close()

    def close(self) -> None:
        """End the process and all that it started; a further call starts a new one."""
        if self._channel:
            self._channel.kill()
            self._channel = None

    @property
    def definitions(self) -> Found:
        """What the notebook defines; nothing, with a reason, where it cannot be loaded."""
        try:
            self._running()
        except Ended as ended:
            self.close()
            self._count(ended)
            return Found(skipped=(Skipped(0, 0, ended.outcome.text),))
        except BaseException:  # half an answer may be on its way
            self.close()
            raise
        return self._found

    def has_served_others(self, name: str) -> bool:
        """Return True if its process has called functions other than a given one."""
        return not self._served <= {name}

    @property
    def notes(self) -> tuple[str, ...]:
        """What the sandbox saw the student's code try; it may see less than there was."""
        return tuple(self._noted)

    @property
    def deaths(self) -> int:
        """How many of its processes may have been ended by someone outside, or for want of memory on the machine."""
        return self._deaths

    def stand_in(self, answers: Mapping[str, Callable[[tuple[Any, ...], dict[str, Any]], Outcome]]) -> None:
        """Replace functions of the notebook, and "01:earlier" ones, by stubs that request their answers here.

        They are called with the arguments and keyword arguments that came from the worker, and their outcome goes
        there; their time is not the student's. An empty mapping ends it.
        """
        self._lent = dict(answers)

    def call(self, name: str, case: Case, driver: str = "", seconds: float | None = None) -> Outcome:
        """Call a function or class.

        The case's expected answer stays here; the driver is as in `running.call`, and `seconds` limit this call in
        place of the worker's limit. There is an outcome whatever the student's code does.
        """
        self._calls += 1
        question = encode(("call", self._calls, name, driver)) + case.frame
        try:
            channel = self._running()
            if name not in self._found.names:
                return Outcome("not found")
            with self._asking(channel, question, self.allowance, seconds):
                self._served.add(name)
                said = self._answering(channel)
            match said:
                case (int(number), outcome) if number == self._calls and _well_formed(outcome):
                    return _shortened(outcome)
                case _:
                    channel.give_up()
        except Ended as ended:
            self.close()
            self._count(ended)
            return ended.outcome
        except BaseException:  # Ctrl-C within an answer: the next call must not read the rest of it
            self.close()
            raise

    @contextlib.contextmanager
    def _asking(
        self,
        channel: Channel,
        frame: bytes | bytearray,
        allowance: Allowance | None = None,
        seconds: float | None = None,
    ) -> Iterator[None]:
        """Send a request, and count the worker's time in the block: for loading unless said otherwise."""
        allowance = allowance or self.loading or self.allowance
        most = self.seconds if seconds is None else seconds
        left = allowance.left(most)
        try:
            channel.ask(frame, left)
            yield
        except Ended as ended:
            if ended.outcome.status == "timed out" and left < most:
                raise Ended("timed out", allowance.reason) from None
            raise
        finally:
            allowance.spend(channel.used())

    def _count(self, ended: Ended) -> None:
        self._deaths += ended.outcome.status == "died" and ended_from_outside(ended.outcome.text)

    def _next(self, channel: Channel) -> Any:
        """Return the worker's next message that is not a report of a denied attempt."""
        while True:
            said = channel.receive()
            first = said[0] if isinstance(said, tuple) and said else said
            if isinstance(first, np.ndarray):  # comparing it with a word would raise
                channel.give_up()
            match said:
                case ("attempt", str(text)):
                    if len(self._noted) < MOST_NOTES:
                        self._noted[printable(text[:200])] = None
                case _:
                    return said

    def _answering(self, channel: Channel) -> Any:
        """Return the worker's next result, and answer its requests before it."""
        asked, size = 0, channel.size
        while True:
            match self._next(channel):
                case ("ask", str(name), tuple(args), dict(kwargs)) if name in self._lent:
                    asked += 1
                    if asked > MOST_ASKED or channel.size - size > MOST_ASKED_BYTES:
                        raise Ended("died", f"it called {name} {TOO_OFTEN}")
                    began = time.monotonic()
                    try:
                        answer = encode(("answer", self._lent[name](args, kwargs)))
                    except CodecError as error:  # what came just fitted; with what goes along, it does not
                        answer = encode(("answer", Outcome("unsendable", text=str(error))))
                    channel.exclude(time.monotonic() - began)
                    channel.send(answer)
                case said:
                    return said

    def _running(self) -> Channel:
        """Return the channel to a process that has loaded the notebook and the overrides.

        A statement that ends the process or its time is left out: the rest of the notebook counts. To find out which
        one it is, the next process announces each statement before it runs.
        """
        while self._channel is None:
            if self._failed:
                raise self._failed.with_traceback(None)  # else each call would add to it
            content = self._content()
            self._channel = self._start()
            left_out = len(self._left_out)
            try:
                wait_until_ready(self._channel)
                if not all(self._load_earlier(self._channel, each) for each in self.earlier):
                    continue
                self._load(self._channel, content)
            except Ended as ended:
                self.close()
                self._count(ended)
                if ended.outcome.status != "not found" and not self._announces:
                    self._announces = True
                elif left_out in (MOST_LEFT_OUT, len(self._left_out)):
                    self._failed = ended
        told = (dict(self.overrides), sorted(self._lent))
        if self._defined != told:
            with self._asking(self._channel, encode(("define", *told))):
                self._found = replace(self._found, names=_texts(self._next(self._channel)))
            self._defined = told
        return self._channel

    def _content(self) -> tuple[bytes, dict[str, bytes]] | None:
        """Return the notebook and helpers for a worker that cannot read their files."""
        if not self.notebook.is_file():
            raise Ended("not found", f"{self.notebook.name}: there is no such file")
        if self.server is None:
            return None
        if sum(path.stat().st_size for path in (self.notebook, *self.helpers)) > MOST_BYTES:
            raise Ended("not found", f"{self.notebook.name}: larger than {MOST_BYTES // 2**20} MB")
        return self.notebook.read_bytes(), {path.name: path.read_bytes() for path in self.helpers}

    def _start(self) -> Channel:
        """Start a new process for a trusted or an untrusted notebook."""
        (self.loading or self.allowance).left()
        self._defined, self._served = ({}, []), set()
        return start_process(self.server, self.notebook.parent)

    def _load_earlier(self, channel: Channel, earlier: EarlierNotebook) -> bool:
        """Load an earlier lesson's notebook in the worker; return False if that ended the process."""
        left_out = self._left_out_earlier.setdefault(earlier.lesson, [])
        if len(left_out) >= MOST_LEFT_OUT_EARLIER:
            return True
        content = (earlier.content, dict(earlier.helpers))
        places = [list(place) for place in left_out]
        request = encode(("earlier", earlier.lesson, content, earlier.setup, places, self._announces))
        at = (0, 0)
        try:
            with self._asking(channel, request):
                while (said := self._next(channel)) != "loaded":
                    match said:
                        case ("at", int(cell), int(line)):
                            at = (cell, line)
                        case _:
                            channel.give_up()
        except Ended as ended:
            self.close()
            self._count(ended)
            if self._announces:
                left_out.append(at)
            self._announces = True
            return False
        return True

    def _load(self, channel: Channel, content: tuple[bytes, dict[str, bytes]] | None) -> None:
        """Load the notebook in the worker, and note the statement that ends it if it announces them."""
        left_out = [list(place) for place in self._left_out]
        request = (
            "load",
            self.notebook.name,
            content,
            self.setup,
            left_out,
            self._announces,
            dict(self.instead),
        )
        at = None
        try:
            with self._asking(channel, encode(request)):
                while True:
                    match self._next(channel):
                        case ("at", int(cell), int(line)):
                            at = (cell, line)
                        case ("refused", str(reason)):
                            at = None
                            raise Ended("not found", printable(reason))
                        case (
                            "found",
                            [*names],
                            [*skipped],
                            dict(written),
                            str(lesson),
                            str(version),
                            str(python),
                            dict(remarks),
                        ):
                            told = tuple(self._skipped(each) for each in skipped[:MOST_SKIPPED])
                            self._found = Found(
                                _texts(names),
                                told,
                                _answers(written),
                                lesson[:100],
                                version[:100],
                                python[:20],
                                _remarks(remarks),
                            )
                            return
                        case _:
                            channel.give_up()
        except Ended as ended:
            if at:
                self._left_out[at] = ended.outcome.text
            raise

    def _skipped(self, statement: Any) -> Skipped:
        match statement:
            case (int(cell), int(line), str(reason)):
                return Skipped(cell, line, self._left_out.get((cell, line), printable(reason)))
        raise Ended("died", UNREADABLE)


def _texts(values: Any) -> tuple[str, ...]:
    if isinstance(values, list) and all(isinstance(each, str) for each in values):
        return tuple(values)
    raise Ended("died", UNREADABLE)


def _answers(written: dict[str, Any]) -> dict[str, str]:
    if all(isinstance(text, str) for text in written.values()):
        some = islice(written.items(), MOST_WRITTEN_ANSWERS)
        return {name[:100]: text[:MOST_WRITTEN] for name, text in some}
    raise Ended("died", UNREADABLE)


def _remarks(remarks: dict[str, Any]) -> dict[str, tuple[str, ...]]:
    some = islice(remarks.items(), MOST_WRITTEN_ANSWERS)
    return {name[:100]: tuple(map(printable, _texts(texts)[:MOST_REMARKS])) for name, texts in some}


def _well_formed(outcome: Any) -> bool:
    """Return True if all fields of an untrusted outcome have the right types."""
    match outcome:
        case Outcome(
            status=str(status),
            text=str(),
            line=str(),
            changed=bool(),
            output=str(),
            errors=tuple(errors),
            shown=tuple(shown),
        ):
            return status in _SAID and all(isinstance(each, str) for each in (*errors, *shown))
    return False


def _shortened(outcome: Outcome) -> Outcome:
    """Return an outcome with its texts cut to the length that a correct worker uses."""
    text, line = outcome.text[:MOST_TEXT], outcome.line[:MOST_TEXT]
    return replace(outcome, text=text, line=line, output=outcome.output[:MOST_OUTPUT])
