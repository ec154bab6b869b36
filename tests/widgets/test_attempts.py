"""A student's code at arm's length: stopped in time, its mistakes in sentences, its prints kept."""

import contextlib
import gc
import io
import runpy
import signal
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from nao_course._internal.time_limits import TooSlow
from nao_course.exercises.earlier import not_usable
from nao_course.widgets import attempts
from nao_course.widgets.attempts import KEPT_LETTERS, attempt


def test_an_earlier_lesson_that_is_not_usable_and_an_exercise_that_is_not_written_are_said_as_such():
    def blank():
        return not_usable("01:color_labels")()

    message = attempt(blank, "your code").message
    assert message == "color_labels of your lesson 01 is not usable yet."

    def unwritten():
        raise NotImplementedError

    assert attempt(unwritten, "it", unfinished="Finish exercise 1.6.").message == "Finish exercise 1.6."
    assert attempt(unwritten, "it", unfinished="Finish exercise 1.6.").unfinished
    assert "NotImplementedError in it" in attempt(unwritten, "it").message
    assert not attempt(lambda: 1 / 0, "it", unfinished="Finish exercise 1.6.").unfinished


@pytest.fixture
def no_collector():
    """Keep destructors of other tests out of a loop: Python ignores an exception there, and pytest reports it."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


@pytest.mark.usefixtures("no_collector")
def test_a_loop_that_catches_everything_is_stopped_too():
    def stubborn():
        count = 0
        while True:
            try:  # noqa: SIM105
                count += sum(range(10))
            except:  # noqa: E722 - a beginner's
                pass

    assert "Time is up" in attempt(stubborn, "your code", limit=0.05).message


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="there is no alarm clock")
@pytest.mark.usefixtures("no_collector")
@pytest.mark.parametrize("wait", [0.02, 1000.0])
def test_a_loop_that_catches_everything_around_calls_that_wait_is_stopped_where_there_is_an_alarm_clock(wait):
    def stubborn():
        while True:
            try:  # noqa: SIM105
                time.sleep(wait)
            except:  # noqa: E722
                pass

    handler = signal.getsignal(signal.SIGALRM)
    assert "Time is up" in attempt(stubborn, "your code", limit=0.05).message
    assert signal.getsignal(signal.SIGALRM) is handler
    assert signal.getitimer(signal.ITIMER_REAL) == (0, 0)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="there is no alarm clock")
def test_an_alarm_that_somebody_else_has_set_stays_theirs():
    rung = []
    before = signal.signal(signal.SIGALRM, lambda *_: rung.append(1))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        assert "Time is up" in attempt(endless_loop, "your code", limit=0.2).message
        assert rung == [1]
    finally:
        signal.signal(signal.SIGALRM, before)


def endless_loop():
    while True:
        pass


@pytest.mark.parametrize("quiet", [True, False])
def test_what_is_printed_is_kept_and_shown_unless_it_is_to_be_quiet(quiet):
    with contextlib.redirect_stdout(io.StringIO()) as out:
        tried = attempt(lambda: print("a" * KEPT_LETTERS + "end"), "your code", quiet=quiet)
    assert tried.printed.endswith("end\n") and len(tried.printed) == KEPT_LETTERS
    assert out.getvalue() == ("" if quiet else "a" * KEPT_LETTERS + "end\n")


def test_a_mistake_and_what_never_ends_are_sentences_and_a_call_has_ten_seconds_or_as_said(monkeypatch):
    assert attempts.TIME_LIMIT == 60.0, "the tests say so"
    monkeypatch.delenv("NAO_COURSE_TIME_LIMIT")
    assert runpy.run_path(attempts.__file__)["TIME_LIMIT"] == 10.0

    def loop():
        while True:
            pass

    tried = attempt(loop, "your code", limit=0.05)
    assert isinstance(tried.error, TooSlow)
    assert "Time is up: your code was not done after 0.05 s and was stopped in line" in tried.message
    assert attempt(lambda: "still here", "your code", limit=60).value == "still here"

    def interrupted():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        attempt(interrupted, "your code")

    def divide():
        return 1 / 0

    tried = attempt(divide, "your code")
    assert not tried.done and tried.value is None
    line = divide.__code__.co_firstlineno + 1
    assert tried.message == f"ZeroDivisionError in your code, line {line}: division by zero"
    with pytest.raises(ZeroDivisionError):
        raise tried.error


def test_attempts_that_overlap_in_two_threads_leave_standard_output_as_it_was():
    first_runs, second_runs, first_ends = threading.Event(), threading.Event(), threading.Event()

    def first():
        print("the first")
        first_runs.set()
        second_runs.wait(10)

    def second():
        print("the second")
        second_runs.set()
        first_ends.wait(10)
        print("the end")

    before = sys.stdout
    with ThreadPoolExecutor(2) as threads:
        one = threads.submit(attempt, first, "your code", quiet=True)
        first_runs.wait(10)
        other = threads.submit(attempt, second, "your code", quiet=True)
        one.result(10)
        first_ends.set()
        assert one.result().printed == "the first\n"
        assert other.result(10).printed == "the second\nthe end\n"
    assert sys.stdout is before
