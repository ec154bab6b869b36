"""A student's functions in a process of their own: called with a time limit, killed as a whole.

The two processes speak frames of the codec over pipes. The worker is told the notebook and the inputs of calls, and
never what is expected. What it answers is read as a stranger's: whatever it is, the caller gets an `Outcome`.
"""

from __future__ import annotations

import contextlib
import io
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NoReturn, Self, get_args

from nao_course.exercises.codec import PREFIX_SIZE, CodecError, Limits, decode, encode, frame_lengths
from nao_course.exercises.definitions import Definitions, Skipped, load_definitions
from nao_course.exercises.exercise import Case
from nao_course.exercises.running import Came, Outcome, call_as_it_is, encoded

REPLY = Limits(size=64 * 2**20)
MOST_OUTPUT = 8 * 2**10  # bytes of what a call prints that are kept
MOST_LEFT_OUT = 5  # statements that may end a process while it loads; each is left out in the next one
UNREADABLE = "its answer could not be read"
SECONDS_TO_START = 60.0  # Python and numpy, on a machine that is busy
_KEPT = (
    "PYTHONPATH",
    "PATH",
    "SYSTEMROOT",
    "TEMP",
    "TMP",
    "TMPDIR",
    "LANG",
    "LC_ALL",
    "LD_LIBRARY_PATH",
    "NAO_COURSE_DATA",
)
_SET = {
    "MPLBACKEND": "Agg",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
}


class Ended(Exception):  # noqa: N818 - no error: students' processes end
    """A worker gave no answer that can be used.

    Parameters
    ----------
    came : str
        "timed out", "died", or "not found" where there is no notebook to load.
    text : str
        How it ended.
    """

    def __init__(self, came: Came, text: str) -> None:
        super().__init__(text)
        self.outcome = Outcome(came, text=text)


@dataclass(frozen=True)
class Found:
    """What a worker found in its notebook.

    Parameters
    ----------
    names : tuple of str
        Functions and classes that it defines.
    skipped : tuple of Skipped
        Statements that did not run.
    """

    names: tuple[str, ...] = ()
    skipped: tuple[Skipped, ...] = ()


@dataclass
class Worker:
    """A notebook's functions, in a process that starts when it is needed, and again after it had to be killed.

    Parameters
    ----------
    notebook : Path
        Whose functions are called; its folder is the process's working folder.
    overrides : mapping of str to str
        Source of functions that take the place of the notebook's; may be changed between calls.
    seconds : float
        Wall clock for loading the notebook, and for each call.

    Examples
    --------
    ::

        with Worker(Path("solutions/01_hsl_filtering.ipynb")) as worker:
            outcome = worker.call("white_threshold", Case((120.0,)))
    """

    notebook: Path
    overrides: Mapping[str, str] = field(default_factory=dict)
    seconds: float = 10.0
    _channel: _Channel | None = field(default=None, init=False, repr=False)
    _defined: Mapping[str, str] = field(default_factory=dict, init=False, repr=False)
    _found: Found = field(default_factory=Found, init=False, repr=False)
    _failed: Ended | None = field(default=None, init=False, repr=False)
    _left_out: dict[tuple[int, int], str] = field(default_factory=dict, init=False, repr=False)
    _calls: int = field(default=0, init=False, repr=False)

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
            return Found(skipped=(Skipped(0, 0, ended.outcome.text),))
        return self._found

    def call(self, name: str, case: Case, driver: str = "") -> Outcome:
        """Call a function or class.

        Parameters
        ----------
        name : str
            Of what the notebook defines.
        case : Case
            Its inputs; what is expected of it stays here.
        driver : str
            As in `running.call`.

        Returns
        -------
        Outcome
            Whatever the student's code does.
        """
        self._calls += 1
        question = encode(("call", self._calls, name, case.args, case.kwargs, driver))
        try:
            channel = self._running()
            if name not in self._found.names:
                return Outcome("not found")
            channel.ask(question, self.seconds)
            number, outcome = channel.receive(), channel.receive()
            if number != self._calls or not _well_formed(outcome):
                channel.give_up()
            return outcome
        except Ended as ended:
            self.close()
            return ended.outcome
        except BaseException:  # Ctrl-C within an answer: the next call must not read the rest of it
            self.close()
            raise

    def _running(self) -> _Channel:
        """The channel to a process that has loaded the notebook and the overrides.

        A statement that ends the process or its time is left out in the next one: the rest of the notebook counts.
        """
        while self._channel is None:
            if self._failed:
                raise self._failed
            if not self.notebook.is_file():
                raise Ended("not found", f"{self.notebook.name}: there is no such file")
            self._channel = _Channel(self.notebook.parent)
            left_out = len(self._left_out)
            try:
                self._load(self._channel)
            except Ended as ended:
                self.close()
                if left_out in (MOST_LEFT_OUT, len(self._left_out)):
                    self._failed = ended
        if self._defined != self.overrides:
            self._channel.ask(encode(("define", dict(self.overrides))), self.seconds)
            self._found = replace(self._found, names=_texts(self._channel.receive()))
            self._defined = dict(self.overrides)
        return self._channel

    def _load(self, channel: _Channel) -> None:
        """Have the notebook loaded; the worker says which statement comes next before it runs."""
        self._defined = {}
        if channel.receive() != "ready":
            channel.give_up()
        channel.ask(
            encode(("load", self.notebook.name, [list(place) for place in self._left_out])), self.seconds
        )
        at = None
        try:
            while True:
                match channel.receive():
                    case ("at", int(cell), int(line)):
                        at = (cell, line)
                    case ("refused", str(reason)):
                        at = None
                        raise Ended("not found", reason)
                    case ("found", [*names], [*skipped]):
                        self._found = Found(_texts(names), tuple(self._skipped(each) for each in skipped))
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
                return Skipped(cell, line, self._left_out.get((cell, line), reason))
        raise Ended("died", UNREADABLE)


def _texts(values: Any) -> tuple[str, ...]:
    if isinstance(values, list) and all(isinstance(each, str) for each in values):
        return tuple(values)
    raise Ended("died", UNREADABLE)


def _well_formed(outcome: Any) -> bool:
    """Whether an outcome that a stranger wrote has fields of the right types."""
    match outcome:
        case Outcome(came=str(came), text=str(), line=str(), changed=bool(), output=str()):
            return came in get_args(Came)
    return False


class _Channel:
    """A new process and the pipes to it. Nothing in it waits beyond the deadline, whoever holds the other ends."""

    def __init__(self, folder: Path) -> None:
        environment = {name: os.environ[name] for name in _KEPT if name in os.environ} | _SET
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "nao_course.grading.worker"],
            bufsize=0,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=folder,
            env=environment,
            start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        assert self.process.stdin and self.process.stdout  # pipes, as asked for
        self.requests, self.replies = self.process.stdin.fileno(), self.process.stdout.fileno()
        if sys.platform != "win32":
            os.set_blocking(self.requests, False)
        self.seconds = SECONDS_TO_START
        self.deadline = time.monotonic() + self.seconds

    def ask(self, frame: bytes, seconds: float) -> None:
        """Send a request whose answers must be here within some seconds."""
        self.seconds, self.deadline = seconds, time.monotonic() + seconds
        rest = memoryview(frame)
        while rest:
            self.wait(self.requests, "write")
            try:
                rest = rest[os.write(self.requests, rest) :]
            except OSError:  # it reads no more
                raise Ended("died", self.how_it_ended()) from None

    def receive(self) -> Any:
        """Return what the worker says next."""
        try:
            prefix = self.read(PREFIX_SIZE)
            return decode(prefix + self.read(sum(frame_lengths(prefix, REPLY))), REPLY)
        except CodecError:
            self.give_up()

    def read(self, length: int) -> bytes:
        """Read that many bytes; they take up memory as they come, not as they are announced."""
        data = bytearray()
        while len(data) < length:
            self.wait(self.replies, "read")
            part = os.read(self.replies, min(length - len(data), 2**20))
            if not part:
                raise Ended("died", self.how_it_ended())
            data += part
        return bytes(data)

    def wait(self, pipe: int, what: str) -> None:
        """Wait until a pipe can be read or written."""
        if not _ready(pipe, what, max(self.deadline - time.monotonic(), 0.0)):
            raise Ended("timed out", f"no answer within {self.seconds:g} s")

    def give_up(self) -> NoReturn:
        """Say that an answer makes no sense."""
        raise Ended("died", UNREADABLE)

    def how_it_ended(self) -> str:
        """Say what became of a process that closed its pipes."""
        self.kill()
        code = self.process.returncode
        if code < 0:
            return f"the process was ended by signal {-code} ({signal.strsignal(-code)})"
        return f"the process ended itself with status {code}"

    def kill(self) -> None:
        """End the process and its group. The group's number is its own until the process has been waited for."""
        if self.process.returncode is None:
            if sys.platform == "win32":
                subprocess.run(["taskkill", "/F", "/T", "/PID", str(self.process.pid)], capture_output=True)
            else:
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(self.process.pid, signal.SIGKILL)
        with self.process:  # closes the pipes and waits
            pass


def _ready(pipe: int, what: str, seconds: float) -> bool:
    """Whether a pipe can be read or written within some seconds."""
    if sys.platform == "win32":
        import _winapi
        import msvcrt

        end = time.monotonic() + seconds
        with contextlib.suppress(OSError):  # closed: reading it says so
            while what == "read" and not _winapi.PeekNamedPipe(msvcrt.get_osfhandle(pipe), 0)[0]:
                if time.monotonic() > end:
                    return False
                time.sleep(0.001)
        return True
    else:
        poll = select.poll()
        poll.register(pipe, select.POLLIN if what == "read" else select.POLLOUT)
        return bool(poll.poll(seconds * 1000))


# --- the worker's side ---


class _Beginning(io.RawIOBase):
    """A file that keeps the first of what is written to it and drops the rest."""

    def __init__(self) -> None:
        self.kept = bytearray()

    def writable(self) -> bool:
        return True

    def write(self, data: Any, /) -> int:
        self.kept += bytes(data)[: MOST_OUTPUT - len(self.kept)]
        return memoryview(data).nbytes


class _Server:
    """The worker: it answers until nobody asks any more."""

    def __init__(self, requests: int, replies: int) -> None:
        self.requests, self.replies, self.process = requests, replies, os.getpid()
        self.functions: dict[str, Any] = {}
        self.definitions = Definitions({})

    def serve(self) -> NoReturn:
        """Answer."""
        self.say(encode("ready"))
        while True:
            match decode(self.read(), trusted=True):
                case ("load", name, left_out):
                    self.load(Path(name), {(cell, line) for cell, line in left_out})
                case ("define", sources):
                    self.define(sources)
                case ("call", number, name, args, kwargs, driver):
                    self.call(number, name, Case(args, kwargs=kwargs), driver)

    def load(self, notebook: Path, left_out: set[tuple[int, int]]) -> None:
        def before(cell: int, line: int) -> bool:
            self.say(encode(("at", cell, line)))
            return (cell, line) not in left_out

        try:
            with _captured():
                self.definitions = load_definitions(notebook, before)
        except (OSError, ValueError) as error:
            self.say(encode(("refused", str(error))))
            return
        self.functions = dict(self.definitions)
        skipped = [[each.cell, each.line, each.reason] for each in self.definitions.skipped]
        self.say(encode(("found", list(self.functions), skipped)))

    def define(self, sources: dict[str, str]) -> None:
        """Let functions take the place of the notebook's; one that cannot be defined is not found."""
        namespace = self.definitions.namespace
        namespace.update(self.definitions)
        self.functions = dict(self.definitions)
        for name, source in sources.items():
            self.functions.pop(name, None)
            with contextlib.suppress(Exception), _captured():
                exec(compile(source, f"<{name}>", "exec", dont_inherit=True), namespace)
                self.functions[name] = namespace[name]
        self.say(encode(list(self.functions)))

    def call(self, number: int, name: str, case: Case, driver: str) -> None:
        with _captured() as output:
            outcome = call_as_it_is(self.functions[name], case, driver)
        outcome = replace(outcome, output=output.kept.decode("utf-8", "replace"))
        self.say(encode(number) + encoded(outcome, REPLY))

    def say(self, frame: bytes) -> None:
        if os.getpid() != self.process:
            os._exit(0)  # a child that the student's code forked has come back here
        rest = memoryview(frame)
        while rest:
            rest = rest[os.write(self.replies, rest) :]

    def read(self) -> bytes:
        prefix = self.read_exactly(PREFIX_SIZE)
        return prefix + self.read_exactly(sum(frame_lengths(prefix)))

    def read_exactly(self, length: int) -> bytes:
        data = bytearray()
        while len(data) < length:
            part = os.read(self.requests, length - len(data))
            if not part or os.getpid() != self.process:
                os._exit(0)
            data += part
        return bytes(data)


@contextlib.contextmanager
def _captured() -> Iterator[_Beginning]:
    output = _Beginning()
    text = io.TextIOWrapper(output, "utf-8", "replace", write_through=True)  # type: ignore[type-var]
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
        yield output


def main() -> NoReturn:
    """Serve over what were standard input and output; to the student's code both lead nowhere."""
    requests, replies = os.dup(0), os.dup(1)
    if sys.platform == "win32":
        import msvcrt

        for pipe in (requests, replies):
            msvcrt.setmode(pipe, os.O_BINARY)
    nowhere = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(nowhere, standard)
    sys.path.append(os.getcwd())  # files of the student's own, behind the library's
    _Server(requests, replies).serve()


if __name__ == "__main__":
    main()
