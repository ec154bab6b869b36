"""The student's end of a worker: a process that loads a notebook and answers calls until nobody asks any more."""

import contextlib
import gc
import importlib
import io
import os
import random
import shutil
import sys
import tempfile
import threading
import zlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.random.bit_generator

from nao_course.codec import PREFIX_SIZE, decode, encode, frame_lengths
from nao_course.exercises.definitions import Definitions, Skipped, load_definitions
from nao_course.exercises.earlier import not_usable, split_use, stand_in
from nao_course.exercises.interactive import unattended
from nao_course.exercises.lesson_names import number_of
from nao_course.exercises.notebook_text import without_outputs
from nao_course.exercises.outline import read_outline
from nao_course.exercises.running import call_as_it_is, encoded
from nao_course.instructor.sandbox.confinement import Bounds, limit_resources
from nao_course.instructor.sandbox.protocol import LIMITED, MOST_NOTES, MOST_OUTPUT, REPLY

_NO_ROOM = "the notebook and its files do not fit into the space that a submission has for files"
_NO_MEMORY = "MemoryError"  # how the reason begins of a statement that found none left
_MOST_GREEDY = 3  # statements that are left out because they take all memory
_DECIDES = 4096  # bytes of a request that the random states follow from
_RECURSIONS = 1000  # as in a new Python


def _places(told: list[list[int]]) -> set[tuple[int, int]]:
    """Count cells and lines."""
    return {(cell, line) for cell, line in told}


class TruncatedOutput(io.RawIOBase):
    """A file that keeps the beginning of its output and drops the rest."""

    def __init__(self) -> None:
        self.kept = bytearray()

    def writable(self) -> bool:
        """Say that it can be written to."""
        return True

    def write(self, data: Any, /) -> int:
        """Accept all output, and keep its beginning."""
        view = memoryview(data).cast("B")
        self.kept += view[: max(MOST_OUTPUT - len(self.kept), 0)]
        return view.nbytes


class RandomStates:
    """The random states of this process, which are set before each use of a student's code.

    They are set to numbers that follow from the request, so that no result depends on the worker or on what was called
    before. A generator of NumPy that is made without a seed has one from the same source.
    """

    def __init__(self) -> None:
        # Kept, because a student's code can replace them
        self.seed_python, self.seed_numpy = random.seed, np.random.seed
        numpy.random.bit_generator.randbits = random.getrandbits  # type: ignore[attr-defined]

    def set(self, request: bytes | bytearray) -> None:
        """Set all states by a request for the student's code; of a long one its end decides."""
        seed = zlib.crc32(request[-_DECIDES:])
        self.seed_python(seed)
        with contextlib.suppress(Exception):  # the student's code put something in place of generators
            self.seed_numpy(seed)
            if opencv := sys.modules.get("cv2"):
                opencv.setRNGSeed(seed & 0x7FFFFFFF)


def _same_everywhere() -> None:
    """Set what a process inherits from whoever started it and a student's code could depend on."""
    os.umask(0o077)
    frame, depth = sys._getframe(), 0
    while frame := frame.f_back:  # type: ignore[assignment]
        depth += 1
    sys.setrecursionlimit(_RECURSIONS + depth)


class RequestLoop:
    """The worker: it answers until nobody asks any more."""

    def __init__(self, requests: int, replies: int, *, private: bool = True) -> None:
        # Private: its folder is its own
        self.requests, self.replies, self.private = (requests, replies, private)
        self.getpid, self.leave = os.getpid, os._exit  # before a student's code can put others in their place
        self.process = self.getpid()
        self.lock = threading.RLock()
        self.random_states = RandomStates()
        self.announce = False  # each statement of a notebook before it runs
        self.functions: dict[str, Any] = {}
        self.definitions = Definitions({})
        self.earlier: dict[str, Definitions] = {}  # by the number of the lesson
        self.references: dict[tuple[str, str], Callable[..., Any]] = {}  # by lesson and name

    def serve(self) -> NoReturn:
        """Answer."""
        self.say(encode("ready"))
        while True:
            match decode(self.read(), trusted=True):
                case ("shorten", name, size):
                    self.shorten(name, size)
                case ("earlier", lesson, content, setup, left_out, announce):
                    self.announce = announce
                    self.load_earlier(lesson, content, setup, _places(left_out))
                case ("load", name, content, setup, left_out, announce, instead):
                    self.announce = announce
                    self.load(Path(name), content, setup, _places(left_out), instead)
                case ("define", sources, references):
                    self.define(sources, references)
                case ("call", number, name, driver):
                    self.call(number, name, self.read(), driver)

    def shorten(self, name: str, size: int) -> None:
        """Read a large notebook, which follows the request as it is, and send it without its outputs."""
        try:
            short = without_outputs(name, self.read_exactly(size))
        except ValueError as error:
            self.say(encode(("refused", str(error))))
        else:
            self.say(encode(("shortened", short), REPLY))

    def load_earlier(self, lesson: str, content: Any, setup: str, left_out: set[tuple[int, int]]) -> None:
        """Load the notebook of an earlier lesson in its own namespace; an invalid one has no functions."""
        folder = Path(tempfile.mkdtemp(prefix="earlier_", dir=os.getcwd() if self.private else None))
        with contextlib.suppress(OSError, ValueError), _captured(), _own_helpers(folder):
            for name, text in content[1].items():
                (folder / name).write_bytes(text)
            notebook = folder / f"{lesson}.ipynb"
            notebook.write_bytes(content[0])
            self.earlier[number_of(lesson)] = self.loaded(notebook, left_out, setup, {})
        if not self.private:
            shutil.rmtree(folder, ignore_errors=True)
        self.say(encode("loaded"))

    def load(
        self,
        notebook: Path,
        content: Any,
        setup: str,
        left_out: set[tuple[int, int]],
        instead: dict[str, str],
    ) -> None:
        """Load a notebook."""
        try:
            if content:
                notebook.write_bytes(content[0])
                for name, text in content[1].items():
                    Path(name).write_bytes(text)
            with _captured():
                self.definitions = self.loaded(notebook, left_out, setup, instead)
        except (OSError, ValueError) as error:
            reason = str(error) if isinstance(error, ValueError) else _NO_ROOM
            self.say(encode(("refused", reason)))
            return
        self.functions = dict(self.definitions)
        text = self.definitions.text
        skipped = [[each.cell, each.line, each.reason] for each in self.definitions.skipped]
        remarks = {name: list(texts) for name, texts in self.definitions.remarks.items()}
        found = (
            list(self.functions),
            skipped,
            dict(text.written),
            text.lesson,
            text.version,
            text.python,
            remarks,
        )
        self.say(encode(("found", *found)))

    def loaded(
        self, notebook: Path, left_out: set[tuple[int, int]], setup: str, instead: dict[str, str]
    ) -> Definitions:
        """Load a notebook's definitions, again without each statement that took all memory: it may hold it."""
        greedy: dict[tuple[int, int], Skipped] = {}
        while True:
            self.random_states.set(b"")
            with unattended():
                found = load_definitions(
                    notebook,
                    self.before(left_out | set(greedy)),
                    setup,
                    self.stand_in,
                    instead,
                    read_outline(notebook.stem),
                )
            told = [greedy.get((each.cell, each.line), each) for each in found.skipped]
            # Only the first one: later statements may have found no memory because of it.
            first = next((each for each in found.skipped if each.reason.startswith(_NO_MEMORY)), None)
            if first is None or len(greedy) == _MOST_GREEDY:
                return replace(found, skipped=tuple(told))
            greedy[first.cell, first.line] = first
            found.namespace.clear()
            del found
            gc.collect()

    def before(self, left_out: set[tuple[int, int]]) -> Callable[[int, int], bool]:
        """Return a function that says whether a statement runs, and announces it if an earlier process has ended."""

        def tell(cell: int, line: int) -> bool:
            if self.announce:
                self.say(encode(("at", cell, line)))
            return (cell, line) not in left_out

        return tell

    def stand_in(self, use: str) -> Any:
        """Return the function that is used for an earlier lesson's: the reference's or the submitted one."""
        lesson, name = split_use(use)

        def find() -> Any:
            if (lesson, name) in self.references:
                return self.references[lesson, name]
            if lesson not in self.earlier:
                return not_usable(use, f"there is no notebook of lesson {lesson} that could be read.")()
            if name not in self.earlier[lesson]:
                return not_usable(use, f"the notebook of lesson {lesson} does not define it.")()
            return self.earlier[lesson][name]

        return stand_in(use, find)

    def define(self, sources: dict[str, str], references: list[str]) -> None:
        """Replace functions of the notebook; a function that cannot be defined is missing."""
        self.random_states.set(b"")
        namespace = self.definitions.namespace
        namespace.update(self.definitions)
        self.functions = dict(self.definitions)
        for name, source in sources.items():
            self.functions.pop(name, None)
            with contextlib.suppress(Exception), _captured():
                exec(compile(source, f"<{name}>", "exec", dont_inherit=True), namespace)
                self.functions[name] = namespace[name]
        self.references = {split_use(use): self.stub(use) for use in references if ":" in use}
        for name in references:
            if ":" not in name:
                self.functions[name] = namespace[name] = self.stub(name)
        self.say(encode(list(self.functions)))

    def stub(self, name: str) -> Callable[..., Any]:
        """Return a function that has its answer from the grader."""

        def stub(*args: Any, **kwargs: Any) -> Any:
            with self.lock:
                self.say(encode(("ask", name, args, kwargs), REPLY))
                _, outcome = decode(self.read(), trusted=True)
            if outcome.status != "value":
                raise RuntimeError(
                    f"{name} gives no answer to this: {outcome.status} {outcome.text}".rstrip()
                )
            return outcome.value

        stub.__name__ = stub.__qualname__ = split_use(name)[1]
        return stub

    def call(self, number: int, name: str, frame: bytearray, driver: str) -> None:
        """Call a function and send the call's number with its outcome."""
        self.random_states.set(frame)
        with _captured() as output:
            outcome = call_as_it_is(self.functions[name], frame, driver, trusted=True)
        outcome = replace(outcome, output=output.kept.decode("utf-8", "replace"))
        self.say(encoded(outcome, REPLY, number))

    def say(self, frame: bytes) -> None:
        """Send a frame, whole."""
        if self.getpid() != self.process:
            self.leave(0)  # a child that the student's code forked has come back here
        rest = memoryview(frame)
        with self.lock:
            while rest:
                rest = rest[os.write(self.replies, rest) :]

    def read(self) -> bytearray:
        """Return the next frame."""
        frame = self.read_exactly(PREFIX_SIZE)
        frame += self.read_exactly(sum(frame_lengths(frame)))
        return frame

    def read_exactly(self, length: int) -> bytearray:
        """Read some bytes; end where nobody asks any more."""
        data = bytearray()
        while len(data) < length:
            part = os.read(self.requests, min(length - len(data), 2**20))
            if not part or self.getpid() != self.process:
                self.leave(0)
            data += part
        return data


@contextlib.contextmanager
def _captured() -> Iterator[TruncatedOutput]:
    output = TruncatedOutput()
    text = io.TextIOWrapper(output, "utf-8", "replace", write_through=True)  # type: ignore[type-var]
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
        yield output


@contextlib.contextmanager
def _own_helpers(folder: Path) -> Iterator[None]:
    """Let a notebook import the helper files beside it; another lesson's may have the same names."""
    here = os.getcwd()  # the folder of the graded lesson's files
    sys.path.insert(sys.path.index(here) if here in sys.path else len(sys.path), str(folder))
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.path[:] = [*(each for each in sys.path if each != str(folder)), str(folder)]
        for name, module in list(sys.modules.items()):
            if str(getattr(module, "__file__", None)).startswith(f"{folder}{os.sep}"):
                del sys.modules[name]
        importlib.invalidate_caches()


_FILE_EVENTS = {
    "open",
    "os.listdir",
    "os.scandir",
    "os.remove",
    "os.rename",
    "os.chmod",
    "os.chown",
    "os.mkdir",
}
_FILE_EVENTS |= {"os.rmdir", "os.link", "os.symlink", "os.truncate", "shutil.rmtree"}
_PROGRAM_EVENTS = {"subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn"}
_NETWORK_EVENTS = {
    "socket.connect",
    "socket.bind",
    "socket.sendto",
    "socket.getaddrinfo",
    "socket.gethostbyname",
}
_SIGNAL_EVENTS = {"os.kill", "os.killpg"}
_SYSTEM_CALLS = {
    "ptrace",
    "process_vm_readv",
    "process_vm_writev",
    "mount",
    "unshare",
    "setns",
    "socket",
    "keyctl",
}


class AuditHook:
    """Reports attempts of a student's code to the grader that no exercise needs and the sandbox denies."""

    def __init__(self, loop: RequestLoop, paths: tuple[str, ...]) -> None:
        self.loop, self.told = loop, set[str]()
        self.fine = (*paths, os.getcwd(), "/dev/null", "/dev/urandom", "<", *filter(None, sys.path))
        self.abspath = os.path.abspath

    def __call__(self, event: str, args: tuple[Any, ...]) -> None:
        """Process an event of `sys.audit`."""
        text = ""
        if event in _FILE_EVENTS:
            text = self.describe_access(event, args[0])
        elif event in _PROGRAM_EVENTS:
            text = f"starts a program: {args[0]!r}"
        elif event in _NETWORK_EVENTS:
            text = f"{event}: {args[-1] if event == 'socket.sendto' else args[0 if 'get' in event else 1]!r}"
        elif event in _SIGNAL_EVENTS and args[0] != self.loop.process:
            text = f"sends a signal to process {args[0]}"
        elif event == "ctypes.dlsym" and args[1] in _SYSTEM_CALLS:
            text = f"looks up the system call {args[1]}"
        elif event == "socket.__new__" and args[1] in (2, 10, 16, 17):
            text = f"opens a socket of family {args[1]}"
        if text and text not in self.told and len(self.told) < MOST_NOTES:
            self.told.add(text)
            if self.loop.getpid() == self.loop.process:
                self.loop.say(encode(("attempt", text[:200].encode("utf-8", "replace").decode())))

    def describe_access(self, event: str, path: Any) -> str:
        """Return a description of access to a hidden file; an empty string for visible ones."""
        if not isinstance(path, str | bytes | os.PathLike):
            return ""
        whole = self.abspath(os.fsdecode(path))
        return "" if whole.startswith(self.fine) else f"{event} {whole}"


def answer_calls(
    requests: int, replies: int, paths: tuple[str, ...] | None = None, *, private: bool = True
) -> NoReturn:
    """Process requests until the channel closes, whose descriptors are given.

    Access of its code to other than these paths is reported. A `private` working folder is its own, and is deleted
    later.
    """
    _same_everywhere()
    sys.path.append(os.getcwd())  # files of the student's own, behind the library's
    loop = RequestLoop(requests, replies, private=private)
    if paths is not None:
        sys.addaudithook(AuditHook(loop, paths))
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
    if LIMITED in sys.argv:
        limit_resources(Bounds())
    answer_calls(requests, replies, private=LIMITED in sys.argv)


if __name__ == "__main__":
    main()
