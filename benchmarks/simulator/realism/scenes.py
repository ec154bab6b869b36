"""The real pictures with their geometry, and the simulator's twin of each."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, get_args

import numpy as np
from scipy.optimize import least_squares

from benchmarks import BUILD
from benchmarks.simulator import reality
from benchmarks.simulator.realism.geometry import FIELD, Geometry, Lines, Pixels
from benchmarks.simulator.realism.profiles import Picture, line_profiles, thinned
from nao_course.datasets import PictureSet, RealPicture, read_pictures
from nao_course.geometry import FloatArray, Pose
from nao_course.sim.camera import CameraView
from nao_course.sim.reality import Reality
from nao_course.sim.render import PictureTruth, render


@dataclass(frozen=True)
class RealScene:
    """A real picture with its fitted geometry."""

    picture: RealPicture
    set_name: str
    view: CameraView
    pose: Pose

    @property
    def name(self) -> str:
        """The picture's file name."""
        return self.picture.name

    @property
    def corners(self) -> FloatArray:
        """The L and T points as they were marked (K, 2)."""
        return np.array([(p.u, p.v) for p in self.picture.points if p.kind in "LT"], dtype=float).reshape(
            -1, 2
        )

    def geometry(self, size: tuple[int, int] | None = None) -> Geometry:
        """Return the geometry, for a picture of another size if one is given."""
        return Geometry(self.view.at_size(size) if size else self.view, self.pose)


# What a picture's geometry may deviate from its set's: pitch, roll, heading (rad) and x, y (m).
_PRIOR = np.array([np.radians(1.3), np.radians(1.0), np.radians(2.5), 0.06, 0.06])
_CACHE = BUILD / "realism_geometry.json"


def real_scenes() -> tuple[RealScene, ...]:
    """Return all 94 real pictures with their geometry, which is cached because fitting takes half a minute."""
    scenes = []
    kept = json.loads(_CACHE.read_text()) if _CACHE.is_file() else {}
    for name in get_args(PictureSet):
        pictures = read_pictures(name)
        if set(kept.get(name, {})) != {picture.name for picture in pictures}:
            kept[name] = {s.name: _as_json(s) for s in _fit_geometry(name, pictures)}
            _CACHE.parent.mkdir(exist_ok=True)
            _CACHE.write_text(json.dumps(kept))
        for picture in pictures:
            values = kept[name][picture.name]
            view = CameraView(**{**values["view"], "size": tuple(values["view"]["size"])})
            scenes.append(RealScene(picture, name, view, Pose(*values["pose"])))
    return tuple(scenes)


def _as_json(scene: RealScene) -> dict[str, Any]:
    return {"view": asdict(scene.view), "pose": scene.pose.as_array().tolist()}


def _fit_geometry(name: str, pictures: Sequence[RealPicture]) -> list[RealScene]:
    """Fit a set's camera to the marked points, then move every picture's pose onto its lines."""
    moved = reality.corrected_walk(pictures) if name == "straightwalk" else tuple(pictures)
    fit = reality.fit_set(moved, reality.Freedom(position_sd=0.05))
    known = {item.picture.name: c for item, c in zip(fit.matched, fit.corrections, strict=True)}
    mean = np.median(fit.corrections, axis=0)
    scenes = []
    for original, picture in zip(pictures, moved, strict=True):
        correction = align(picture, fit.values, known.get(picture.name, mean), mean)
        view, pose = reality.fitted_view(picture, fit.values, correction)
        scenes.append(RealScene(original, name, view, pose))
    return scenes


def align(picture: RealPicture, values: FloatArray, start: FloatArray, mean: FloatArray) -> FloatArray:
    """Move a picture's pitch, roll, heading and position until the field's lines lie on the white ones.

    Parameters
    ----------
    picture : RealPicture
        The picture.
    values : ndarray, shape (5,)
        Of its set (`reality.SET_VALUES`).
    start, mean : ndarray, shape (5,)
        Where to begin, and the set's middle: pitch, roll, heading (rad), x, y (m).

    Returns
    -------
    ndarray, shape (5,)
        The corrections.
    """
    correction = np.clip(start, mean - 2 * _PRIOR, mean + 2 * _PRIOR)
    bounds = (mean - 3.5 * _PRIOR, mean + 3.5 * _PRIOR)
    seen = Picture(picture.pixels)
    for search in (0.0, 5.0, 3.0, 2.0):  # first by the marked points alone
        matched = (
            reality.match(picture, values, correction, 12.0 if search else 40.0) if picture.points else None
        )
        found = _found_lines(seen, *reality.fitted_view(picture, values, correction), search)
        weight = np.sqrt(min(1.0, 60 / max(len(found.lines.point), 1)))

        def residual(
            state: FloatArray,
            matched: reality.Matched | None = matched,
            found: _Found = found,
            weight: float = float(weight),
        ) -> FloatArray:
            view, pose = reality.fitted_view(picture, values, state)
            off = view.project(found.lines.point, pose) - found.pixel
            parts = [(off * found.lines.normal).sum(axis=1) / 0.5 * weight, (state - mean) / _PRIOR]
            if matched is not None:
                marked = view.project(matched.landmarks[matched.used], pose) - matched.pixels[matched.used]
                parts.append(marked.ravel() / 2.0)
            return np.nan_to_num(np.concatenate(parts), nan=20.0)

        moved = least_squares(residual, correction, bounds=bounds, loss="soft_l1", x_scale=_PRIOR)
        correction = np.asarray(moved.x)
    return correction


@dataclass(frozen=True)
class _Found:
    """Line points, and the pixels (N, 2) at which the picture shows the lines' middles."""

    lines: Lines
    pixel: FloatArray


def _found_lines(seen: Picture, view: CameraView, pose: Pose, search: float) -> _Found:
    """Find lines within `search` px of where they should be; none for 0."""
    lines = Geometry(view, pose).lines
    lines = lines.chosen(lines.clear & (lines.distance < 6) & (search > 0))
    lines = lines.chosen(thinned(len(lines.pixel), 400))
    if not len(lines.pixel):
        return _Found(lines, np.empty((0, 2)))
    profiles = line_profiles(seen, lines, 1.0, search)
    good = profiles.good & (profiles.peak - profiles.base > 25)
    pixel = view.project(lines.point, pose) + np.nan_to_num(profiles.centre)[:, None] * lines.normal
    return _Found(lines.chosen(good), pixel[good])


ROOMS = 4  # the twins are spread over so many of the simulator's rooms


def simulated_twin(
    scene: RealScene, reality_: Reality, seed: int, size: tuple[int, int] | None = None
) -> tuple[Pixels, PictureTruth]:
    """Render the simulator's picture from a real picture's view and pose.

    Parameters
    ----------
    scene : RealScene
        The real picture's geometry.
    reality_ : Reality
        How real the simulator's pictures look.
    seed : int
        Of everything random in this picture; it also chooses one of four rooms.
    size : (int, int), optional
        Width and height in pixels, another than the real picture's.

    Returns
    -------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    truth : PictureTruth
        What it shows.
    """
    view = scene.view.at_size(size) if size else scene.view
    room = replace(reality_, seed=reality_.seed + seed % ROOMS)
    return render(FIELD, scene.pose, view, room, np.random.default_rng(seed))
