"""The lesson's own functions, for its tests."""

from functools import cache

from nao_course.exercises import load_definitions
from tests.paths import SOLUTIONS


@cache
def own():
    return load_definitions(SOLUTIONS / "04_distance.ipynb")


def geometry():
    """Return the two functions that most figures need."""
    return {name: own()[name] for name in ("pixel_to_ground", "ground_to_measurement")}
