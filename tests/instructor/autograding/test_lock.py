"""Many share a read-write lock, one has it alone, and who waits to have it alone is not made to wait for ever."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from nao_course.instructor.autograding.lock import ReadWriteLock

GUARD = 120.0  # seconds, against hanging


def test_many_share_it_at_a_time():
    lock, together = ReadWriteLock(), threading.Barrier(3)

    def share(_):
        with lock.shared():
            return together.wait(GUARD)  # all three are in it now

    with ThreadPoolExecutor(3) as pool:
        assert sorted(pool.map(share, range(3))) == [0, 1, 2]


def test_one_has_it_alone_once_those_who_share_it_have_left():
    lock, inside, seen = ReadWriteLock(), [], []

    def use(number):
        with lock.exclusive() if number % 3 == 0 else lock.shared():
            inside.append(number)
            time.sleep(0.0001)  # whoever may come in does
            seen.append((number % 3 == 0, len(inside)))
            inside.remove(number)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(use, range(600)))
    assert len(seen) == 600 and {many for alone, many in seen if alone} == {1}


def test_nobody_begins_to_share_it_while_one_waits_to_have_it_alone():
    lock, order, shared = ReadWriteLock(), [], threading.Event()

    def first():
        with lock.shared():
            shared.set()
            while not lock._taken and not order:  # until the other one waits, or does not
                time.sleep(0.001)
            late.start()
            order.append("first")

    def alone():
        with lock.exclusive():
            order.append("alone")

    def second():
        with lock.shared():
            order.append("late")

    late = threading.Thread(target=second)
    threads = [threading.Thread(target=first), threading.Thread(target=alone)]
    threads[0].start()
    assert shared.wait(GUARD)
    threads[1].start()
    for each in (*threads, late):
        each.join(GUARD)
    assert order == ["first", "alone", "late"]


@pytest.mark.parametrize("way", ["shared", "exclusive"])
def test_it_is_free_again_after_an_error(way):
    lock = ReadWriteLock()
    with pytest.raises(ZeroDivisionError), getattr(lock, way)():
        raise ZeroDivisionError
    with lock.exclusive():
        pass
