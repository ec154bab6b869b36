"""A simulated NAO behind the real protocol: the services of NAOqi that `RealNao` uses, over libqi."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray, rotation_3d
from nao_course.robot.naoqi import CAMERAS, RESOLUTIONS, RGB, as_list, import_qi
from nao_course.sim import CameraView, SimulatedNao, Truth
from nao_course.slam import Motion

WALK_SPEED, TURN_SPEED = 0.12, 0.5  # m/s and rad/s of a NAO that walks safely
STEP, TURN_STEP = 0.01, float(np.radians(2))  # m and rad: a walk can be stopped after each of them
SUBSCRIBERS = 8  # subscriptions that the robot's cameras have at a time
JOINTS = ("HeadYaw", "HeadPitch", "LKneePitch", "RKneePitch", "LAnklePitch", "RAnklePitch")
OVERHEATED = 80.0  # degrees Celsius
SENSED_TILT = float(np.radians(0.3))  # rad: standard deviation of the tilt that the inertial sensor measures


class EmulatedNao:
    """The state of an emulated robot: a `SimulatedNao`, and what can go wrong with a real one.

    `pace` is how many times faster than a real robot it walks. Set `fallen`, `battery` or `temperatures` to practise
    what then happens.
    """

    def __init__(self, nao: SimulatedNao, pace: float = 1.0) -> None:
        """Begin asleep."""
        self.nao, self.pace = nao, pace
        self.lock = threading.RLock()
        self.stopped = threading.Event()
        self.awake = self.fallen = False
        self.life = "solitary"
        self.battery = 0.8
        self.temperatures = dict.fromkeys(JOINTS, 38.0)
        self.memory: dict[str, Any] = {}
        self.subscribers: dict[str, tuple[str, tuple[int, int]]] = {}
        self._rng = np.random.default_rng(7)
        self._seen: dict[str, tuple[tuple[float, float], CameraView]] = {}
        self.nao.take_picture()  # the first one takes longest, and no client waits for it

    def move(self, motion: Motion) -> bool:
        """Run a motion in the time that it takes; return whether it was not stopped."""
        self.stopped.clear()
        count = max(1, int(np.ceil(max(abs(motion.distance) / STEP, abs(motion.turn) / TURN_STEP))))
        seconds = abs(motion.distance) / WALK_SPEED + abs(motion.turn) / TURN_SPEED
        for _ in range(count):
            if self.stopped.wait(seconds / count / self.pace) or self.fallen or not self.awake:
                return False
            with self.lock:
                self.nao.move(Motion(motion.distance / count, motion.turn / count))
        return True

    def fall(self) -> None:
        """Make the robot fall: it lies on the ground, and its walk ends."""
        self.fallen = True
        self.stopped.set()

    def look(self, camera: str, size: tuple[int, int]) -> tuple[Any, CameraView]:
        """Return the pixels of a camera and its true view."""
        with self.lock:
            pixels = self.nao.take_picture(camera, size).pixels
            truth = Truth(self.nao).picture
            assert truth is not None
            self._seen[camera] = (self.nao.head, truth.view)
        return pixels, truth.view

    def transform(self, camera: str) -> FloatArray:
        """Return the matrix (4, 4) of a camera in the robot frame, as joints and inertial sensor measure it.

        The body tilt is the one of the latest picture, because the simulated robot has another one in each picture.
        """
        with self.lock:
            head, view = self._seen.get(camera, ((np.nan, np.nan), None))
            if view is None or head != self.nao.head:
                view = self.nao.view(camera)
            pitch, roll = self._rng.normal(0.0, SENSED_TILT, 2)
        matrix = np.eye(4)
        matrix[:3, :3] = rotation_3d(0.0, pitch, roll) @ view.rotation
        matrix[:3, 3] = view.position
        return matrix

    def practise(self, line: str) -> str:
        """Let something happen to the robot that happens to real ones, and return what has happened, in words."""
        word, *rest = line.split() or [""]
        if word == "fall" and not rest:
            self.fall()
            return "the robot lies on the ground"
        if word == "battery" and len(rest) == 1 and rest[0].isdecimal() and int(rest[0]) <= 100:
            self.battery = int(rest[0]) / 100
            return f"the battery has {rest[0]} %"
        if word == "heat" and len(rest) == 1 and rest[0] in JOINTS:
            self.temperatures[rest[0]] = OVERHEATED
            return f"{rest[0]} has {OVERHEATED:.0f} °C"
        return f"write  fall,  battery 10  or  heat {JOINTS[0]}  (joints: {', '.join(JOINTS)})"


class _Motion:
    def __init__(self, robot: EmulatedNao) -> None:
        self._robot = robot

    def wakeUp(self) -> None:  # noqa: N802 - the service's names
        self._robot.awake, self._robot.fallen = True, False

    def rest(self) -> None:
        self._robot.awake = False
        self._robot.stopped.set()

    def robotIsWakeUp(self) -> bool:  # noqa: N802
        return self._robot.awake

    def moveTo(self, x: float, y: float, theta: float, config: Any = None) -> bool:  # noqa: N802
        return self._robot.awake and self._robot.move(Motion(float(x), float(theta)))

    def stopMove(self) -> None:  # noqa: N802
        self._robot.stopped.set()

    def getRobotPosition(self, sensors: bool) -> list[float]:  # noqa: N802
        with self._robot.lock:
            pose = self._robot.nao.odometry
        return as_list((pose.x, pose.y, pose.theta))

    def getAngles(self, names: Any, sensors: bool) -> list[float]:  # noqa: N802
        return as_list(self._robot.nao.head)

    def setAngles(self, names: Any, angles: Any, speed: float) -> None:  # noqa: N802
        with self._robot.lock:
            self._robot.nao.look(*map(float, angles))

    def setStiffnesses(self, names: Any, stiffness: float) -> None:  # noqa: N802
        if names == "Body" and not stiffness:
            self._robot.awake = False

    def getTransform(self, name: str, frame: int, sensors: bool) -> list[float]:  # noqa: N802
        return as_list(self._robot.transform(name.removeprefix("Camera").lower()).ravel().tolist())

    def getBodyNames(self, name: str) -> list[str]:  # noqa: N802
        return list(JOINTS)


class _Posture:
    def __init__(self, robot: EmulatedNao) -> None:
        self._robot = robot

    def goToPosture(self, name: str, speed: float) -> bool:  # noqa: N802
        return self._robot.awake and not self._robot.fallen


class _Life:
    def __init__(self, robot: EmulatedNao) -> None:
        self._robot = robot

    def getState(self) -> str:  # noqa: N802
        return self._robot.life

    def setState(self, state: str) -> None:  # noqa: N802
        self._robot.life = state


class _Memory:
    def __init__(self, robot: EmulatedNao) -> None:
        self._robot = robot

    def getData(self, key: str) -> Any:  # noqa: N802
        if key == "robotHasFallen":
            return self._robot.fallen
        if key.startswith("Device/SubDeviceList/Battery"):
            return float(self._robot.battery)
        if key.endswith("/Temperature/Sensor/Value"):
            return float(self._robot.temperatures[key.split("/")[2]])
        if key not in self._robot.memory:
            raise RuntimeError(f"{key} is not in ALMemory")
        return self._robot.memory[key]

    def getListData(self, keys: Any) -> list[Any]:  # noqa: N802
        return [self.getData(key) for key in keys]

    def insertData(self, key: str, value: Any) -> None:  # noqa: N802
        self._robot.memory[key] = value


class _Video:
    def __init__(self, robot: EmulatedNao) -> None:
        self._robot = robot

    def subscribeCamera(self, name: str, camera: int, resolution: int, space: int, rate: int) -> str:  # noqa: N802
        subscribers = self._robot.subscribers
        if len(subscribers) >= SUBSCRIBERS or space != RGB:
            return ""
        handle = f"{name}_0"
        subscribers[handle] = (list(CAMERAS)[camera], list(RESOLUTIONS)[resolution])
        return handle

    def unsubscribe(self, handle: str) -> bool:
        return self._robot.subscribers.pop(handle, None) is not None

    def getSubscribers(self) -> list[str]:  # noqa: N802
        return list(self._robot.subscribers)

    def getImageRemote(self, handle: str) -> tuple[Any, ...]:  # noqa: N802
        camera, size = self._robot.subscribers[handle]
        pixels, view = self._robot.look(camera, size)
        now = time.time()
        across, down = view.hfov / 2, view.vfov / 2
        whole, part = int(now), int(1e6 * (now % 1))
        data = pixels.tobytes()
        return (*size, 3, RGB, whole, part, data, CAMERAS[camera], across, down, -across, -down)


@contextmanager
def served(robot: EmulatedNao, port: int = 9559, host: str = "127.0.0.1") -> Iterator[str]:
    """Publish an emulated robot's services in the block, and yield their address.

    Raise a RobotError if the package ``qi`` is missing, and an OSError if the port is taken.
    """
    qi = import_qi()
    session = qi.Session()
    address = f"tcp://{host}:{port}"
    try:
        session.listenStandalone(address)
    except RuntimeError as error:
        raise OSError(f"{address} cannot be served ({error}): give another --port") from error
    picture = qi.bind("(iiiiiiriffff)", [qi.String])(_Video.getImageRemote)
    video = type("_Video", (_Video,), {"getImageRemote": picture})
    services = {
        "ALMotion": _Motion,
        "ALRobotPosture": _Posture,
        "ALAutonomousLife": _Life,
        "ALMemory": _Memory,
        "ALVideoDevice": video,
    }
    try:
        for name, service in services.items():
            session.registerService(name, qi.multiThreaded()(service)(robot))
        yield address
    finally:
        session.close()
