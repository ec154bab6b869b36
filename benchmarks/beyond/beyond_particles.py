"""FastSLAM against lesson 07's filter on the same drives: errors, NEES, time, and first particles with descendants."""

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks import Result, Table, solution, write_json
from nao_course.geometry import FloatArray, wrap_angle
from nao_course.lessons.beyond.figures import START, lap
from nao_course.lessons.beyond.particles import FastSlam, ParticleBelief, run_fast_slam
from nao_course.lessons.beyond.recorded import PARTICLES
from nao_course.lessons.beyond.worlds import SENSOR
from nao_course.lessons.localization.consistency import median_band
from nao_course.metrics import band
from nao_course.sim.drives import NamedEkf, Step
from nao_course.slam import range_and_bearing

DRIVES, MOVES, COUNTS = range(30), 150, (10, 100, 300, 1000)
AFTER = (30, 60, 150)
TIMED = 15  # moves of one drive, by the lesson's own functions
Rows = dict[str, list[list[float]]]


class QuickFastSlam(FastSlam):
    """FastSLAM that updates a landmark in all particles at once instead of one after another."""

    def correct(self, number: int, seen: FloatArray) -> None:
        """Apply equations 12.3 and 12.4 to all particles at once."""
        m, P, R = self.means[:, number], self.covariances[:, number], SENSOR.covariances(seen[None])
        nu = seen - range_and_bearing(self.poses[:, None], m[:, None])[:, 0]
        nu[:, 0] = wrap_angle(nu[:, 0])
        H = _jacobians(m - self.poses[:, :2])
        shared = P @ H.transpose(0, 2, 1)
        S = H @ shared + R
        K = shared @ np.linalg.inv(S)
        self.means[:, number] = m + (K @ nu[..., None])[..., 0]
        self.covariances[:, number] = P - K @ H @ P
        squares = (nu[:, None] @ np.linalg.solve(S, nu[..., None])).ravel()
        self.logs -= 0.5 * (squares + np.log(np.linalg.det(2 * np.pi * S)))


def _jacobians(away: FloatArray) -> FloatArray:
    """Return the Jacobians (n, 2, 2) of bearing and range with respect to landmarks at offsets (n, 2)."""
    (dx, dy), q = away.T, np.square(away).sum(axis=1)
    r = np.sqrt(q)
    return np.array([[-dy / q, dx / q], [dx / r, dy / r]]).transpose(2, 0, 1)


def filtered(functions: Mapping[str, Any], steps: Sequence[Step]) -> tuple[list[float], list[float]]:
    """Return the errors (m) and the NEES of lesson 07's filter after each step of a drive."""
    slam = NamedEkf(START, *(functions[name] for name in ("predict", "update_landmarks", "add_landmark")))
    errors, nees = [], []
    for step in steps:
        if step.motion is not None:
            slam.move(step.control, step.control_covariance)
        slam.observe(step.numbers, step.measurements, step.covariances)
        belief = ParticleBelief(slam.state[:3], slam.covariance[:3, :3])
        errors.append(float(np.hypot(*belief.error(step.pose)[:2])))
        nees.append(belief.nees(step.pose))
    return errors, nees


def measure(ekf: Mapping[str, Any], own: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Run all on all drives."""
    drives = [lap(seed, MOVES) for seed in DRIVES]
    began = time.process_time()
    ends = [filtered(ekf, steps) for steps in drives]
    ms = 1e3 * (time.process_time() - began) / (len(drives) * MOVES)
    rows = [_row("EKF", None, [each[0] for each in ends], [each[1] for each in ends], None, ms)]
    for n in COUNTS:
        runs = [
            run_fast_slam(
                QuickFastSlam(
                    START,
                    own["update_particle_landmark"],
                    own["resample"],
                    n,
                    np.random.default_rng([seed, n]),
                ),
                steps,
            )
            for seed, steps in zip(DRIVES, drives, strict=True)
        ]
        left = [run.ancestors.tolist() for run in runs]
        ms = _timed(own, n, drives[0][: TIMED + 1])
        errors, nees = [run.errors.tolist() for run in runs], [run.nees.tolist() for run in runs]
        rows.append(_row(f"FastSLAM, {n} particles", n, errors, nees, left, ms))
    return rows


def _timed(own: Mapping[str, Any], n: int, steps: Sequence[Step]) -> float:
    """Return the milliseconds of a move by the lesson's own functions."""
    slam = FastSlam(START, own["update_particle_landmark"], own["resample"], n, np.random.default_rng(0))
    began = time.process_time()
    run_fast_slam(slam, steps)
    return 1e3 * (time.process_time() - began) / TIMED


def _row(
    name: str,
    particles: int | None,
    errors: list[list[float]],
    nees: list[list[float]],
    left: list[list[float]] | None,
    ms: float,
) -> dict[str, Any]:
    """Return medians and means over the drives, after the start and after each move."""
    return {
        "name": name,
        "particles": particles,
        "error": np.median(errors, axis=0).round(4).tolist(),
        "nees": np.median(nees, axis=0).round(2).tolist(),
        "nees_mean": np.mean(nees, axis=0).round(2).tolist(),
        "ancestors": None if left is None else np.median(left, axis=0).tolist(),
        "ms": round(ms, 1),
    }


def main() -> Result:
    """Run all of them, and write the results."""
    ekf, own = solution("07"), solution("12")
    low, high = median_band(3, len(DRIVES)).tolist()
    recorded = {"drives": len(DRIVES), "band": [round(low, 2), round(high, 2)], "rows": measure(ekf, own)}
    write_json(PARTICLES, recorded)
    shown = []
    for row in recorded["rows"]:  # type: ignore[attr-defined]
        for key, digits in (("error", 3), ("nees", 1), ("nees_mean", 1), ("ancestors", 0)):
            if row[key] is not None:
                shown.append((row["name"], key, *(f"{row[key][move]:.{digits}f}" for move in AFTER)))
        shown.append((row["name"], "ms a move", f"{row['ms']:.1f}", "", ""))
    table = Table(
        f"{len(DRIVES)} drives: median error m, median and mean NEES, first particles with descendants (median)",
        ("", "", *(f"after {move}" for move in AFTER)),
        tuple(shown),
    )
    mean = "{:.2f} to {:.2f}".format(*band(3, len(DRIVES)))
    note = f"a consistent median NEES is {low:.2f} to {high:.2f}, a consistent mean {mean}"
    return Result("beyond_particles", recorded, (table,), (note,))
