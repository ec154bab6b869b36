"""One camera against two: standard deviation of a distance by distance, resolution and head pitch."""

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks import Result, Table, solution, write_json
from nao_course.lessons.beyond.recorded import CAMERAS
from nao_course.lessons.beyond.two_cameras import (
    DISTANCES,
    SIZES,
    TILT,
    expected_sigmas,
    measure_again,
    pitch_for,
)

COUNT, SEED = 1000, 0
# Degrees from the central pitch
HEAD_COUNT, HEAD_DISTANCES, HEAD_OFF = (100, (1.0, 2.0, 5.0), np.arange(-8.0, 8.1, 1.0))
Function = Callable[..., Any]


def by_distance(intersect_rays: Function, pixel_to_ground: Function) -> list[dict[str, float]]:
    """Return the errors of both methods by resolution and distance, for a point in the centre of the common view."""
    rows = []
    for size in SIZES:
        for distance in DISTANCES:
            distances = measure_again(intersect_rays, pixel_to_ground, distance, size, count=COUNT, seed=SEED)
            one, both = distances.sigmas
            one_formula, both_formula = expected_sigmas(distance, size[0])
            values = {"one": one, "both": both, "one_formula": one_formula, "both_formula": both_formula}
            rows.append(
                {"width": size[0], "distance": distance}
                | {key: round(value, 4) for key, value in values.items()}
            )
    return rows


def by_pitch(intersect_rays: Function, pixel_to_ground: Function) -> list[dict[str, Any]]:
    """Return in how many pictures both cameras see the point, by the pitch of the head, at 640 x 480."""
    rows = []
    for distance in HEAD_DISTANCES:
        pitches = np.round(np.degrees(pitch_for(distance))) + HEAD_OFF
        found = [
            measure_again(
                intersect_rays,
                pixel_to_ground,
                distance,
                SIZES[1],
                pitch=float(np.radians(pitch)),
                count=HEAD_COUNT,
                seed=SEED,
            )
            for pitch in pitches
        ]
        rows.append(
            {
                "distance": distance,
                "pitches": pitches.tolist(),
                "seen": [round(each.seen, 3) for each in found],
            }
        )
    return rows


def main() -> Result:
    """Measure, and write what the lesson shows."""
    intersect_rays = solution("12")["intersect_rays"]
    pixel_to_ground = solution("04")["pixel_to_ground"]
    rows, heads = by_distance(intersect_rays, pixel_to_ground), by_pitch(intersect_rays, pixel_to_ground)
    recorded = {"count": COUNT, "tilt": round(float(np.degrees(TILT[0])), 2), "rows": rows, "heads": heads}
    write_json(CAMERAS, recorded)
    title = (
        f"{COUNT} measurements each (seed {SEED}), tilt 1.3 degrees in pitch, 0.8 in roll, 0.5 px: sigma, m"
    )
    shown = {f"{row['width']} px, {row['distance']:g} m": row for row in rows}
    where = Table(
        "pitch of the head, degrees, at which both cameras see the point in at least half of the measurements",
        ("distance m", "centre", "from", "to"),
        tuple(
            (head["distance"], float(np.degrees(pitch_for(head["distance"]))), *_half(head)) for head in heads
        ),
    )
    columns = ("one", "both", "one_formula", "both_formula")
    return Result("beyond_cameras", recorded, (Table.of(title, shown, *columns, shown=".3f"), where))


def _half(head: dict[str, Any]) -> tuple[str, str]:
    """Return the least and the largest pitch at which half of the pictures show the point."""
    seen = [pitch for pitch, part in zip(head["pitches"], head["seen"], strict=True) if part >= 0.5]
    return (f"{min(seen):.0f}", f"{max(seen):.0f}")
