"""A class graded by Dask workers has the results of one machine, whatever happens to scheduler, workers and grader."""

import contextlib
import gc
import json
import os
import re
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import time
from concurrent.futures import CancelledError, Future
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import dask
import psutil
import pytest
from distributed import KilledWorker
from typer.testing import CliRunner

from nao_course import cli
from nao_course.instructor.autograding.assignment import package_digest, prepare
from nao_course.instructor.autograding.batch import feedback_writer, grade_all, installed
from nao_course.instructor.autograding.cluster import dispatch, worker
from nao_course.instructor.autograding.cluster.dispatch import Cluster, ClusterError, open_cluster
from nao_course.instructor.autograding.cluster.parcels import SubmissionParcel
from nao_course.instructor.autograding.cluster.worker import Requirement
from nao_course.instructor.autograding.grader import GraderError
from nao_course.instructor.collecting.files import LARGEST_READ, submission_hash
from nao_course.instructor.collecting.submissions import Submission, gather, of_lessons, with_earlier
from nao_course.instructor.gradebook.journal import NAME, Journal
from nao_course.instructor.sandbox.layers import Layer, Sandbox, SandboxError, probe
from tests.handed_in import posix
from tests.paths import PROJECT
from tests.sandboxed import need
from tests.toy import chain, pair
from tests.toy.graded import hand_in, kept, rows


@pytest.fixture(scope="module")
def two_workers():
    with open_cluster(probe().level, workers=2, jobs=4) as cluster:
        yield cluster


@pytest.fixture
def course(tmp_path):
    return chain.make_course(tmp_path / "course")


def graded(found, assignment, grades, **more):
    """Grade into a journal and pages: the summary, and all that was kept, as text and bytes."""
    with Journal(grades) as journal:
        publish = feedback_writer(journal, grades / "feedback")
        summary = grade_all(found, lambda _: assignment, journal, publish=publish, **more)
    return summary, *all_kept(grades)


def all_kept(grades):
    pages = {path.relative_to(grades): path.read_bytes() for path in grades.rglob("*.html")}
    return json.dumps(list(kept(grades).values())), pages


@pytest.fixture
def graded_here(warm_server, tmp_path):
    """Grade on this machine alone."""
    more = {"jobs": 2, "server": warm_server, "level": probe().level}
    return lambda found, assignment: graded(found, assignment, tmp_path / "a", **more)


def gathered(root):
    return of_lessons(gather(root, root.parent, [chain.LESSON]), [chain.LESSON])


def a_class_of_every_kind(root: Path) -> Path:
    """Right, wrong and refused notebooks, one with outputs of several megabytes, a helper file, a link, a folder."""
    hand_in(root)
    noisy = json.loads(chain.notebook())
    noisy["cells"][0]["outputs"] = [{"output_type": "stream", "name": "stdout", "text": "x" * LARGEST_READ}]
    chain.hand_in(root, "gus", json.dumps(noisy).encode())
    helped = chain.notebook({"double": "from mine import double"})
    chain.hand_in(root, "hal", helped).with_name("mine.py").write_text(chain.RIGHT["double"])
    (root / "ida" / f"{chain.LESSON}.ipynb").mkdir(parents=True)
    chain.hand_in(root, "jo", b"")
    return root


@pytest.mark.slow
def test_a_class_has_the_scores_and_pages_of_one_machine_byte_for_byte(
    course, graded_here, two_workers, tmp_path
):
    found, assignment = gathered(a_class_of_every_kind(tmp_path / "in")), prepare(course, "90", chain.SECRET)
    local = graded_here(found, assignment)
    remote = graded(found, assignment, tmp_path / "b", workers=two_workers)
    assert (remote[0].graded, len(remote[0].refused), remote[0].failed) == (7, len(local[0].refused), [])
    assert remote[1:] == local[1:] and len(local[2]) == len(found) >= 9
    again = graded(found, assignment, tmp_path / "b", workers=two_workers)
    assert again[0].unchanged == len(found) and again[1:] == local[1:]


@pytest.mark.slow
def test_earlier_work_and_the_reference_go_with_a_submission(graded_here, two_workers, tmp_path):
    made = pair.make_course(tmp_path / "course")
    mine = pair.write(tmp_path / "ada" / "1.ipynb", pair.FIRST)
    second = pair.write(tmp_path / "ada" / "2.ipynb", pair.SECOND)
    before = {("ada", pair.FIRST): Submission("ada", pair.FIRST, mine)}
    found = [Submission(student, pair.SECOND, second) for student in ("ada", "bob")]
    found = with_earlier(found, before, lambda _: [pair.FIRST])
    assignment = prepare(made, pair.SECOND, chain.SECRET)
    local = graded_here(found, assignment)
    remote = graded(found, assignment, tmp_path / "b", workers=two_workers)
    assert remote[1:] == local[1:]
    earned = [sum(each["earned"] for each in result["exercises"]) for result in json.loads(remote[1])]
    assert earned == [31.0, 29.0]  # bob's reference stands in for what he did not hand in


def test_a_parcel_has_the_hash_of_what_was_handed_in(tmp_path):
    for each in gathered(a_class_of_every_kind(tmp_path / "in")):
        with SubmissionParcel.of(each).laid_out() as there:
            assert submission_hash(there) == submission_hash(each)
            assert not each.path.is_relative_to(there.path.parent)
        assert not there.path.exists()


HERE = Requirement.of_this_machine("process")


@pytest.mark.slow
def test_a_worker_needs_the_same_course_libraries_and_level(two_workers, monkeypatch, tmp_path):
    assert two_workers.requirement.versions == installed(), "the versions that the journal keeps"
    another = replace(HERE, code="another").unfulfilled()
    assert "install the same version and start the worker again" in another
    assert "the grader has python 2.7" in replace(HERE, versions="python 2.7").unfulfilled()
    assert HERE.unfulfilled() == ""
    changed = [replace(HERE, **{name: "other"}).resource for name in ("code", "versions", "level")]
    assert len({HERE.resource, *changed}) == 4, "each part has a resource of its own"
    monkeypatch.setattr("nao_course.instructor.autograding.assignment.LIBRARY", tmp_path)
    seen = set()
    for name in ("cli.py", "instructor/sandbox/worker.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        for text in ("A = 1\n", "A = 2\n"):
            (tmp_path / name).write_text(text)
            seen.add(package_digest.__wrapped__())
    assert len(seen) == 4


def test_a_worker_needs_the_level_of_the_grader_or_the_level_that_is_required(monkeypatch):
    weak = Sandbox((Layer("landlock", False, "not today"),))
    monkeypatch.setattr(worker, "probe", lambda: weak)
    reason = replace(HERE, level="landlock").unfulfilled()
    assert "not today" in reason and "--require-sandbox process" in reason
    assert replace(HERE, level="process").unfulfilled() == ""


@pytest.mark.slow
def test_a_refused_worker_is_named_with_the_reason_and_gets_nothing(two_workers, course, tmp_path):
    said = []
    stranger = Cluster(two_workers.client, replace(two_workers.requirement, code="another"), said.append)
    with pytest.raises(ClusterError, match="every worker was refused"):
        stranger.wait_for_workers()
    assert len(said) == 2 and all("install the same version" in line for line in said)
    path = chain.hand_in(tmp_path, "ada", chain.notebook())
    assignment = prepare(course, "90", chain.SECRET)
    answer = stranger.submit(Submission("ada", chain.LESSON, path), assignment)
    admitted = two_workers.submit(Submission("ada", chain.LESSON, path), assignment)
    assert admitted.result(timeout=300).status == "graded" and not answer.done()


CONNECTS = """
import socket
def double(x):
    socket.create_connection(({host!r}, {port}), 5).close()
    return 2 * x
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has layers that close the network")
def test_students_code_cannot_reach_the_scheduler_or_a_worker(two_workers, course, tmp_path):
    need("network namespace")
    addresses = [two_workers.client.scheduler.address, *two_workers.client.scheduler_info()["workers"]]
    assignment = prepare(course, "90", chain.SECRET)
    for number, address in enumerate(addresses):
        host, port = address.removeprefix("tls://").split(":")
        socket.create_connection((host, int(port)), 5).close()  # outside of the sandbox it is there
        content = chain.notebook({"double": CONNECTS.format(host=host, port=port)})
        path = chain.hand_in(tmp_path, f"eve{number}", content)
        result = two_workers.submit(Submission(f"eve{number}", chain.LESSON, path), assignment).result(300)
        assert result.exercises[0].state == "raised" and result.exercises[0].earned == 0
        assert any("connect" in each or "socket" in each for each in result.attempts)


def test_errors_of_dask_are_the_submissions_or_end_the_run():
    for error, wanted, words in [
        (KilledWorker("key", None, 3), GraderError, "ada, 90_chain: every worker that it was sent to died"),
        (CancelledError(), ClusterError, "the connection to the scheduler was lost"),
        (SandboxError("no worker could be forked"), SandboxError, "forked"),
    ]:
        done, answer = Future(), Future()
        done.set_exception(error)
        dispatch._pass_on(done, answer, Submission("ada", chain.LESSON, Path()))
        with pytest.raises(wanted, match=words):
            answer.result(0)


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


@pytest.mark.parametrize("address", ["nothing", "tcp://", "tcp://here:port", "tcp://[::1", "what://10.0.0.1"])
def test_an_address_that_dask_refuses_leaves_no_client_half_open(address):
    """The garbage collector would close it while another client starts, and both would wait for one lock."""
    with pytest.raises(ClusterError, match="the address that `dask scheduler` prints"):
        dispatch._connect(address, print)
    clients = [each for each in gc.get_objects() if isinstance(each, dispatch.Client)]
    assert "connecting" not in {each.status for each in clients}


def test_a_scheduler_that_is_not_there_or_has_no_certificate_is_named(monkeypatch):
    monkeypatch.setattr(dispatch, "SECONDS_TO_CONNECT", 0.5)
    address = f"tcp://127.0.0.1:{free_port()}"
    for there, said in (
        (address, f"cannot reach a scheduler at {address}.*dask scheduler"),
        (address[6:], "cannot reach"),
        ("tls://10.0.0.1:8786", "name no certificate"),
    ):
        with pytest.raises(ClusterError, match=said), open_cluster("process", scheduler=there):
            pass


def test_without_encryption_only_this_machine_is_silent(monkeypatch):
    monkeypatch.setattr(dispatch, "Client", lambda *_, **__: None)
    said = []
    for host in ("127.0.0.1", "localhost", "[::1]"):
        dispatch._connect(f"tcp://{host}:1", said.append)
    assert said == []
    for address in ("tcp://10.0.0.1:1", "tcp://grader.example:1", "ws://10.0.0.1:1"):
        dispatch._connect(address, said.append)
    assert len(said) == 3 and all("NOT ENCRYPTED" in line for line in said)


def test_a_cluster_without_workers_says_how_to_start_one():
    with dispatch._local_cluster(0, 1) as local, dispatch.Client(local, set_as_default=False) as client:
        cluster = Cluster(client, HERE)
        with pytest.raises(ClusterError, match=f"start one with `dask worker {local.scheduler_address}`"):
            cluster.wait_for_workers(0.0)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks for ports in /proc")
def test_workers_of_this_machine_listen_to_no_other_machine(two_workers):
    here = psutil.Process()
    ports = [each for process in (here, *here.children(recursive=True)) for each in process.net_connections()]
    listening = [each.laddr.ip for each in ports if each.status == psutil.CONN_LISTEN]
    assert len(listening) >= 3 and set(listening) <= {"127.0.0.1", "::1"}
    assert two_workers.client.scheduler.address.startswith("tls://")


def test_without_dask_the_command_says_what_to_install(course, secret, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "nao_course.instructor.autograding.cluster.dispatch", None)
    monkeypatch.delitem(sys.modules, "nao_course.instructor.autograding.cluster.dispatch")
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.chdir(course.root)
    hand_in(tmp_path / "in")
    words = ["grade", str(tmp_path / "in"), "--out", str(tmp_path / "grades")]
    said = CliRunner().invoke(cli.app, [*words, "--workers", "2"])
    assert said.exit_code == 1 and "nao-course[scale]" in said.output
    said = CliRunner().invoke(cli.app, [*words, "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"])
    assert said.exit_code == 1 and "not both" in said.output


def a_class_that_takes_a_while(root: Path, many: int) -> Path:
    kinds = [{}, chain.BLANK, chain.MISTAKES, {"double": chain.MISTAKES["double"]}]
    for number in range(many):
        slow = f"import time\ntime.sleep(0.2)\nn = {number}"
        chain.hand_in(root, f"s{number:02}", chain.notebook(kinds[number % 4], extra=slow))
    return root


@posix
@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["dies", "hangs"])
def test_what_a_lost_worker_had_is_graded_by_another_one_once(course, graded_here, tmp_path, number):
    """A worker that hangs goes on after it was given up: its late results are dropped."""
    found = gathered(a_class_that_takes_a_while(tmp_path / "in", 40))
    assignment = prepare(course, "90", chain.SECRET)
    done, lost, local = [], [], graded_here(found, assignment)
    with (
        dask.config.set({"distributed.scheduler.worker-ttl": "5s"}),
        open_cluster(probe().level, workers=2, jobs=4) as cluster,
    ):
        workers = cluster.client.run(os.getpid)

        def tell(submission):
            done.append(submission.student)
            if len(done) == 5:
                lost.append(psutil.Process(min(workers.values())))
                lost[0].send_signal(number)
            if len(done) == 38 and number == signal.SIGSTOP:
                with contextlib.suppress(psutil.NoSuchProcess):
                    lost[0].send_signal(signal.SIGCONT)

        remote = graded(found, assignment, tmp_path / "b", workers=cluster, tell=tell)
    assert remote[0].graded == 40 and remote[1:] == local[1:]
    assert sorted(done) == sorted(each.student for each in found)
    assert rows(tmp_path / "b", "history") == 0


def results_so_far(grades: Path) -> int:
    """Count the results in a journal that a grader may be making: its file is there before its tables."""
    try:
        return rows(grades, "results") if (grades / NAME).exists() else 0
    except sqlite3.OperationalError:
        return 0


class Installation:
    """A scheduler, workers and a grader as commands of their own."""

    def __init__(self, folder: Path) -> None:
        self.environment = os.environ | {"NAO_COURSE_SECRET": str(folder / "secret"), "COLUMNS": "200"}
        self.environment |= {"PYTHONPATH": str(PROJECT), "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "5s"}
        (folder / "secret").write_bytes(chain.SECRET)
        (folder / "secret").chmod(0o600)
        self.folder, self.course = folder, folder / "course"
        self.running: list[subprocess.Popen[bytes]] = []

    def start(self, *words: object) -> subprocess.Popen[bytes]:
        """Start a command whose output goes to the end of `said`."""
        with (self.folder / "said").open("ab") as said:
            process = subprocess.Popen(
                [sys.executable, "-m", *map(str, words)],
                cwd=self.course,
                env=self.environment,
                stdout=said,
                stderr=said,
                start_new_session=True,
                # Tests that run in the background inherit that Ctrl-C is ignored.
                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
            )
        self.running.append(process)
        return process

    @property
    def said(self) -> str:
        return (self.folder / "said").read_text(encoding="utf-8", errors="replace")

    def start_cluster(self, scheme: str = "tcp") -> list[subprocess.Popen[bytes]]:
        port = free_port()
        self.address = f"{scheme}://127.0.0.1:{port}"
        scheduler = ("scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard")
        worker = ("worker", self.address, "--nthreads", 2, "--no-dashboard")
        return [self.start("dask", *words) for words in (scheduler, worker, worker)]

    def grade(self) -> subprocess.Popen[bytes]:
        words = ("grade", self.folder / "in", "--out", self.folder / "b", "--scheduler", self.address)
        return self.start("nao_course.cli", *words)

    def wait_for_results(self, many: int) -> None:
        until = time.monotonic() + 300
        while results_so_far(self.folder / "b") < many:
            assert time.monotonic() < until, "the grader has no results after 300 s"
            time.sleep(0.05)

    def kill(self, process: subprocess.Popen[bytes]) -> None:
        """Send kill -9 to a command and all its processes."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(60)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.running:
            self.kill(process)


@posix
@pytest.mark.slow
@pytest.mark.parametrize("victim", ["scheduler", "grader"])  # what a lost worker had, see above
def test_after_kill_9_the_same_command_goes_on(course, graded_here, tmp_path, victim):
    found = gathered(a_class_that_takes_a_while(tmp_path / "in", 60))
    local = graded_here(found, prepare(course, "90", chain.SECRET))
    with Installation(tmp_path) as there:
        scheduler, *_ = there.start_cluster()
        grader = there.grade()
        there.wait_for_results(5)
        there.kill({"scheduler": scheduler, "grader": grader}[victim])
        assert rows(tmp_path / "b", "results") < 60
        assert grader.wait(300) == {"scheduler": 1, "grader": -signal.SIGKILL}[victim]
        if victim == "scheduler":
            there.start_cluster()
        assert there.grade().wait(300) == 0
    assert all_kept(tmp_path / "b") == local[1:] and len(kept(tmp_path / "b")) == len(found)
    assert rows(tmp_path / "b", "history") == 0


@posix
@pytest.mark.slow
def test_control_c_ends_a_run_with_workers_of_this_machine_without_a_traceback(course, tmp_path):
    """A terminal sends it to all processes, the workers too."""
    a_class_that_takes_a_while(tmp_path / "in", 60)
    words = ("nao_course.cli", "grade", tmp_path / "in", "--out", tmp_path / "b", "--workers", 2)
    with Installation(tmp_path) as there:
        grader = there.start(*words)
        there.wait_for_results(5)
        os.killpg(grader.pid, signal.SIGINT)
        assert grader.wait(300) == 130
        assert "the same command goes on" in there.said and "Traceback" not in there.said
        assert there.start(*words).wait(300) == 0
    assert (rows(tmp_path / "b", "results"), rows(tmp_path / "b", "history")) == (60, 0)


@posix
@pytest.mark.slow
def test_a_worker_without_the_course_is_refused_and_the_others_grade(course, tmp_path):
    """It joins while a class is graded: the grader waits until it is there."""
    a_class_that_takes_a_while(tmp_path / "in", 60)
    with Installation(tmp_path) as there:
        there.start_cluster()
        grader = there.grade()
        there.wait_for_results(1)
        grader.send_signal(signal.SIGSTOP)
        blind = "import sys; sys.modules['nao_course.instructor'] = None"
        there.start("dask", "worker", there.address, "--no-dashboard", "--preload", blind)
        until = time.monotonic() + 300
        while there.said.count("Registered to:") < 3 and time.monotonic() < until:
            time.sleep(0.05)
        grader.send_signal(signal.SIGCONT)
        assert grader.wait(300) == 0
        assert there.said.count("REFUSED the worker") == 1 and "cannot be loaded there" in there.said
    assert rows(tmp_path / "b", "results") == 60


@posix
@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("openssl"), reason="makes a certificate with openssl")
def test_the_settings_of_the_page_encrypt_and_without_them_nobody_gets_in(course, tmp_path):
    hand_in(tmp_path / "in")
    page = (PROJECT / "docs" / "grade_a_class.md").read_text(encoding="utf-8")
    (block,) = (each for each in re.findall(r"^```sh\n(.*?)^```$", page, re.M | re.S) if "openssl" in each)
    with Installation(tmp_path) as there:
        outside = there.environment
        there.environment = outside | {"HOME": str(tmp_path)}
        subprocess.run(["sh", "-e", "-c", block], env=there.environment, check=True, capture_output=True)
        there.start_cluster("tls")
        assert there.grade().wait(300) == 0
        assert rows(tmp_path / "b", "results") == 6
        there.environment = outside | {"HOME": str(tmp_path / "elsewhere")}
        assert there.grade().wait(300) == 1 and "name no certificate" in there.said
        there.address = there.address.replace("tls", "tcp")
        assert there.grade().wait(300) == 1 and "cannot reach a scheduler" in there.said


class FakeClient:
    """A client of Dask whose workers and tasks are lists."""

    def __init__(self):
        self.threads, self.refusals, self.sent = {}, {}, []

    def scheduler_info(self, n_workers):
        return {"workers": {name: {"nthreads": threads} for name, threads in self.threads.items()}}

    def run(self, admit, requirement, workers, on_error):
        return {name: self.refusals.get(name, "") for name in workers}

    def get_executor(self, **options):
        return self

    def submit(self, task, *arguments, **options):
        self.sent.append(Future())
        return self.sent[-1]


@pytest.fixture
def faked():
    """Return a cluster with a fake client, and what it says."""
    said = []
    return Cluster(FakeClient(), Requirement("code", "versions", "level"), said.append), said


def test_a_refused_worker_that_comes_back_is_tried_again_and_none_waits_for_the_grader(faked):
    cluster, said = faked
    cluster.client.threads, cluster.client.refusals = {"one": 3, "two": 2}, {"two": "it lacks something"}
    for _ in range(2):
        cluster.update_workers()
    assert len(said) == 1 and "two" in said[0] and cluster.most == 2 * 3
    cluster.client.threads, cluster.client.refusals = {"one": 3}, {}
    cluster.update_workers()
    cluster.client.threads = {"one": 3, "two": 2}
    cluster.update_workers()
    assert cluster.most == 2 * (3 + 2)


def test_no_more_is_sent_than_fits_into_a_bounded_memory(faked, tmp_path):
    cluster, _ = faked
    cluster.client.threads = {"one": 30}
    cluster.update_workers()
    (notebook := tmp_path / "notebook").write_bytes(b" " * (dispatch.MOST_HELD // 3 + 1))
    assignment = SimpleNamespace(hash="x", reference=notebook, earlier=())
    answers = []
    for number in range(3):
        assert cluster.most == 2 * 30
        answers.append(cluster.submit(Submission(f"s{number}", "01_toy", notebook), assignment))
    _, *sent = cluster.client.sent  # the first task is the assignment
    for task, answer in zip(sent, answers, strict=True):
        assert cluster.most == (0 if task is sent[0] else 2 * 30)
        task.set_result("a result")
        assert answer.result(0) == "a result"
    assert cluster.most == 2 * 30
