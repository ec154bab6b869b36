"""The grader's end of a Dask cluster: workers are admitted, submissions go to them, and each comes back once.

Dask schedules, encrypts and notices workers that die; what a lost worker had is given to another one. The journal, the
feedback and the secret stay with the grader. Options of TLS are Dask's configuration, for the grader as for scheduler
and workers.
"""

import contextlib
import ipaddress
import logging
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any
from urllib.parse import SplitResult, urlsplit

import dask
from distributed import Client, KilledWorker, LocalCluster, Security

from nao_course._internal.counts import say_count
from nao_course.instructor.autograding.assignment import Assignment
from nao_course.instructor.autograding.cluster.parcels import AssignmentParcel, SubmissionParcel, unpacked
from nao_course.instructor.autograding.cluster.worker import Requirement, admit, grade_parcel
from nao_course.instructor.autograding.grader import GraderError
from nao_course.instructor.collecting.submissions import Submission
from nao_course.instructor.gradebook.records import SubmissionResult

SECONDS_TO_CONNECT = 15.0
SECONDS_FOR_A_WORKER = 60.0  # until the first one joins
# Bytes of submissions on their way; from then on, none is sent until a result is there
MOST_HELD = 64 * 2**20
_PROTOCOLS = ("tcp", "tls", "ws", "wss")
_MOST_STARTS = 3
_SECONDS_BETWEEN_UPDATES = 1.0  # of the list of workers
_CONFIGURATION = {"distributed.admin.large-graph-warning-threshold": "1GB"}  # a notebook may have 50 MB
_LEAVE_CONTROL_C_TO_THE_GRADER = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"


class ClusterError(ValueError):
    """A cluster that cannot be used, or was lost; the message says what to do."""


@dataclass
class Cluster:
    """A cluster whose admitted workers grade submissions.

    `say` is called with a line about each worker that is refused, and when none is left.
    """

    client: Client
    requirement: Requirement
    say: Callable[[str], object] = lambda line: None
    _refused: dict[str, str] = field(default_factory=dict, init=False, repr=False)
    _admitted: dict[str, int] = field(default_factory=dict, init=False, repr=False)
    _assignments: dict[str, Any] = field(default_factory=dict, init=False, repr=False)
    _held: int = field(default=0, init=False, repr=False)  # bytes of submissions without a result
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False, repr=False)
    _ended: threading.Event = field(default_factory=threading.Event, init=False, repr=False)

    @property
    def most(self) -> int:
        """How many submissions may wait or run, so that no worker waits for the grader and its memory is bounded."""
        return 0 if self._held >= MOST_HELD else 2 * max(1, sum(self._admitted.values()))

    def submit(self, submission: Submission, assignment: Assignment) -> Future[SubmissionResult]:
        """Send a submission, whose files are read now, to any admitted worker, and its assignment once to each worker.

        The future raises a GraderError if each worker that had it died, and a ClusterError if the scheduler was lost.
        """
        executor = self.client.get_executor(pure=False, resources={self.requirement.resource: 1})
        if assignment.hash not in self._assignments:
            self._assignments[assignment.hash] = self.client.submit(
                unpacked,
                AssignmentParcel.of(assignment),
                pure=False,
                resources={self.requirement.resource: 1},
            )
        answer: Future[SubmissionResult] = Future()
        parcel = SubmissionParcel.of(submission)
        size = parcel.size
        self._hold(size)
        sent = executor.submit(grade_parcel, parcel, self._assignments[assignment.hash])

        def pass_on(done: Future[SubmissionResult]) -> None:
            self._hold(-size)
            _pass_on(done, answer, submission)

        sent.add_done_callback(pass_on)
        return answer

    def _hold(self, size: int) -> None:
        """Count the bytes of a submission: grader and scheduler keep them until its result is there."""
        with self._lock:
            self._held += size

    def wait_for_workers(self, seconds: float = SECONDS_FOR_A_WORKER) -> None:
        """Wait until a worker is admitted; raise a ClusterError if none joins in time, or all of them are refused."""
        until, address = time.monotonic() + seconds, self.client.scheduler_info(n_workers=0)["address"]
        while not self._admitted:
            self.update_workers()
            if self._refused and not self._admitted:
                raise ClusterError("no worker may grade: every worker was refused, as said above")
            if time.monotonic() > until:
                raise ClusterError(
                    f"the scheduler {address} has no workers: start one with `dask worker {address}`"
                )
            time.sleep(0.1)
        threads = sum(self._admitted.values())
        self.say(
            f"{say_count(len(self._admitted), 'worker')}, {say_count(threads, 'submission')} at a time, at {address}."
        )

    def update_workers(self) -> None:
        """Find out who joined and who left, and admit or refuse the new workers."""
        there = {
            address: worker["nthreads"]
            for address, worker in self.client.scheduler_info(n_workers=-1)["workers"].items()
        }
        admitted = {address: there[address] for address in self._admitted if address in there}
        self._refused = {address: reason for address, reason in self._refused.items() if address in there}
        new = sorted(there.keys() - admitted.keys() - self._refused.keys())
        answers = self.client.run(admit, self.requirement, workers=new, on_error="return") if new else {}
        for address, answer in answers.items():
            if answer == "":
                admitted[address] = there[address]
            elif not isinstance(answer, OSError):  # it has left again
                lacks_it = f"the grader's course cannot be loaded there ({type(answer).__name__}: {answer})"
                self._refused[address] = answer if isinstance(answer, str) else lacks_it
                self.say(f"REFUSED the worker {address}: {self._refused[address]}.")
        if self._admitted and not admitted:
            self.say(
                "No worker is left. Grading goes on when one joins; Ctrl-C ends it and keeps what is graded."
            )
        self._admitted = admitted  # whole, because other threads read it

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Keep the list of workers up to date while the block runs."""

        def watch() -> None:
            while not self._ended.wait(_SECONDS_BETWEEN_UPDATES):
                try:
                    self.update_workers()
                except Exception:  # noqa: BLE001 - a lost scheduler is reported by what was sent to it
                    continue

        thread = threading.Thread(target=watch, name="update workers", daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._ended.set()


def _pass_on(
    done: Future[SubmissionResult], answer: Future[SubmissionResult], submission: Submission
) -> None:
    """Give an answer what came back, with errors of Dask in the grader's words."""
    whose = f"{submission.student}, {submission.lesson}"
    try:
        answer.set_result(done.result())
    except CancelledError:
        answer.set_exception(
            ClusterError(
                "the connection to the scheduler was lost. What is graded is kept: start the scheduler and its "
                "workers again, and the same command goes on with the rest"
            )
        )
    except KilledWorker:
        answer.set_exception(
            GraderError(f"{whose}: every worker that it was sent to died; the same command tries again")
        )
    except BaseException as error:  # noqa: BLE001 - whatever it is, who waits for the result gets it
        answer.set_exception(error)


@contextmanager
def open_cluster(
    level: str,
    *,
    scheduler: str = "",
    workers: int = 0,
    jobs: int = 1,
    say: Callable[[str], object] = lambda line: None,
) -> Iterator[Cluster]:
    """Connect to a scheduler, or start a cluster of processes on this machine that ends with the block.

    `level` is the lowest sandbox level of a worker, and `scheduler` an address such as "tls://10.0.0.1:8786"; without
    one, `workers` processes are started, which together grade `jobs` submissions at a time. `say` is called with lines
    for the person at the terminal. Raise a ClusterError if the scheduler cannot be reached or no worker may grade.
    """
    logging.getLogger("distributed").setLevel(logging.ERROR)
    with ExitStack() as stack:
        stack.enter_context(dask.config.set(_CONFIGURATION))
        if scheduler:
            client = stack.enter_context(_connect(scheduler, say))
        else:
            local = stack.enter_context(_local_cluster(workers, -(-jobs // workers)))
            client = stack.enter_context(Client(local, set_as_default=False))
        cluster = Cluster(client, Requirement.of_this_machine(level), say)
        cluster.wait_for_workers()
        stack.enter_context(cluster.watching())
        yield cluster


def _local_cluster(workers: int, threads: int) -> LocalCluster:
    """Start workers on this machine, encrypted and without web pages, because its other users can reach the ports."""
    start = partial(
        LocalCluster,
        n_workers=workers,
        threads_per_worker=threads,
        security=True,
        dashboard_address="127.0.0.1:0",  # by default it is a fixed port of all networks
        scheduler_kwargs={"dashboard": False},
        silence_logs=logging.CRITICAL,
        preload=_LEAVE_CONTROL_C_TO_THE_GRADER,
    )
    with dask.config.set({f"distributed.{part}.http.routes": [] for part in ("scheduler", "worker")}):
        for _ in range(_MOST_STARTS - 1):
            # Dask asserts that its event loop runs within ten seconds, which a busy machine may miss.
            with contextlib.suppress(AssertionError):
                return start()
        return start()


def _connect(address: str, say: Callable[[str], object]) -> Client:
    """Connect to a scheduler; say so if others could listen.

    Dask is asked only for addresses that it can use: a client that refuses one stays half open, and when the garbage
    collector closes it while another one starts, both wait for the same lock for ever.
    """
    where = _usable(address if "://" in address else f"tcp://{address}")
    if where is None:
        raise ClusterError(
            f"cannot reach a scheduler at {address}: give the address that `dask scheduler` prints, such as "
            "tls://10.0.0.1:8786"
        )
    encrypted = where.scheme == "tls"
    try:
        certificate = Security().get_connection_args("client")["ssl_context"]
    except OSError as error:
        raise ClusterError(f"cannot use the certificate that Dask's settings name ({error})") from None
    if encrypted and not certificate:
        raise ClusterError(
            f"{address} is encrypted, and Dask's settings on this machine name no certificate. Copy the settings of "
            "the scheduler's machine into ~/.config/dask (docs/grade_a_class.md, Several machines)"
        )
    try:
        client = Client(address, timeout=SECONDS_TO_CONNECT, set_as_default=False)
    except OSError as error:
        raise ClusterError(
            f"cannot reach a scheduler at {address} ({error}). Start one with `dask scheduler`, and give the address "
            "that it prints, such as tls://10.0.0.1:8786"
        ) from None
    if not encrypted and not _is_local(where.hostname or ""):
        say(
            f"THE CONNECTION TO {address} IS NOT ENCRYPTED. Who reaches the scheduler can read hidden cases and run "
            "programs on all workers: use TLS."
        )
    return client


def _usable(address: str) -> SplitResult | None:
    """Return the parts of an address that Dask can use, or nothing."""
    with contextlib.suppress(ValueError):  # of a port that is not a number, or half a pair of brackets
        where = urlsplit(address)
        if where.scheme in _PROTOCOLS and where.hostname and where.port:
            return where
    return None


def _is_local(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
