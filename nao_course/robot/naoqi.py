"""Calls of a NAO's services over libqi, each with a time limit and with a reply that is checked."""

from __future__ import annotations

import re
import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.robot.interface import RobotError

SECONDS = 3.0  # of a call that takes no time on the robot
ADDRESS = re.compile(r"tcp://[^\s/:]+:\d{1,5}")
# What a dead connection says in libqi 3.1.5; all other errors are about the call.
_LOST = (
    "Service removed",
    "Session closed",
    "Socket is not connected",
    "Connect error",
    "disconnected",
    "Call or Bind error",
)
NO_QI = (
    'the package "qi" is missing: run  pip install "nao-course[robot]"  with Python 3.11 or 3.12 on Linux (x86-64), or '
    "3.12 on a Mac with Apple silicon; there is no qi for other systems"
)
RGB = 11  # ALVideoDevice's number of this colour space
RESOLUTIONS = {(160, 120): 0, (320, 240): 1, (640, 480): 2, (1280, 960): 3}
CAMERAS = {"top": 0, "bottom": 1}


class ConnectionLostError(RobotError):
    """The robot does not answer any more."""


def import_qi() -> Any:
    """Return the module of libqi; raise a RobotError that says how to install it."""
    try:
        import qi
    except ImportError as error:
        raise RobotError(NO_QI) from error
    return qi


class Naoqi:
    """A connection to a robot's services, such as ``tcp://192.168.1.23:9559``.

    After a connection is lost, the next call connects again and asks for the services again, because libqi's old
    proxies stay dead although they call themselves valid.
    """

    def __init__(self, address: str, seconds: float = SECONDS) -> None:
        """Connect; raise a RobotError if there is no robot at this address."""
        if not ADDRESS.fullmatch(str(address)):
            raise RobotError(f'address must be like "tcp://192.168.1.23:9559", got {address!r}')
        self.address, self.seconds = address, seconds
        self._session: Any = None
        self._services: dict[str, Any] = {}
        self._connecting = threading.Lock()  # the heartbeat's thread calls, too
        self._connect()

    def call(self, service: str, method: str, *args: Any, seconds: float | None = None) -> Any:
        """Call a method and return its reply, unchecked.

        Raise a ConnectionLostError if the robot does not answer, and a RobotError if it refuses the call.
        """
        return self.wait(self.begin(service, method, *args), f"{service}.{method}", seconds)

    def begin(self, service: str, method: str, *args: Any) -> Any:
        """Begin a call and return its future."""
        return self._service(service).call(method, *args, _async=True)

    def wait(self, future: Any, what: str, seconds: float | None = None) -> Any:
        """Return the reply of a call that was begun, after at most some seconds."""
        try:
            return future.value(int(1000 * (self.seconds if seconds is None else seconds)))
        except RuntimeError as error:
            raise self._described(error, what) from error

    def numbers(self, reply: Any, count: int, what: str) -> FloatArray:
        """Return a reply as a given number of finite floats; raise a RobotError if it is anything else."""
        try:
            found = np.asarray(reply, dtype=float)
        except (TypeError, ValueError, OverflowError):
            found = np.empty(0)
        if found.shape != (count,) or not np.isfinite(found).all():
            shown = repr(reply)
            raise RobotError(
                f"{what} must answer with {count} numbers, got {shown[:60]}{'…' if shown[60:] else ''}"
            )
        return found

    @property
    def is_connected(self) -> bool:
        """Whether the connection is open, as far as libqi knows."""
        return self._session is not None and bool(self._session.isConnected())

    def close(self) -> None:
        """Close the connection."""
        if self._session is not None:
            self._session.close()
        self._session, self._services = None, {}

    def _connect(self) -> None:
        session = import_qi().Session()
        try:
            session.connect(self.address, _async=True).value(int(1000 * self.seconds))
        except RuntimeError as error:
            raise ConnectionLostError(
                f"no robot answers at {self.address} ({error}). Is it switched on and in the same network? "
                "Press its chest button: it says its address."
            ) from error
        self._session, self._services = session, {}

    def _service(self, name: str) -> Any:
        with self._connecting:
            if not self.is_connected:
                self._connect()
        if name not in self._services:
            found = self._session.service(name, _async=True)
            self._services[name] = self.wait(found, f"the service {name}")
        return self._services[name]

    def _described(self, error: RuntimeError, what: str) -> RobotError:
        said = str(error).strip().split("\n")[0]  # below it are the lines of the service that failed
        if "timeout" in said.lower():
            return ConnectionLostError(f"{what} did not answer in time. Is the robot still in the network?")
        if not self.is_connected or any(each in said for each in _LOST):
            self._services = {}
            return ConnectionLostError(f"the connection to the robot at {self.address} is lost ({said})")
        if "Cannot find service" in said:
            return RobotError(f"{what} is not running on this robot. Is it a NAO with NAOqi 2?")
        return RobotError(f"{what}: {said}")


def pixels_of(reply: Any, size: tuple[int, int]) -> npt.NDArray[np.uint8]:
    """Return the pixels (H, W, 3) of ALVideoDevice's reply to getImageRemote.

    Its elements are width, height, number of layers, colour space, seconds, microseconds, bytes, camera and four
    angles. Raise a RobotError if this is not an RGB picture of this size.
    """
    if reply is None:
        raise RobotError("the camera has no picture: its subscription has ended, or too many programs use it")
    if not isinstance(reply, list | tuple) or len(reply) < 7:
        raise RobotError(f"getImageRemote must answer with a picture, got {type(reply).__name__}")
    width, height, layers, colour_space, _, _, data, *_ = reply
    if (width, height) != size or layers != 3 or colour_space != RGB:
        raise RobotError(
            f"the camera must answer with {size[0]} x {size[1]} RGB pixels, got {width} x {height}, "
            f"{layers} layers, colour space {colour_space}"
        )
    if not isinstance(data, bytes | bytearray) or len(data) != 3 * size[0] * size[1]:
        got = f"{len(data)} bytes" if isinstance(data, bytes | bytearray) else type(data).__name__
        raise RobotError(f"a picture of {size[0]} x {size[1]} has {3 * size[0] * size[1]} bytes, got {got}")
    return np.frombuffer(bytes(data), np.uint8).reshape(height, width, 3)


def transform_of(reply: Any, naoqi: Naoqi) -> FloatArray:
    """Return the matrix (4, 4) of ALMotion's reply to getTransform; raise a RobotError if it is not a rigid motion."""
    matrix = naoqi.numbers(reply, 16, "ALMotion.getTransform").reshape(4, 4)
    rotation = matrix[:3, :3]
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-3 or np.linalg.det(rotation) < 0:
        raise RobotError("ALMotion.getTransform must answer with a rotation and a position")
    return matrix


def as_list(values: Sequence[float]) -> list[float]:
    """Return numbers as libqi can send them: it refuses NumPy's."""
    return [float(each) for each in values]
