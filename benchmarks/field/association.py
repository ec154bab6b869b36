"""Nearest neighbour and joint compatibility with gates of 1, 3 and 10 sigma over 30 drives: what lesson 11 shows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks import Result, Table, solution, write_json
from nao_course.field_slam.association import associate_jointly
from nao_course.lessons.slam_on_the_field.associating import POSITION_SIGMA, Associate
from nao_course.lessons.slam_on_the_field.gates import (
    FATES,
    GATES,
    JOINTLY,
    MOVES,
    NEAREST,
    RECORDED,
    shares_of,
    watch,
)
from nao_course.lessons.slam_on_the_field.worlds import KINDS, association_problem, drawn_drive

DRIVES, FIRST_SEED = 30, 400  # nothing was tuned on these
LOOKS, DOUBTS = 100, (2, 5, 10)  # single looks at a whole map, with a heading in doubt by so many degrees


def record(
    slam_class: Callable[..., Any], drives: int = DRIVES, gates: tuple[float, ...] = GATES
) -> list[dict[str, Any]]:
    """Record the shares of all measurements by their fate, and how each drive ends: m, NEES, landmarks on the map."""
    given = [drawn_drive(seed, MOVES) for seed in range(FIRST_SEED, FIRST_SEED + drives)]
    rows = []
    for way, match in ((NEAREST, None), (JOINTLY, associate_jointly)):
        for gate in gates:
            watched = [watch(slam_class, drive, gate, match) for drive in given]
            rows.append(
                {
                    "way": way,
                    "gate": gate,
                    "measurements": sum(sum(each.fates.values()) for each in watched),
                    "shares": {fate: round(share, 4) for fate, share in shares_of(watched).items()},
                    "off": [round(each.outcome.off, 4) for each in watched],
                    "nees": [round(each.outcome.nees, 2) for each in watched],
                    "landmarks": [len(each.outcome.estimate.kinds) for each in watched],
                }
            )
    return rows


def looks(associate: Associate, gate: float) -> dict[str, dict[str, float]]:
    """Return the results of nearest neighbour on single pictures, in percent, by the heading's uncertainty."""
    found = {}
    for doubt in DOUBTS:
        right = left_out = number = 0
        for seed in range(LOOKS):
            look = association_problem(seed, POSITION_SIGMA, float(np.radians(doubt)))
            indices = associate(
                look.state, look.covariance, list(KINDS), look.observation, look.observation.covariance, gate
            )
            right += look.right(indices)
            left_out += int(np.count_nonzero(np.asarray(indices) < 0))
            number += len(look.origins)
        found[f"{doubt} degrees"] = {"right": 100 * right / number, "left out": 100 * left_out / number}
    return found


def main() -> Result:
    """Drive with both methods of association and every gate, and write what the lesson's figure shows."""
    own = solution("11")
    rows = record(own["EkfSlam"])
    write_json(RECORDED, rows)
    found = {f"{row['way']}, gate {row['gate']:g}": summary(row) for row in rows}
    seen = {f"gate {gate:g}": looks(own["associate"], gate) for gate in GATES}
    title = f"{DRIVES} drives of {MOVES} moves, {rows[0]['measurements']} measurements"
    each = {f"{gate}, {doubt}": of for gate, doubts in seen.items() for doubt, of in doubts.items()}
    looked = Table.of(f"{LOOKS} looks at a whole map, nearest neighbour, %", each, shown=".1f")
    return Result(
        "association", {"drives": found, "looks": seen}, (Table.of(title, found, shown=".1f"), looked)
    )


def summary(row: dict[str, Any]) -> dict[str, float]:
    """Return shares in percent and errors in cm."""
    off = 100 * np.array(row["off"])
    return {f"{fate} %": 100 * row["shares"][fate] for fate in FATES} | {
        "landmarks": float(np.mean(row["landmarks"])),
        "off cm": float(np.median(off)),
        "95 %": float(np.quantile(off, 0.95)),
        "worst": float(off.max()),
        "> 10 cm": int((off > 10).sum()),
        "> 50 cm": int((off > 50).sum()),
        "NEES": float(np.median(row["nees"])),
    }
