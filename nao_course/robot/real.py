"""A real NAO, or an emulated one, over the network."""

from __future__ import annotations

import atexit
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any
from uuid import uuid4

import numpy as np
import numpy.typing as npt

from nao_course.geometry import Pose, finite, yaw_pitch_roll
from nao_course.robot.cameras import read_offsets
from nao_course.robot.interface import MODELS, PlacedNao, RobotError
from nao_course.robot.naoqi import (
    CAMERAS,
    RESOLUTIONS,
    RGB,
    ConnectionLostError,
    Naoqi,
    as_list,
    pixels_of,
    transform_of,
)
from nao_course.robot.recording import Recorder
from nao_course.sim import CameraView, Field, NaoModel, Picture
from nao_course.slam import Motion

LONGEST_WALK, LONGEST_TURN = 2.0, 2 * np.pi  # m and rad of one command
# m and rad of one command on the wire: after it the robot stands, also when the laptop has vanished
PART, TURN_PART = 0.3, float(np.radians(60))
SLOWEST_WALK, SLOWEST_TURN = 0.02, 0.1  # m/s and rad/s
SETTLING = 5.0  # s beside the time at these speeds, after which a motion is stopped
POLL, FALL_POLL = 0.02, 0.2  # s after which a motion, and the sensor of falls, is asked again
HEAD_SPEED = 0.2  # fraction of the joints' largest speed
HEAD_SECONDS, HEAD_CLOSE = 4.0, float(np.radians(1.5))
STAND = "StandInit"
STEP_FREQUENCY = 0.6  # of the fastest, for a safe walk
ROBOT_FRAME, USE_SENSORS = 2, True
FRAMES_PER_SECOND = 30
OWN_NAME = "nao_course"  # of the cameras' subscriptions
FALLEN, DRIVER = "robotHasFallen", "nao_course/driver"
BATTERY = "Device/SubDeviceList/Battery/Charge/Sensor/Value"
TEMPERATURE = "Device/SubDeviceList/{}/Temperature/Sensor/Value"
LOW_BATTERY, HOT = 0.2, 70.0  # fraction, degrees Celsius
BEAT = 0.5  # s between two signs of life of the program that drives


class RealNao(PlacedNao):
    """A NAO of the generations V4 to V6 in the same network.

    Nothing moves before `wake_up`. Use it in a ``with`` block: at its end, also after an error, the robot stops. Every
    command that is sent walks at most 0.3 m or turns at most 60 degrees, so a robot whose laptop has vanished stands
    still after that.

    Parameters
    ----------
    address : str
        Address of the robot, ``tcp://192.168.1.23:9559``; it says its number when its chest button is pressed.
    field : Field, optional
        Field it is on; by default half a field by the rules of 2012.
    model : "V4", "V5" or "V6"
        Generation of the robot.
    start : Pose, optional
        Where it was put, in the world frame; by default on the halfway line, facing the goal.
    cameras : str or Path, optional
        File with the offsets of this robot's cameras, which ``nao-course demo --recording`` writes.
    record : str or Path, optional
        Folder for a recording of the drive; see `Recorder`.
    seconds : float
        Seconds after which a call that takes no time counts as unanswered.

    Raises
    ------
    RobotError
        If no robot answers, the package ``qi`` is missing, the model is unknown, or a file is not valid.

    Examples
    --------
    >>> with RealNao("tcp://192.168.1.23:9559", model="V6") as nao:  # doctest: +SKIP
    ...     nao.wake_up()
    ...     nao.walk(0.3)
    ...     picture = nao.take_picture("top")
    """

    def __init__(
        self,
        address: str,
        field: Field | None = None,
        *,
        model: str = "V6",
        start: Pose | None = None,
        cameras: str | Path | None = None,
        record: str | Path | None = None,
        seconds: float = 3.0,
    ) -> None:
        """Connect to the robot, without moving it."""
        if model not in MODELS:
            raise RobotError(f"model must be one of {', '.join(MODELS)}, got {model!r}")
        super().__init__(field, MODELS[model], start)
        self._offsets = {} if cameras is None else read_offsets(cameras)
        self._naoqi = Naoqi(address, seconds)
        self._identity = f"{OWN_NAME}_{uuid4().hex[:8]}"
        self._subscriptions: dict[tuple[str, tuple[int, int]], str] = {}
        self._stopping = threading.Event()
        self._moving = threading.Lock()
        self._leaving = threading.Event()
        self._heart: threading.Thread | None = None
        self._awake = self._closed = False
        self.recorder: Recorder | None = None
        try:
            self._origin = self._robot_position()
            if record is not None:
                self.record(record)
        except BaseException:
            self._naoqi.close()
            raise
        atexit.register(self.close)  # a notebook's kernel that ends stops the robot

    def __repr__(self) -> str:
        """Show the model, the address and the odometry."""
        return f"RealNao({self.model.name} at {self._naoqi.address}, odometry {self.odometry})"

    def __enter__(self) -> RealNao:
        """Return the robot."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Stop the robot and close the connection."""
        self.close()

    # --- posture ---

    def wake_up(self) -> None:
        """Switch the motors on and stand; the robot then accepts motions.

        Raises
        ------
        RobotError
            If another program drives the robot, or it has fallen or cannot stand.
        """
        self._claim()
        if self._call("ALAutonomousLife", "getState") != "disabled":
            self._call("ALAutonomousLife", "setState", "disabled", seconds=15)
        self._call("ALMotion", "wakeUp", seconds=20)
        if not self._call("ALRobotPosture", "goToPosture", STAND, 0.5, seconds=30):
            raise RobotError(
                "the robot cannot stand up: put it on its feet, with room around it, and try again"
            )
        self._refuse_fallen()
        # A robot that was switched off in between begins its odometry anew.
        self._origin = self._robot_position() @ self.odometry.inverse()
        self._awake = True
        if self._heart is None:
            self._heart = threading.Thread(target=self._beat, name="nao_course heartbeat", daemon=True)
            self._heart.start()

    def rest(self) -> None:
        """Stop, sit down, and switch the motors off."""
        self.stop()
        self._awake = False
        self._call("ALMotion", "rest", seconds=20)

    def close(self) -> None:
        """Stop the robot, give the cameras back and close the connection."""
        atexit.unregister(self.close)
        with suppress(RobotError):
            self.stop()
        self._leaving.set()
        if self._heart is not None:
            self._heart.join()  # libqi ends Python if a thread is in a call at its end
        for handle in self._subscriptions.values():
            with suppress(RobotError):
                self._call("ALVideoDevice", "unsubscribe", handle)
        self._subscriptions = {}
        self._awake, self._closed = False, True
        self._naoqi.close()
        self.record(None)

    def record(self, folder: str | Path | None) -> None:
        """Record the drive into a new folder from now on; None ends the recording. See `Recorder`."""
        new = None if folder is None else Recorder(folder, self)
        if self.recorder is not None:
            self.recorder.close()
        self.recorder = new

    def warnings(self) -> tuple[str, ...]:
        """Return what should be known before the next drive: a low battery, hot joints, a fall."""
        found = []
        if self._call("ALMemory", "getData", FALLEN):
            found.append("it has fallen: put it on its feet and call wake_up()")
        charge = self._naoqi.numbers([self._call("ALMemory", "getData", BATTERY)], 1, "the battery")[0]
        if charge < LOW_BATTERY:
            found.append(f"its battery has {100 * charge:.0f} %: charge it before the next drive")
        joints = list(self._call("ALMotion", "getBodyNames", "Body"))
        reply = self._call("ALMemory", "getListData", [TEMPERATURE.format(each) for each in joints])
        degrees = self._naoqi.numbers(reply, len(joints), "the joints' temperatures")
        found += [
            f"{joint} has {value:.0f} °C: let it rest for some minutes"
            for joint, value in zip(joints, degrees, strict=True)
            if value > HOT
        ]
        return tuple(found)

    # --- values that the robot knows ---

    @property
    def head(self) -> tuple[float, float]:
        """Angles (yaw, pitch) of the head's joints as they are measured, rad; positive to the left and down."""
        reply = self._call("ALMotion", "getAngles", ["HeadYaw", "HeadPitch"], USE_SENSORS)
        yaw, pitch = self._naoqi.numbers(reply, 2, "ALMotion.getAngles")
        return float(yaw), float(pitch)

    def view(self, camera: str = "bottom", size: tuple[int, int] = (320, 240)) -> CameraView:
        """Return a camera's view by the robot's own sensors, with the body tilt that they measure."""
        reply = self._call("ALMotion", "getTransform", *_camera_frame(self.model, camera))
        return self._corrected(self._measured_view(camera, size, reply), camera)

    # --- commands ---

    def walk(self, distance: float) -> Motion:
        """Walk ahead by at most 2 m, or backwards for a negative distance; see `move`."""
        if abs(finite("distance (m)", distance)) > LONGEST_WALK:
            raise ValueError(f"distance must be within -2..2 m in one command, got {distance}")
        return super().walk(distance)

    def turn(self, angle: float) -> Motion:
        """Turn on the spot, counterclockwise, by at most one turn in rad; see `move`."""
        if abs(finite("angle (rad)", angle)) > LONGEST_TURN + 1e-9:
            raise ValueError(f"angle must be within one turn, -6.283..6.283 rad, got {angle}")
        return super().turn(angle)

    def move(self, motion: Motion) -> Motion:
        """Run a motion and return it; if it was stopped, return what the odometry says that was run.

        Raises
        ------
        RobotError
            If the robot is not awake, has fallen, does not arrive, or already moves.
        """
        self._refuse_asleep()
        if not self._moving.acquire(blocking=False):
            raise RobotError("the robot already moves: wait, or call stop()")
        try:
            self._stopping.clear()
            self._refuse_fallen()
            arrived = all(self._run(part) for part in _parts(motion))
            done = motion if arrived else _between(self.odometry, self._here())
            self._odometry.append(self._here())
        except BaseException:
            with suppress(RobotError):
                self.stop()
                self._odometry.append(self._here())  # what was run before the error
            raise
        finally:
            self._moving.release()
        if self.recorder is not None:
            self.recorder.motion(done, self.odometry)
        return done

    def look(self, yaw: float = 0.0, pitch: float = 0.0) -> None:
        """Turn the head, and return when it is there; positive to the left and down, rad."""
        target = self.model.check_head(yaw, pitch)
        self._refuse_asleep()
        self._call("ALMotion", "setAngles", ["HeadYaw", "HeadPitch"], as_list(target), HEAD_SPEED)
        end = time.monotonic() + HEAD_SECONDS
        while np.abs(np.subtract(self.head, target)).max() > HEAD_CLOSE:
            if time.monotonic() > end:
                raise RobotError(f"the head did not reach {np.degrees(target).round()} degrees: is it held?")
            time.sleep(POLL)
        if self.recorder is not None:
            self.recorder.look(target)

    def take_picture(
        self, camera: str = "bottom", size: tuple[int, int] = (320, 240), walking: bool = False
    ) -> Picture:
        """Take a picture with the view that the robot's sensors measure right after it.

        Parameters
        ----------
        camera : "top" or "bottom"
            Name of the camera.
        size : (int, int)
            160 x 120, 320 x 240, 640 x 480 or 1280 x 960 px.
        walking : bool
            Has no effect: a real picture is blurred if the robot walks.
        """
        frame, size = _camera_frame(self.model, camera), (int(size[0]), int(size[1]))
        try:
            pixels = self._pixels(camera, size)
        except ConnectionLostError:
            raise
        except RobotError:  # a robot that was switched off in between does not know the subscription
            pixels = self._pixels(camera, size)
        view = self._measured_view(camera, size, self._call("ALMotion", "getTransform", *frame))
        if self.recorder is not None:  # without the offset, so that it can be calibrated again
            self.recorder.picture(Picture(pixels, view, camera), self.head)
        return Picture(pixels, self._corrected(view, camera), camera)

    def stop(self) -> None:
        """Stop at once; a motion that another thread has begun ends."""
        self._stopping.set()
        self._call("ALMotion", "stopMove", seconds=1.0)

    # --- internals ---

    def _call(self, service: str, method: str, *args: Any, seconds: float | None = None) -> Any:
        self._refuse_closed()
        return self._naoqi.call(service, method, *args, seconds=seconds)

    def _run(self, part: Motion) -> bool:
        """Run a part of a motion, and return whether it was not stopped."""
        if self._stopping.is_set():
            return False
        seconds = abs(part.distance) / SLOWEST_WALK + abs(part.turn) / SLOWEST_TURN + SETTLING
        safe = [["MaxStepFrequency", STEP_FREQUENCY]]
        future = self._naoqi.begin("ALMotion", "moveTo", part.distance, 0.0, part.turn, safe)
        began = looked = time.monotonic()
        while future.isRunning():
            if self._stopping.wait(POLL):
                self._naoqi.wait(future, "ALMotion.moveTo")
                return False
            now = time.monotonic()
            if now - looked > FALL_POLL:
                looked = now
                self._refuse_fallen()
            if now - began > seconds:
                raise RobotError(f"the robot did not arrive within {seconds:.0f} s: is something in its way?")
        arrived = self._naoqi.wait(future, "ALMotion.moveTo")
        self._refuse_fallen()
        if arrived is False and not self._stopping.is_set():
            raise RobotError("the robot refuses to walk: is it awake, and are both feet on the ground?")
        return not self._stopping.is_set()

    def _refuse_closed(self) -> None:
        if self._closed:
            raise RobotError("this robot is closed: connect to it again with RealNao(...)")

    def _refuse_asleep(self) -> None:
        self._refuse_closed()
        # A robot that was switched off in between sleeps, and counts its odometry anew.
        self._awake = self._awake and bool(self._call("ALMotion", "robotIsWakeUp"))
        if not self._awake:
            raise RobotError("the robot sleeps: call wake_up(), with its feet on the ground")

    def _refuse_fallen(self) -> None:
        if self._call("ALMemory", "getData", FALLEN):
            self._awake = False
            with suppress(RobotError):
                self._call("ALMotion", "setStiffnesses", "Body", 0.0)
            raise RobotError(
                "the robot has fallen, and its motors are released: put it on its feet and call wake_up()"
            )

    def _robot_position(self) -> Pose:
        reply = self._call("ALMotion", "getRobotPosition", USE_SENSORS)
        return Pose(*map(float, self._naoqi.numbers(reply, 3, "ALMotion.getRobotPosition")))

    def _here(self) -> Pose:
        """Return the present odometry: the robot's position in the frame in which the connection began."""
        return self._origin.inverse() @ self._robot_position()

    def _measured_view(self, camera: str, size: tuple[int, int], reply: Any) -> CameraView:
        matrix = transform_of(reply, self._naoqi)
        yaw, pitch, roll = yaw_pitch_roll(matrix[:3, :3])
        x, y, z = map(float, matrix[:3, 3])
        if z <= 0:
            raise RobotError(f"the camera is {z:.2f} m above the ground by the robot's sensors: is it lying?")
        upright = self.model.view(camera, size=size)
        return replace(upright, height=z, yaw=yaw, pitch=pitch, roll=roll, offset=(x, y))

    def _corrected(self, view: CameraView, camera: str) -> CameraView:
        pitch, roll = self._offsets.get(camera, (0.0, 0.0))
        return replace(view, pitch=view.pitch + pitch, roll=view.roll + roll)

    def _pixels(self, camera: str, size: tuple[int, int]) -> npt.NDArray[np.uint8]:
        """Return a camera's picture; if it cannot be had, the camera is subscribed to again next time."""
        handle = self._subscription(camera, size)
        try:
            return pixels_of(self._call("ALVideoDevice", "getImageRemote", handle), size)
        except RobotError:
            del self._subscriptions[camera, size]
            raise

    def _subscription(self, camera: str, size: tuple[int, int]) -> str:
        """Return the handle of a camera, which the robot gives to a few programs only."""
        if size not in RESOLUTIONS:
            sizes = ", ".join(f"{width} x {height}" for width, height in RESOLUTIONS)
            raise RobotError(f"size must be one of {sizes}, got {size}")
        key = (camera, size)
        if key not in self._subscriptions:
            self._subscriptions[key] = self._subscribe(*key) or self._subscribe_anew(*key)
        return self._subscriptions[key]

    def _subscribe(self, camera: str, size: tuple[int, int]) -> str:
        name = f"{self._identity}_{camera}_{size[0]}"
        number = RESOLUTIONS[size]
        return str(
            self._call(
                "ALVideoDevice", "subscribeCamera", name, CAMERAS[camera], number, RGB, FRAMES_PER_SECOND
            )
        )

    def _subscribe_anew(self, camera: str, size: tuple[int, int]) -> str:
        """Give back what crashed programs of ours have left, and subscribe again."""
        for handle in self._call("ALVideoDevice", "getSubscribers"):
            if str(handle).startswith(OWN_NAME) and not str(handle).startswith(self._identity):
                self._call("ALVideoDevice", "unsubscribe", str(handle))
        handle = self._subscribe(camera, size)
        if not handle:
            raise RobotError(
                "the robot gives no camera: too many programs use it. Close them, or restart the robot"
            )
        return handle

    def _claim(self) -> None:
        """Refuse to drive a robot that another program drives: its sign of life changes."""
        seen = self._driver()
        if seen and not seen.startswith(self._identity):
            time.sleep(2.5 * BEAT)
            if self._driver() != seen:
                raise RobotError(
                    "another program drives this robot, or an older RealNao of yours: close it, or wait"
                )

    def _driver(self) -> str:
        try:
            return str(self._call("ALMemory", "getData", DRIVER))
        except RobotError:
            return ""  # nobody has driven it since it was switched on

    def _beat(self) -> None:
        """Give a sign of life to other programs until the end."""
        for number in iter(int, 1):
            with suppress(RobotError):
                self._call(
                    "ALMemory", "insertData", DRIVER, f"{self._identity} {time.monotonic():.3f} {number}"
                )
            if self._leaving.wait(BEAT):
                return


def _parts(motion: Motion) -> Iterator[Motion]:
    """Divide a motion into the parts that are sent: first the distance, then the turn."""
    walks = int(np.ceil(abs(motion.distance) / PART - 1e-9))
    turns = int(np.ceil(abs(motion.turn) / TURN_PART - 1e-9))
    yield from (Motion(motion.distance / walks, 0.0) for _ in range(walks))
    yield from (Motion(0.0, motion.turn / turns) for _ in range(turns))


def _between(before: Pose, after: Pose) -> Motion:
    """Return the motion between two poses of the odometry, as distance ahead and turn."""
    step = before.inverse() @ after
    return Motion(float(np.hypot(step.x, step.y) * np.sign(step.x or 1.0)), step.theta)


def _camera_frame(model: NaoModel, camera: str) -> tuple[str, int, bool]:
    """Return the arguments of getTransform for a camera."""
    return f"Camera{model.check_camera(camera).capitalize()}", ROBOT_FRAME, USE_SENSORS
