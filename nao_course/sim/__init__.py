"""The simulated world: the field, the robot's head and cameras, its pictures, and the robot itself."""

from nao_course.sim.camera import NAO_V4, NAO_V6, CameraView, NaoModel
from nao_course.sim.field import DIMENSIONS, Field, Landmark
from nao_course.sim.nao import (
    OdometryNoise,
    Picture,
    SensorNoise,
    SimulatedNao,
    TorsoTilt,
    Truth,
    repeat_drive,
)
from nao_course.sim.reality import Reality
from nao_course.sim.render import LABELS, PictureTruth, VisibleLandmark, render, visible_landmarks
from nao_course.sim.scenes import Scene, standard_scenes

__all__ = [
    "DIMENSIONS",
    "LABELS",
    "NAO_V4",
    "NAO_V6",
    "CameraView",
    "Field",
    "Landmark",
    "NaoModel",
    "OdometryNoise",
    "Picture",
    "PictureTruth",
    "Reality",
    "Scene",
    "SensorNoise",
    "SimulatedNao",
    "TorsoTilt",
    "Truth",
    "VisibleLandmark",
    "render",
    "repeat_drive",
    "standard_scenes",
    "visible_landmarks",
]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
