"""Pictures of lesson 03: the places that its first and last figure shows."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nao_course.geometry import Pose
from nao_course.sim import Field, SimulatedNao

# All corners are found from the first two; the third is the scene that goes through lessons 01 to 04.
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
