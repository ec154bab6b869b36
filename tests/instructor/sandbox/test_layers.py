"""A level is all of its layers, and what is missing on a machine is named with its reason."""

import os
import subprocess
import sys

import pytest

from nao_course.instructor.sandbox import layers as module
from nao_course.instructor.sandbox.layers import LEVELS, Layer, Sandbox, SandboxError, probe
from tests.paths import PROJECT
from tests.sandboxed import need

NAMESPACES = module.NAMESPACES
ALL = module.LINUX_LAYERS
linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="layers of Linux's kernel")


def made(*on):
    return Sandbox(tuple(Layer(name, name in on, "" if name in on else f"{name} is off") for name in ALL))


def test_the_level_is_the_highest_all_of_whose_layers_work_and_what_is_missing_is_named():
    for on, level in [
        ((), "process"),
        (("landlock",), "landlock"),
        (NAMESPACES, "namespaces"),
        ((*NAMESPACES, "landlock"), "namespaces"),
        ((*NAMESPACES[1:], "landlock", "seccomp"), "landlock"),
        (ALL, "full"),
    ]:
        sandbox = made(*on)
        assert sandbox.level == level
        assert f"level {level!r}" in str(sandbox)
        assert "\n" not in str(sandbox)
        for each in LEVELS[: LEVELS.index(level) + 1]:
            if each == level or set(module._NEEDS[each]) <= set(on):
                sandbox.require(each)
    with pytest.raises(SandboxError, match="'full' is required.*'namespaces'.*no seccomp: seccomp is off"):
        made(*ALL[:5], "landlock", "unprivileged user").require("full")
    with pytest.raises(ValueError, match="one of process, landlock, namespaces, full; got 'strong'"):
        made().require("strong")
    assert "STUDENTS' CODE CAN READ" in str(made())


def test_the_machine_is_tried_once_and_off_linux_has_processes_with_limits_and_no_more(monkeypatch):
    sandbox = probe()
    assert {layer.name for layer in sandbox.layers} >= set(ALL)
    assert all(layer.detail for layer in sandbox.layers if not layer.on)
    assert probe() is sandbox
    monkeypatch.setattr(sys, "platform", "darwin")
    sandbox = probe.__wrapped__()
    assert sandbox.level == "process" and "not on darwin" in str(sandbox)


def test_both_ends_can_be_imported_where_there_is_no_linux():
    for end in ["worker", "fork_server"]:
        named = f"nao_course.instructor.sandbox.{end}"
        code = f"import sys, nao_course.exercises; sys.platform = 'darwin'; import {named}; print(1)"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=PROJECT)
        assert done.stdout == "1\n", done.stderr


@linux
def test_a_private_umask_takes_no_layer_away():
    before = os.umask(0o077)
    try:
        found = probe.__wrapped__()
    finally:
        os.umask(before)
    assert found == probe()


@linux
def test_ci_has_the_highest_level():
    assert need(*ALL).level == "full"
