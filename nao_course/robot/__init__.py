"""Robots of one interface: the simulated one, a real NAO over the network, and a recorded drive.

`RealNao` and the emulated NAO need the package ``qi``: ``pip install "nao-course[robot]"``.
"""

from nao_course.robot.cameras import read_offsets, write_offsets
from nao_course.robot.interface import PlacedNao, Robot, RobotError
from nao_course.robot.real import RealNao
from nao_course.robot.recording import RecordedNao, Recorder

__all__ = [
    "PlacedNao",
    "RealNao",
    "RecordedNao",
    "Recorder",
    "Robot",
    "RobotError",
    "read_offsets",
    "write_offsets",
]
