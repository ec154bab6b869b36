"""A student's functions in a process of their own: called with a time limit, killed as a whole.

The two processes speak frames of the codec over pipes or a socket. The worker is told the notebook and the inputs of
calls, and never what is expected. What it answers is read as a stranger's; whatever it is, its caller gets an
`Outcome`.
"""

from __future__ import annotations

import contextlib
import io
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, Self, get_args

from nao_course.exercises.case import Case
from nao_course.exercises.codec import PREFIX_SIZE, CodecError, Limits, decode, encode, frame_lengths
from nao_course.exercises.definitions import (
    MOST_BYTES,
    MOST_WRITTEN,
    Definitions,
    Skipped,
    load_definitions,
)
from nao_course.exercises.running import Outcome, Status, call_as_it_is, encoded
from nao_course.instructor.sandbox.confinement import Bounds, SandboxError, limit_resources

if TYPE_CHECKING:
    from nao_course.instructor.sandbox.warm_server import Fork, WarmServer

REPLY = Limits(size=32 * 2**20, header=4 * 2**20)  # a picture of 1280 x 960 in float64 has 28 MB
MOST_OUTPUT = 8 * 2**10  # bytes of what a call prints that are kept
MOST_TEXT = 1000  # characters of an exception's message
MOST_SKIPPED = 1000  # statements that are listed as not run
MOST_WRITTEN_ANSWERS = 100
MOST_LEFT_OUT = 5  # statements that may end a process while it loads; each is left out in the next one
MOST_NOTES = 20
MOST_ASKED = 20_000  # questions of one call to functions that are lent to it,
MOST_ASKED_BYTES = 512 * 2**20  # and their size
LONGEST_REASON = 500  # characters: why a notebook cannot be loaded
UNREADABLE = "its answer could not be read"
SECONDS_TO_START = 60.0  # Python and numpy, on a machine that is busy
SECONDS_IN_ALL = 120.0  # for one submission
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
SINGLE_THREADED = {
    "MPLBACKEND": "Agg",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
}
_LIMITED = "--limited"  # argument of a process that sets limits for itself


class ServerEnded(RuntimeError):  # noqa: N818 - no error of the submission: it has to be graded again
    """The warm server died while a submission was being graded; nothing was found out about the submission."""


class Ended(Exception):  # noqa: N818 - no error: students' processes end
    """A worker gave no answer that can be used.

    Parameters
    ----------
    status : str
        "timed out", "died", or "not found" where there is no notebook to load.
    text : str
        How it ended.
    """

    def __init__(self, status: Status, text: str) -> None:
        super().__init__(text)
        self.outcome = Outcome(status, text=text)


@dataclass(frozen=True)
class Found:
    """What a worker found in its notebook.

    Parameters
    ----------
    names : tuple of str
        Functions and classes that it defines.
    skipped : tuple of Skipped
        Statements that did not run.
    written : mapping of str to str
        Written answers by the name of their cell.
    lesson, version : str
        What the notebook says it is a copy of.
    """

    names: tuple[str, ...] = ()
    skipped: tuple[Skipped, ...] = ()
    written: Mapping[str, str] = field(default_factory=dict)
    lesson: str = ""
    version: str = ""


@dataclass
class Worker:
    """A notebook's functions, in a process that starts when it is needed, and again after it had to be killed.

    Parameters
    ----------
    notebook : Path
        Whose functions are called.
    overrides : mapping of str to str
        Source of functions that take the place of the notebook's; may be changed between calls.
    seconds : float
        Wall clock for loading the notebook, and for each call.
    server : WarmServer, optional
        Whose sandboxed workers it runs in; they see copies of notebook and helpers in a folder of their own. Without
        one, for notebooks that are trusted, it is a new Python with the notebook's folder as its working folder.
    setup : str
        Source of a set-up cell whose imports run before the notebook.
    helpers : sequence of Path
        Python files handed in beside the notebook.
    total : float
        Wall clock for everything that it does, in seconds.

    Raises
    ------
    SandboxError
        From `call` and `definitions`, if a worker could not be confined.
    ServerEnded
        From the same, if the warm server died: grade the submission again.

    Examples
    --------
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
    total: float = SECONDS_IN_ALL
    _channel: _Channel | None = field(default=None, init=False, repr=False)
    _lent: dict[str, Callable[[tuple[Any, ...], dict[str, Any]], Outcome]] = field(
        default_factory=dict, init=False, repr=False
    )
    _defined: tuple[dict[str, str], list[str]] = field(
        default_factory=lambda: ({}, []), init=False, repr=False
    )
    _found: Found = field(default_factory=Found, init=False, repr=False)
    _failed: Ended | None = field(default=None, init=False, repr=False)
    _left_out: dict[tuple[int, int], str] = field(default_factory=dict, init=False, repr=False)
    _noted: dict[str, None] = field(default_factory=dict, init=False, repr=False)
    _deaths: int = field(default=0, init=False, repr=False)
    _calls: int = field(default=0, init=False, repr=False)
    _spent: float = field(default=0.0, init=False, repr=False)

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
            with self._clock():
                self._running()
        except Ended as ended:
            self.close()
            self._count(ended)
            return Found(skipped=(Skipped(0, 0, ended.outcome.text),))
        except BaseException:  # half an answer may be on its way
            self.close()
            raise
        return self._found

    @property
    def notes(self) -> tuple[str, ...]:
        """What the sandbox saw the student's code try; it may see less than there was."""
        return tuple(self._noted)

    @property
    def deaths(self) -> int:
        """How many of its processes have died under it: by the student's code, or by someone outside."""
        return self._deaths

    def lend(self, answers: Mapping[str, Callable[[tuple[Any, ...], dict[str, Any]], Outcome]]) -> None:
        """From now on, let functions of the notebook be stubs that ask for their answer here.

        Parameters
        ----------
        answers : mapping of str to callable
            Called with the arguments that came from the worker, and keyword arguments; its outcome goes there. Its time
            is not the student's. An empty mapping ends it.
        """
        self._lent = dict(answers)

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
            with self._clock():
                channel = self._running()
                if name not in self._found.names:
                    return Outcome("not found")
                channel.ask(question, self._seconds())
                number = self._answering(channel)
                outcome = self._next(channel)
            if number != self._calls or not _well_formed(outcome):
                channel.give_up()
            return _shortened(outcome)
        except Ended as ended:
            self.close()
            self._count(ended)
            return ended.outcome
        except BaseException:  # Ctrl-C within an answer: the next call must not read the rest of it
            self.close()
            raise

    def _count(self, ended: Ended) -> None:
        self._deaths += ended.outcome.status == "died"

    @contextlib.contextmanager
    def _clock(self) -> Iterator[None]:
        """Count the time of the block as the submission's."""
        began = time.monotonic()
        try:
            yield
        finally:
            self._spent += time.monotonic() - began

    def _seconds(self) -> float:
        """For what is asked next."""
        if self._spent >= self.total:
            raise Ended("timed out", f"all {self.total:g} s that a submission has are used up")
        return min(self.seconds, self.total - self._spent)

    def _next(self, channel: _Channel) -> Any:
        """What the worker says next, but for what it tells of attempts."""
        while True:
            match channel.receive():
                case ("attempt", str(text)):
                    if len(self._noted) < MOST_NOTES:
                        self._noted[_printable(text[:200])] = None
                case said:
                    return said

    def _answering(self, channel: _Channel) -> Any:
        """What the worker says next, after the questions it has on the way."""
        asked, size = 0, channel.size
        while True:
            match self._next(channel):
                case ("ask", str(name), tuple(args), dict(kwargs)) if name in self._lent:
                    asked += 1
                    if asked > MOST_ASKED or channel.size - size > MOST_ASKED_BYTES:
                        raise Ended("died", f"it called {name} too often")
                    began = time.monotonic()
                    try:
                        answer = encode(("answer", self._lent[name](args, kwargs)))
                    except CodecError as error:  # what came just fitted; with what goes along, it does not
                        answer = encode(("answer", Outcome("unsendable", text=str(error))))
                    waited = time.monotonic() - began
                    self._spent -= waited
                    channel.deadline += waited
                    channel.send(answer)
                case said:
                    return said

    def _running(self) -> _Channel:
        """The channel to a process that has loaded the notebook and the overrides.

        A statement that ends the process or its time is left out in the next one: the rest of the notebook counts.
        """
        while self._channel is None:
            if self._failed:
                raise self._failed
            content = self._content()
            self._channel = self._start()
            left_out = len(self._left_out)
            try:
                self._load(self._channel, content)
            except Ended as ended:
                self.close()
                self._count(ended)
                if left_out in (MOST_LEFT_OUT, len(self._left_out)):
                    self._failed = ended
        told = (dict(self.overrides), sorted(self._lent))
        if self._defined != told:
            self._channel.ask(encode(("define", *told)), self._seconds())
            self._found = replace(self._found, names=_texts(self._next(self._channel)))
            self._defined = told
        return self._channel

    def _content(self) -> tuple[bytes, dict[str, bytes]] | None:
        """Notebook and helpers for a worker that does not see them."""
        if not self.notebook.is_file():
            raise Ended("not found", f"{self.notebook.name}: there is no such file")
        if self.server is None:
            return None
        if sum(path.stat().st_size for path in (self.notebook, *self.helpers)) > MOST_BYTES:
            raise Ended("not found", f"{self.notebook.name}: larger than {MOST_BYTES // 2**20} MB")
        return self.notebook.read_bytes(), {path.name: path.read_bytes() for path in self.helpers}

    def _start(self) -> _Channel:
        """A new process, for notebooks that are trusted or not."""
        self._seconds()
        if self.server is None:
            return _OwnProcess(self.notebook.parent)
        if self.server.forks:
            return _ForkedProcess(self.server, self.server.fork())
        return _LimitedProcess()

    def _load(self, channel: _Channel, content: tuple[bytes, dict[str, bytes]] | None) -> None:
        """Have the notebook loaded; the worker says which statement comes next before it runs."""
        self._defined = ({}, [])
        match channel.receive():
            case "ready":
                pass
            case ("unsafe", str(reason)):
                raise SandboxError(f"a worker could not be confined: {reason}")
            case _:
                channel.give_up()
        left_out = [list(place) for place in self._left_out]
        channel.ask(encode(("load", self.notebook.name, content, self.setup, left_out)), self._seconds())
        at = None
        try:
            while True:
                match self._next(channel):
                    case ("at", int(cell), int(line)):
                        at = (cell, line)
                    case ("refused", str(reason)):
                        at = None
                        raise Ended("not found", _printable(reason))
                    case ("found", [*names], [*skipped], dict(written), str(lesson), str(version)):
                        told = tuple(self._skipped(each) for each in skipped[:MOST_SKIPPED])
                        self._found = Found(
                            _texts(names), told, _answers(written), lesson[:100], version[:100]
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
                return Skipped(cell, line, self._left_out.get((cell, line), _printable(reason)))
        raise Ended("died", UNREADABLE)


def _printable(text: str) -> str:
    """The beginning of a text that a stranger wrote, without what a terminal would obey."""
    return "".join(each if each.isprintable() else " " for each in text[:LONGEST_REASON])


def _texts(values: Any) -> tuple[str, ...]:
    if isinstance(values, list) and all(isinstance(each, str) for each in values):
        return tuple(values)
    raise Ended("died", UNREADABLE)


def _answers(written: dict[str, Any]) -> dict[str, str]:
    if all(isinstance(text, str) for text in written.values()):
        some = islice(written.items(), MOST_WRITTEN_ANSWERS)
        return {name[:100]: text[:MOST_WRITTEN] for name, text in some}
    raise Ended("died", UNREADABLE)


def _well_formed(outcome: Any) -> bool:
    """Whether an outcome that a stranger wrote has fields of the right types."""
    match outcome:
        case Outcome(status=str(status), text=str(), line=str(), changed=bool(), output=str()):
            return status in get_args(Status)
    return False


def _shortened(outcome: Outcome) -> Outcome:
    """An outcome whose texts are no longer than an honest worker makes them."""
    text, line = outcome.text[:MOST_TEXT], outcome.line[:MOST_TEXT]
    return replace(outcome, text=text, line=line, output=outcome.output[:MOST_OUTPUT])


class _Channel:
    """The way to a worker. Nothing in it waits beyond the deadline, whoever holds the other end."""

    def __init__(self, requests: int, replies: int) -> None:
        self.requests, self.replies = requests, replies
        self.seconds, self.size = SECONDS_TO_START, 0
        self.deadline = time.monotonic() + self.seconds
        if sys.platform != "win32":
            os.set_blocking(self.requests, False)

    def ask(self, frame: bytes, seconds: float) -> None:
        """Send a request whose answers must be here within some seconds."""
        self.seconds, self.deadline = seconds, time.monotonic() + seconds
        self.send(frame)

    def send(self, frame: bytes) -> None:
        """Send a frame within the time that is left."""
        rest = memoryview(frame)
        while rest:
            self.wait(self.requests, "write")
            try:
                rest = rest[os.write(self.requests, rest) :]
            except BlockingIOError:
                continue
            except OSError:  # it reads no more
                raise Ended("died", self.how_it_ended()) from None

    def receive(self) -> Any:
        """Return what the worker says next."""
        try:
            frame = bytearray()
            self.read(frame, PREFIX_SIZE)
            length = sum(frame_lengths(frame, REPLY))
            self.size += length
            self.read(frame, PREFIX_SIZE + length)
            return decode(frame, REPLY)
        except CodecError:
            self.give_up()

    def read(self, data: bytearray, length: int) -> None:
        """Read until there are that many bytes; they take up memory as they come, not as they are announced."""
        while len(data) < length:
            self.wait(self.replies, "read")
            try:
                part = os.read(self.replies, min(length - len(data), 2**20))
            except BlockingIOError:
                continue
            except OSError:  # a socket whose other end was closed with something unread
                part = b""
            if not part:
                raise Ended("died", self.how_it_ended())
            data += part

    def wait(self, pipe: int, what: str) -> None:
        """Wait until a pipe can be read or written."""
        if not _ready(pipe, what, max(self.deadline - time.monotonic(), 0.0)):
            raise Ended("timed out", f"no answer within {self.seconds:g} s")

    def give_up(self) -> NoReturn:
        """Say that an answer makes no sense."""
        raise Ended("died", UNREADABLE)

    def how_it_ended(self) -> str:
        """End what is left of a process that closed its channel, and say what became of it."""
        raise NotImplementedError

    def kill(self) -> None:
        """End the process and all that it started."""
        raise NotImplementedError


class _OwnProcess(_Channel):
    """A new Python and the pipes to it."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        environment = {name: os.environ[name] for name in _KEPT if name in os.environ} | SINGLE_THREADED
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "nao_course.instructor.sandbox.worker", *arguments],
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
        super().__init__(self.process.stdin.fileno(), self.process.stdout.fileno())

    def how_it_ended(self) -> str:
        """End what is left of a process that closed its channel, and say what became of it."""
        self.kill()
        return describe_end(self.process.returncode)

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


class _LimitedProcess(_OwnProcess):
    """A new Python with limits in a folder that is thrown away: what there is where no worker can be forked."""

    def __init__(self) -> None:
        self.folder = tempfile.mkdtemp(prefix="nao-course-")
        super().__init__(Path(self.folder), _LIMITED)

    def kill(self) -> None:
        """End the process and its group, and take its folder away."""
        super().kill()
        shutil.rmtree(self.folder, ignore_errors=True)


class _ForkedProcess(_Channel):
    """A worker of a warm server."""

    def __init__(self, server: WarmServer, fork: Fork) -> None:
        super().__init__(fork.socket.fileno(), fork.socket.fileno())
        self.server, self.fork, self.ended = server, fork, ""

    def how_it_ended(self) -> str:
        """End what is left of a process that closed its channel, and say what became of it."""
        self.ended = self.ended or self.server.end(self.fork)
        return self.ended

    def kill(self) -> None:
        """End the process and its whole namespace."""
        with contextlib.suppress(ServerEnded):  # and its workers with it
            self.how_it_ended()


def describe_end(code: int) -> str:
    """Say what became of a process, from the status it ended with."""
    if code < 0:
        return f"the process was ended by signal {-code} ({signal.strsignal(-code)})"
    return f"the process ended itself with status {code}"


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
        view = memoryview(data).cast("B")
        self.kept += view[: max(MOST_OUTPUT - len(self.kept), 0)]
        return view.nbytes


class _Loop:
    """The worker: it answers until nobody asks any more."""

    def __init__(self, requests: int, replies: int) -> None:
        self.requests, self.replies = requests, replies
        self.getpid, self.leave = os.getpid, os._exit  # before a student's code can put others in their place
        self.process = self.getpid()
        self.lock = threading.RLock()
        self.functions: dict[str, Any] = {}
        self.definitions = Definitions({})

    def serve(self) -> NoReturn:
        """Answer."""
        self.say(encode("ready"))
        while True:
            match decode(self.read(), trusted=True):
                case ("load", name, content, setup, left_out):
                    self.load(Path(name), content, setup, {(cell, line) for cell, line in left_out})
                case ("define", sources, lent):
                    self.define(sources, lent)
                case ("call", number, name, args, kwargs, driver):
                    self.call(number, name, Case(args, kwargs=kwargs), driver)

    def load(self, notebook: Path, content: Any, setup: str, left_out: set[tuple[int, int]]) -> None:
        def before(cell: int, line: int) -> bool:
            self.say(encode(("at", cell, line)))
            return (cell, line) not in left_out

        try:
            if content:
                notebook.write_bytes(content[0])
                for name, text in content[1].items():
                    Path(name).write_bytes(text)
            with _captured():
                self.definitions = load_definitions(notebook, before, setup)
        except (OSError, ValueError) as error:
            self.say(encode(("refused", str(error))))
            return
        self.functions = dict(self.definitions)
        text = self.definitions.text
        skipped = [[each.cell, each.line, each.reason] for each in self.definitions.skipped]
        found = (list(self.functions), skipped, dict(text.written), text.lesson, text.version)
        self.say(encode(("found", *found)))

    def define(self, sources: dict[str, str], lent: list[str]) -> None:
        """Let functions take the place of the notebook's; one that cannot be defined is not found."""
        namespace = self.definitions.namespace
        namespace.update(self.definitions)
        self.functions = dict(self.definitions)
        for name, source in sources.items():
            self.functions.pop(name, None)
            with contextlib.suppress(Exception), _captured():
                exec(compile(source, f"<{name}>", "exec", dont_inherit=True), namespace)
                self.functions[name] = namespace[name]
        for name in lent:
            self.functions[name] = namespace[name] = self.stub(name)
        self.say(encode(list(self.functions)))

    def stub(self, name: str) -> Callable[..., Any]:
        def lent(*args: Any, **kwargs: Any) -> Any:
            with self.lock:
                self.say(encode(("ask", name, args, kwargs), REPLY))
                _, outcome = decode(self.read(), trusted=True)
            if outcome.status != "value":
                raise RuntimeError(f"{name} gives no answer to this: {outcome.status} {outcome.text}".rstrip())
            return outcome.value

        lent.__name__ = lent.__qualname__ = name
        return lent

    def call(self, number: int, name: str, case: Case, driver: str) -> None:
        with _captured() as output:
            outcome = call_as_it_is(self.functions[name], case, driver)
        outcome = replace(outcome, output=output.kept.decode("utf-8", "replace"))
        self.say(encode(number) + encoded(outcome, REPLY))

    def say(self, frame: bytes) -> None:
        if self.getpid() != self.process:
            self.leave(0)  # a child that the student's code forked has come back here
        rest = memoryview(frame)
        with self.lock:
            while rest:
                rest = rest[os.write(self.replies, rest) :]

    def read(self) -> bytes:
        prefix = self.read_exactly(PREFIX_SIZE)
        return prefix + self.read_exactly(sum(frame_lengths(prefix)))

    def read_exactly(self, length: int) -> bytes:
        data = bytearray()
        while len(data) < length:
            part = os.read(self.requests, min(length - len(data), 2**20))
            if not part or self.getpid() != self.process:
                self.leave(0)
            data += part
        return bytes(data)


@contextlib.contextmanager
def _captured() -> Iterator[_Beginning]:
    output = _Beginning()
    text = io.TextIOWrapper(output, "utf-8", "replace", write_through=True)  # type: ignore[type-var]
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
        yield output


_LOOKS = {"open", "os.listdir", "os.scandir", "os.remove", "os.rename", "os.chmod", "os.chown", "os.mkdir"}
_LOOKS |= {"os.rmdir", "os.link", "os.symlink", "os.truncate", "shutil.rmtree"}
_STARTS = {"subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn"}
_SPEAKS = {"socket.connect", "socket.bind", "socket.sendto", "socket.getaddrinfo", "socket.gethostbyname"}
_SIGNALS = {"os.kill", "os.killpg"}
_CALLS = {"ptrace", "process_vm_readv", "process_vm_writev", "mount", "unshare", "setns", "socket", "keyctl"}


class _Watch:
    """Tells the grader what a student's code tries that no exercise needs; a layer of the sandbox denies it."""

    def __init__(self, loop: _Loop, paths: tuple[str, ...]) -> None:
        self.loop, self.told = loop, set[str]()
        self.fine = (*paths, os.getcwd(), "/dev/null", "/dev/urandom", "<", *filter(None, sys.path))
        self.abspath = os.path.abspath

    def __call__(self, event: str, args: tuple[Any, ...]) -> None:
        """See an event of `sys.audit`."""
        text = ""
        if event in _LOOKS:
            text = self.looks(event, args[0])
        elif event in _STARTS:
            text = f"starts a program: {args[0]!r}"
        elif event in _SPEAKS:
            text = f"{event}: {args[-1] if event == 'socket.sendto' else args[0 if 'get' in event else 1]!r}"
        elif event in _SIGNALS and args[0] != self.loop.process:
            text = f"sends a signal to process {args[0]}"
        elif event == "ctypes.dlsym" and args[1] in _CALLS:
            text = f"looks up the system call {args[1]}"
        elif event == "socket.__new__" and args[1] in (2, 10, 16, 17):
            text = f"opens a socket of family {args[1]}"
        if text and text not in self.told and len(self.told) < MOST_NOTES:
            self.told.add(text)
            if self.loop.getpid() == self.loop.process:
                self.loop.say(encode(("attempt", text[:200].encode("utf-8", "replace").decode())))

    def looks(self, event: str, path: Any) -> str:
        """What to say of a file; nothing of those that are in sight."""
        if not isinstance(path, str | bytes | os.PathLike):
            return ""
        whole = self.abspath(os.fsdecode(path))
        return "" if whole.startswith(self.fine) else f"{event} {whole}"


def answer_calls(requests: int, replies: int, paths: tuple[str, ...] | None = None) -> NoReturn:
    """Be a worker.

    Parameters
    ----------
    requests, replies : int
        Descriptors to read from and write to.
    paths : tuple of str, optional
        What its code may read; it is told where the code tries to look elsewhere.
    """
    sys.path.append(os.getcwd())  # files of the student's own, behind the library's
    loop = _Loop(requests, replies)
    if paths is not None:
        sys.addaudithook(_Watch(loop, paths))
    loop.serve()


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
    if _LIMITED in sys.argv:
        limit_resources(Bounds())
    answer_calls(requests, replies)


if __name__ == "__main__":
    main()
