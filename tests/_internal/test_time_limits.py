"""Code that runs too long is stopped, in any thread, but not in the middle of an import."""

import _thread
import gc
import importlib
import subprocess
import sys
import threading
import time
from contextlib import suppress
from textwrap import dedent

import pytest

from nao_course._internal import time_limits
from nao_course._internal.time_limits import TooSlow, time_limit


def endless():
    while True:
        pass


def stopped(seconds=0.05, **more):
    with pytest.raises(TooSlow), time_limit(seconds, **more):
        endless()
    return True


def test_a_limit_that_was_kept_is_forgotten_and_one_works_in_any_thread_and_can_end_sooner():
    with time_limit(60):
        time.sleep(0.1)  # a thread is counted when it runs
    before = _thread._count()
    with time_limit(60), time_limit(1e9):  # all limits share one thread
        time.sleep(0.1)
        assert _thread._count() == before
    with time_limit(0.05):
        pass
    time.sleep(0.1)
    assert stopped() and stopped()
    done = []
    thread = threading.Thread(target=lambda: done.append(stopped()), daemon=True)
    thread.start()
    thread.join(30)  # where it is not stopped
    assert done == [True]
    seen = []

    def sooner(frame):
        seen.append(frame.f_code.co_name)
        return len(seen) == 2

    assert stopped(1e9, sooner=sooner)
    assert seen == ["endless", "endless"]


def test_an_error_of_sooner_ends_neither_its_own_limit_nor_another():
    calls = []

    def sooner(frame):
        calls.append(frame)
        raise RuntimeError("an error of its own")

    with time_limit(1e9, sooner=sooner):
        time.sleep(0.4)
        assert stopped()
    assert stopped(0.6, sooner=sooner)
    assert 2 <= len(calls) <= 6  # four times a second, after an error too


@pytest.fixture(autouse=True)
def no_garbage():
    """Keep other tests' garbage out of the time-limited blocks: pytest's hook for it must not be interrupted."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


@pytest.mark.parametrize("in_main", [True, False])
def test_it_rings_after_an_import_not_within_it(tmp_path, monkeypatch, in_main):
    (tmp_path / "slowly_imported.py").write_text(
        "import time\nend = time.monotonic() + 0.3\nwhile time.monotonic() < end:\n    pass\nENDED = True\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    sys.modules.pop("slowly_imported", None)

    def import_it():
        importlib.import_module("slowly_imported")
        endless()

    def import_and_go_on():
        with pytest.raises(TooSlow), time_limit(0.05):
            import_it()

    if in_main:
        import_and_go_on()
    else:
        thread = threading.Thread(target=import_and_go_on, daemon=True)
        thread.start()
        thread.join(30)
    assert sys.modules["slowly_imported"].ENDED


def test_it_does_not_wait_for_an_import_that_never_ends(tmp_path, monkeypatch):
    (tmp_path / "never_ends.py").write_text("while True:\n    pass\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(time_limits, "IMPORTING", 0.1)
    with pytest.raises(TooSlow), time_limit(0.05):
        importlib.import_module("never_ends")


@pytest.mark.parametrize("seconds", [60, 0.05])
def test_after_a_limit_code_can_be_profiled_as_before_it(seconds):
    """`%prun` hung in a kernel in which a check had run."""
    code = f"""
        import cProfile, contextlib, time
        from nao_course._internal.time_limits import TooSlow, time_limit
        with contextlib.suppress(TooSlow), time_limit({seconds}):
            until = time.monotonic() + 0.2
            while time.monotonic() < until:
                pass
        cProfile.run("print('profiled')")
    """
    ran = subprocess.run([sys.executable, "-c", dedent(code)], capture_output=True, timeout=240, check=True)
    assert b"profiled" in ran.stdout


def test_no_interruption_arrives_after_its_block():
    for number in range(300):
        with suppress(TooSlow), time_limit(number % 30 / 10_000):
            for _ in range(200 * (number % 40)):
                pass
        for _ in range(1000):  # an interruption that is late would arrive here
            pass
