"""The lesson's own functions, for its tests."""

from tests.lessons import every

OWN = every.own("04")
GEOMETRY = {name: OWN[name] for name in ("pixel_to_ground", "ground_to_measurement")}


def polar(pixels, view):
    """Return bearing and range of pixels, (N, 2)."""
    return OWN["ground_to_measurement"](OWN["pixel_to_ground"](pixels, view))
