"""Whatever stands at the other end of a channel, what is said to it and read from it takes no longer than it may."""

import os
import signal
import struct
import sys
import threading

import numpy as np
import pytest

from nao_course.codec import PREFIX_SIZE, encode
from nao_course.instructor.sandbox import protocol
from nao_course.instructor.sandbox.protocol import OF_A_WORKER, Ended, describe_end, scrubbed_environment

posix = pytest.mark.skipif(sys.platform == "win32", reason="pipes that can be polled")
AMPLE = 120.0  # seconds


class Piped(protocol.Channel):
    """A channel whose other end is in this process."""

    def __init__(self):
        (self.their_requests, requests), (replies, self.their_replies) = os.pipe(), os.pipe()
        super().__init__(requests, replies)
        self.all = {self.their_requests, requests, replies, self.their_replies}

    def how_it_ended(self):
        return "it is gone"

    def close(self, descriptor):
        self.all.remove(descriptor)
        os.close(descriptor)


@pytest.fixture
def channel():
    made = Piped()
    yield made
    for each in made.all:
        os.close(each)


@posix
@pytest.mark.parametrize("value", [7, ("found", ["f"], {"a": "é"}), np.arange(10**6)], ids=type)
def test_what_is_said_is_what_is_received(channel, value):
    frame = encode(value)

    def say():
        rest = memoryview(frame)
        while rest:
            rest = rest[os.write(channel.their_replies, rest) :]

    thread = threading.Thread(target=say)
    thread.start()
    np.testing.assert_equal(channel.receive(), value)
    thread.join()
    assert channel.size == len(frame) - PREFIX_SIZE


@posix
@pytest.mark.parametrize("sent", [b"", b"NAO1", encode(np.zeros(999))[:2000]], ids=len)
def test_half_an_answer_costs_its_time_and_one_that_ends_there_says_so(channel, sent):
    os.write(channel.their_replies, sent)
    channel.ask(b"", 0.05)
    with pytest.raises(Ended, match=r"no answer within 0.05 s"):
        channel.receive()
    channel.ask(b"", AMPLE)
    channel.close(channel.their_replies)
    with pytest.raises(Ended, match="it is gone"):
        channel.receive()


@posix
@pytest.mark.parametrize("sent", [b"HTTP/1.1 200 OK and more", struct.pack("<4sQQ", b"NAO1", 10, 2**62)])
def test_what_is_no_frame_is_given_up_before_it_is_read(channel, sent):
    channel.ask(b"", AMPLE)
    os.write(channel.their_replies, sent)
    with pytest.raises(Ended, match=protocol.UNREADABLE):
        channel.receive()


@posix
def test_a_process_that_reads_no_more_or_never_ends_costs_its_time_alone(channel, monkeypatch):
    with pytest.raises(Ended, match=r"no answer within 0.05 s"):
        channel.ask(bytes(2**24), 0.05)
    channel.close(channel.their_requests)
    with pytest.raises(Ended, match="it is gone"):
        channel.ask(bytes(2**24), AMPLE)
    monkeypatch.setattr(protocol, "_ready", lambda *_: True)
    channel.ask(b"", 0.0)
    for _ in range(protocol._MOST_OVERDUE):
        channel.wait(channel.replies, "read")
    with pytest.raises(Ended, match="no end of its answer"):
        channel.wait(channel.replies, "read")


@posix
def test_how_a_process_ended_is_said_and_a_new_one_is_told_nothing_but_what_it_needs(monkeypatch):
    monkeypatch.setenv("A_SECRET", "1")
    assert "A_SECRET" not in scrubbed_environment()
    assert scrubbed_environment("A_SECRET", "NOT_THERE")["A_SECRET"] == "1"
    assert scrubbed_environment().items() >= OF_A_WORKER.items()
    assert describe_end(3) == "the process ended itself with status 3"
    assert describe_end(-signal.SIGKILL) == "the process was ended by signal 9 (Killed)"
