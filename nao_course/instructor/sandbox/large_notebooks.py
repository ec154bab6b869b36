"""Large notebooks without their outputs, read one at a time: to parse JSON takes several times its size in memory."""

import tempfile
import threading
from collections.abc import Iterable
from pathlib import Path

from nao_course.codec import encode
from nao_course.instructor.sandbox.processes import start_process, wait_until_ready
from nao_course.instructor.sandbox.protocol import Allowance, Ended, printable
from nao_course.instructor.sandbox.warm_server import WarmServer

SECONDS = 30.0  # for one notebook; 50 MB take about one second
_one_at_a_time = threading.Lock()


def without_outputs(
    name: str, size: int, parts: Iterable[bytes], server: WarmServer | None, allowance: Allowance
) -> bytes:
    """Return a notebook without its outputs; a confined process parses it, and runs none of its code.

    The content comes in parts, so that it is never in the grader's memory as a whole; the result is as of
    `definitions.without_outputs`. Raise Ended if it is not a notebook, takes too long or ends the process, and a
    SandboxError or ServerEnded as `start_process` does.
    """
    with _one_at_a_time:
        channel = start_process(server, Path(tempfile.gettempdir()))
        try:
            wait_until_ready(channel)
            channel.ask(encode(("shorten", name, size)), allowance.left(SECONDS))
            for part in parts:
                channel.send(part)
            match channel.receive():
                case ("shortened", bytes(content)):
                    return content
                case ("refused", str(reason)):
                    raise Ended("not found", printable(reason))
                case _:
                    channel.give_up()
        finally:
            allowance.spend(channel.used())
            channel.kill()
