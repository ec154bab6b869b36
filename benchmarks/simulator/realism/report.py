"""The benchmark's tables, figures and results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from benchmarks import BUILD, Result, Table
from benchmarks.pictures import paper_detector as paper
from benchmarks.simulator.realism.comparison import QUICK, compare, compare_by_set
from benchmarks.simulator.realism.detector import (
    annotation_reach,
    compare_detector,
    compare_detector_over_rooms,
)
from benchmarks.simulator.realism.measuring import GROUPS
from benchmarks.simulator.realism.scenes import RealScene, real_scenes, simulated_twin
from nao_course.sim.reality import Reality

CLOSE_LOOK = (0, 1, 6, 10, 16, 21, 29, 34, 46, 52, 65, 84)


def tables(rows: Mapping[str, Mapping[str, Any]], title: str = "") -> list[Table]:
    """Return a table for each group of statistics."""
    found = []
    for group, names in GROUPS.items():
        cells = tuple(_cells(name, rows[name]) for name in names if name in rows)
        if cells:
            columns = ("", "real", "10-90 %", "n", "simulated", "10-90 %", "n", "ratio")
            found.append(Table(f"{title}{group}", columns, cells))
    return found


def _cells(name: str, row: Mapping[str, Any]) -> tuple[object, ...]:
    cells: list[object] = [name]
    for side in (row["real"], row["simulated"]):
        if side:
            cells += [float(side["middle"]), f"{side['low']:.2f} .. {side['high']:.2f}", side["pictures"]]
        else:
            cells += ["-", "", ""]
    return (*cells, "-" if row["ratio"] is None else float(row["ratio"]))


def detector_table(values: Mapping[str, Any]) -> Table:
    """Return the table of the paper's detector on real and simulated scenes."""
    names = (
        "corners",
        "hits",
        "false",
        "cost",
        "rank correlation with Table A.1",
        "rank correlation of halves",
    )
    rows = [(name, *(values[side][name] for side in ("real", "simulated"))) for name in names]
    rows += [
        (f"true corners {stage}", *(values[s]["funnel"][stage] for s in ("real", "simulated")))
        for stage in paper.FUNNEL
    ]
    costs = [values[side]["costs"] for side in ("real", "simulated")]
    rows += [
        ("lowest of 27 costs", *(min(c) for c in costs)),
        ("highest of 27 costs", *(max(c) for c in costs)),
    ]
    rho = values["rank correlation"]
    title = f"the paper's detector, beta 120, gap 5, length 40; rank correlation of the 27 costs {rho:.2f}"
    return Table(title, ("", "real", "simulated"), tuple(rows))


def save_pairs(
    path: Path,
    scenes: Sequence[RealScene],
    reality_: Reality | None = None,
    columns: int = 4,
    zoom: float = 1.0,
) -> Path:
    """Write one figure with all pairs, real left and simulated right; never into the repository: they are not ours."""
    pairs = []
    for i, scene in enumerate(scenes):
        pair = np.hstack([scene.picture.pixels, simulated_twin(scene, reality_ or Reality(), i)[0]])
        if zoom != 1:
            pair = np.asarray(cv2.resize(pair, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_NEAREST))
        pair = np.pad(pair, ((0, 6), (0, 10), (0, 0)), constant_values=255)
        where = (4, pair.shape[0] - 12)
        pairs.append(cv2.putText(pair.copy(), scene.name[:-4], where, 0, 0.4, (255, 0, 0), 1, cv2.LINE_AA))
    pairs += [np.full_like(pairs[0], 255)] * (-len(pairs) % columns)
    grid = np.vstack([np.hstack(pairs[i : i + columns]) for i in range(0, len(pairs), columns)])
    path.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(path), grid[..., ::-1]):
        raise OSError(f"could not write {path}")
    return path


def quick(step: int = QUICK) -> Result:
    """Measure a few pictures, in some seconds."""
    rows = compare(step=step)
    detector = compare_detector(step=max(step // 2, 1))
    return Result("realism_quick", {}, (*tables(rows), detector_table(detector)))


def main() -> Result:
    """Measure all pictures, at both sizes, and both sets apart; draw the pairs."""
    rows, large = compare(), compare(large=True)
    by_set = compare_by_set()
    detector = {f"saturation floor {floor}": compare_detector(min_saturation=floor) for floor in (0.16, 0.0)}
    rooms = compare_detector_over_rooms()
    scenes = real_scenes()
    save_pairs(BUILD / "realism_all_pairs.png", scenes)
    save_pairs(BUILD / "realism_12_pairs.png", [scenes[i] for i in CLOSE_LOOK], columns=2, zoom=2.0)
    values = {
        "all 94 pictures": _brief(rows, spread=True),
        "8 pictures of 1280 x 960": _brief(large),
        **{name: _brief(each) for name, each in by_set.items()},
        "detector": detector,
        "detector over rooms": rooms,
        "annotations": annotation_reach(scenes),
    }
    shown = [*tables(rows), *tables(large, "1280 wide: ")]
    for name, each in detector.items():
        table = detector_table(each)
        shown.append(replace(table, title=f"{table.title}; {name}"))
    each = ", ".join(f"{rho:.2f}" for rho in rooms["of each set"])
    notes = (
        f"Rank correlation of the 27 mean costs over {rooms['rooms']} rooms: {rooms['rank correlation']:.2f}; "
        f"sets of four rooms: {each}.",
        "Pairs of pictures, real left: build/realism_all_pairs.png, build/realism_12_pairs.png (not ours to pass on).",
    )
    return Result("realism", values, tuple(shown), notes)


def _brief(rows: Mapping[str, Mapping[str, Any]], spread: bool = False) -> dict[str, dict[str, float | None]]:
    """Return the values of a comparison to keep: the medians and, if requested, the spread over pictures."""
    kept: dict[str, dict[str, float | None]] = {}
    for name, row in rows.items():
        sides = {side: row[side] for side in ("real", "simulated")}
        kept[name] = {side: values and values["middle"] for side, values in sides.items()}
        for side, values in sides.items():
            if spread and values:
                kept[name] |= {f"{side} 10 %": values["low"], f"{side} 90 %": values["high"]}
    return kept
