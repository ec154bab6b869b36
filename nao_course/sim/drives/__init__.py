"""Simulated drives without pictures: motions, true poses, measurements of known landmarks, and an EKF."""

from nao_course._internal.lazy_names import list_public
from nao_course.sim.drives.known_landmarks import (
    Drive,
    FieldOfView,
    Sigmas,
    Step,
    measure_in_view,
    repeat_drive,
    true_path,
)
from nao_course.sim.drives.named_ekf import (
    Belief,
    Function,
    Functions,
    NamedEkf,
    as_belief,
    checked_functions,
    landmark_blocks,
)

__all__ = [
    "Belief",
    "Drive",
    "FieldOfView",
    "Function",
    "Functions",
    "NamedEkf",
    "Sigmas",
    "Step",
    "as_belief",
    "checked_functions",
    "landmark_blocks",
    "measure_in_view",
    "repeat_drive",
    "true_path",
]
__dir__ = list_public(__name__)
