"""The simulator: the field, the NAO with its head and cameras, and rendered pictures."""

from nao_course._internal.lazy_names import list_public
from nao_course.sim.camera import NAO_V4, NAO_V6, CameraView, NaoModel
from nao_course.sim.drives import repeat_drive
from nao_course.sim.field import Field, Landmark
from nao_course.sim.fields import DIMENSIONS, FieldDimensions
from nao_course.sim.nao import OdometryNoise, Picture, SensorNoise, SimulatedNao, TorsoTilt, Truth
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
    "FieldDimensions",
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
__dir__ = list_public(__name__)
