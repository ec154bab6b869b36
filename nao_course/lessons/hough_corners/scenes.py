"""Pictures of lesson 03: the places that its first and last figure shows."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nao_course.geometry import Pose
from nao_course.sim import Field, SimulatedNao

# By the paper's method: all corners and one of them twice; all and no more; none. The third is lesson 01's scene.
PLACES = {
    "near the middle line": Pose(1.77, 0.57, -0.91),
    "from the left": Pose(1.2, -0.38, -0.62),
    "the scene of lesson 01": Pose(0.6, 0.5, -0.25),
}


def three_places() -> dict[str, npt.NDArray[np.uint8]]:
    """Take one picture from each place, by a title that says where: the same at every call."""
    return {
        title: SimulatedNao(Field(2012), pose, rng=41).take_picture("bottom").pixels
        for title, pose in PLACES.items()
    }
