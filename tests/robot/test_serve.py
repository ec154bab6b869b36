"""The command with which a class practises: a robot in a process of its own, told from its terminal what happens."""

import signal
import subprocess
import sys

import pytest

from nao_course.robot import RealNao
from tests.paths import PROJECT
from tests.robot.emulated import free_port


@pytest.mark.skipif(sys.platform == "win32", reason="qi is not for Windows")
def test_a_served_robot_answers_falls_when_it_is_told_to_and_ends_at_ctrl_c():
    pytest.importorskip("qi", reason="the package qi is for Linux and Python 3.11 and 3.12")
    port = free_port()
    command = [sys.executable, "-u", "-m", "nao_course.cli", "robot", "serve", "--port", str(port)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "cwd": PROJECT}
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, **pipes) as server:
        said = iter(server.stdout.readline, "")
        assert f'RealNao("tcp://127.0.0.1:{port}", model="V4")' in next(
            each for each in said if "listens" in each
        )
        second = subprocess.run(command, capture_output=True, text=True, cwd=PROJECT, check=False, timeout=60)
        assert second.returncode == 1 and "give another --port" in second.stdout + second.stderr
        with RealNao(f"tcp://127.0.0.1:{port}", model="V4") as nao:
            nao.wake_up()
            server.stdin.write("fall\n")
            server.stdin.flush()
            assert any("the robot lies on the ground" in each for each in said)
            assert nao.warnings() == ("it has fallen: put it on its feet and call wake_up()",)
        server.send_signal(signal.SIGINT)
        server.communicate()
    assert server.returncode == 0, server.returncode
