"""Large notebooks are parsed in a confined process, one at a time, and lose their outputs there."""

import json
import sys
import threading

import pytest

from nao_course.exercises.notebook_text import without_outputs as parsed_here
from nao_course.instructor.sandbox import large_notebooks
from nao_course.instructor.sandbox.large_notebooks import without_outputs
from nao_course.instructor.sandbox.layers import probe
from nao_course.instructor.sandbox.protocol import Allowance, Ended
from nao_course.instructor.sandbox.warm_server import WarmServer
from tests.toy import toy


@pytest.fixture(scope="module")
def server():
    if not sys.platform.startswith("linux"):
        pytest.skip("the warm server forks on Linux alone")
    with WarmServer(probe(), warm=False) as server:
        yield server


def shortened(content, server, name="own.ipynb", allowance=None):
    parts = (content[start : start + 2**20] for start in range(0, len(content), 2**20))
    return without_outputs(name, len(content), parts, server, allowance or Allowance())


@pytest.fixture
def large(tmp_path):
    notebook = json.loads(toy.write(tmp_path / "own.ipynb", "def one(): return 1").read_bytes())
    notebook["cells"][0]["outputs"] = [{"output_type": "stream", "name": "stdout", "text": "x" * 5 * 2**20}]
    return json.dumps(notebook).encode()


def test_it_loses_its_outputs_in_every_kind_of_process_and_its_time_counts(large, server):
    allowance = Allowance()
    made = shortened(large, server, allowance=allowance)
    assert b"def one" in made and allowance.spent > 0
    assert made == shortened(large, None) == parsed_here("own.ipynb", large)
    with pytest.raises(Ended, match="used up"):
        shortened(large, server, allowance=Allowance(0.0))


def refusal(content, server):
    with pytest.raises(Ended) as ended:
        shortened(content, server)
    assert ended.value.outcome.status == "not found"
    return ended.value.outcome.text


@pytest.mark.parametrize("content", [b"[" * 10**7, b"{" + b" " * 10**7, b"[" + b"[]," * 10**6 + b"[]]"])
def test_what_is_no_notebook_is_refused_with_the_reason(content, server):
    with pytest.raises(ValueError, match="own.ipynb") as reason:
        parsed_here("own.ipynb", content)
    assert refusal(content, server) == str(reason.value)


def test_a_reason_cannot_control_a_terminal(server):
    kernel = {"kernelspec": {"language": "\x1b[2J\u202eR"}}
    cells = [{"cell_type": "code", "source": "x <- 1", "metadata": {}}]
    content = json.dumps({"nbformat": 4, "metadata": kernel, "cells": cells}).encode()
    assert refusal(content, server) == "own.ipynb: expected a notebook in Python, got  [2J R"


def test_one_is_read_at_a_time(large, monkeypatch):
    running, most = [], []
    start = large_notebooks.start_process

    def started(*given):
        running.append(1)
        most.append(len(running))
        channel = start(*given)
        kill = channel.kill
        monkeypatch.setattr(channel, "kill", lambda: (kill(), running.pop()))
        return channel

    monkeypatch.setattr(large_notebooks, "start_process", started)
    threads = [threading.Thread(target=shortened, args=(large, None)) for _ in range(3)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert most == [1, 1, 1]
