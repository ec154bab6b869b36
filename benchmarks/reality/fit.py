"""Does the geometry hold on a real robot's pictures? Every hand-marked point is predicted from the others.

The whole field of the 2012 rules is laid over real pictures. Fitted once per set of pictures: camera
height, both fields of view, lens term and mean pitch offset. Fitted per picture: small corrections of
pitch, roll and heading. Each marked point is then predicted with its own picture left out of the
set's fit, and itself left out of its picture's; the error is in pixels at 320 x 240.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, get_args

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from scipy.optimize import least_squares, linear_sum_assignment

from benchmarks import BUILD, Result, Table
from nao_course.datasets import PictureSet, PointKind, RealPicture, read_pictures
from nao_course.geometry import FloatArray, Pose
from nao_course.sim.camera import NAO_V4, CameraView
from nao_course.sim.field import Field

FIELD = Field(2012, half=False)
SETS: tuple[PictureSet, ...] = get_args(PictureSet)
KINDS: tuple[PointKind, ...] = get_args(PointKind)
FOLDS = 8  # groups of pictures; a picture is predicted by set values fitted to the other groups
FEWEST_POINTS = 4  # a picture with fewer does not determine three angles and leave something to predict

# What is fitted once per set, where the fit begins (the maker's optics, the walking stance; the robots' heads
# hang about 6 deg lower than their joints say), and bounds that keep a fit from leaving the possible.
SET_VALUES = ("height_m", "hfov", "vfov", "k1", "pitch_offset")
START = np.array([0.46, NAO_V4.hfov, NAO_V4.vfov, 0.0, np.radians(6.0)])
LOWEST = np.array([0.30, np.radians(45), np.radians(30), -0.25, np.radians(-15)])
HIGHEST = np.array([0.60, np.radians(75), np.radians(60), 0.25, np.radians(15)])
MOST_STEPS = 40  # of a fit; a good one needs about ten, and one that goes nowhere should not take minutes
HELD = 1e3  # pixels per radian: the weight of what a fit must keep
LARGEST_CORRECTION = np.radians(20)  # of a picture's angles; a position's prior is in metres and stricter

GATES = (
    80.0,
    40.0,
    20.0,
    20.0,
)  # pixels; a point farther from every landmark of its kind is left out of a fit
NOISE = 1.5  # pixels; residuals well beyond it pull no harder than one at it (soft L1)
DISTANCES = (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0)  # metres, edges of the table's rows

# The walk's poses run from -2.8 m in steps of 0.2 m to 3.0 m: 30 pictures, though 31 stops lie between the
# goal lines. The pictures show that the stop at -1.6 m is the one without a picture (docs/real_data.md).
WALK_BEFORE_THE_GAP = 7  # pictures, which were taken one stop farther back than their poses say
WALK_STOP = 0.2  # metres


@dataclass(frozen=True)
class Matched:
    """A picture with the landmark of each of its N points.

    Parameters
    ----------
    picture : RealPicture
        The picture.
    pixels : ndarray, shape (N, 2)
        The points as they were marked.
    landmarks : ndarray, shape (N, 3)
        Of the field, metres.
    used : ndarray of bool, shape (N,)
        Whether the point is near enough to its landmark to take part in a fit.
    """

    picture: RealPicture
    pixels: FloatArray
    landmarks: FloatArray
    used: npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Freedom:
    """Variants of a fit, to see what its figures hang on.

    Parameters
    ----------
    position_sd : float
        How far a robot may stand from where it was set by hand, metres; 0: not at all.
    square : bool
        Tie the vertical field of view to the horizontal one by square pixels.
    """

    position_sd: float = 0.0
    square: bool = False


@dataclass(frozen=True)
class SetFit:
    """A set of P pictures with all that was fitted to them.

    Parameters
    ----------
    matched : tuple of Matched
        The pictures.
    values : ndarray, shape (5,)
        Height (m), hfov, vfov (rad), k1 and pitch offset (rad): `SET_VALUES`.
    corrections : ndarray, shape (P, 3) or (P, 5)
        Per picture pitch, roll and heading (rad); and x, y (m) where the robot's position is free.
    freedom : Freedom
        What was free.
    """

    matched: tuple[Matched, ...]
    values: FloatArray
    corrections: FloatArray
    freedom: Freedom = Freedom()


@dataclass(frozen=True)
class Prediction:
    """One marked point, and where the geometry puts it with the point itself left out."""

    picture: str
    kind: PointKind
    landmark: tuple[float, float, float]
    distance: float
    marked: tuple[float, float]
    predicted: tuple[float, float]

    @property
    def error(self) -> float:
        """Distance between the two in pixels."""
        return float(np.hypot(*np.subtract(self.marked, self.predicted)))


# --- the geometry under test ---


def fitted_view(picture: RealPicture, values: FloatArray, correction: FloatArray) -> tuple[CameraView, Pose]:
    """Return the camera's view and the robot's pose that fitted values stand for."""
    specified = _specified_view(picture.head_yaw, picture.head_pitch)
    height, hfov, vfov, k1, offset = values.tolist()
    pitch, roll, heading, *position = correction.tolist()
    view = replace(
        specified,
        height=height,
        hfov=hfov,
        vfov=vfov,
        k1=k1,
        pitch=specified.pitch + offset + pitch,
        roll=roll,
    )
    x, y = position or (0.0, 0.0)
    return view, Pose(picture.pose.x + x, picture.pose.y + y, picture.pose.theta + heading)


@lru_cache(maxsize=1024)
def _specified_view(head_yaw: float, head_pitch: float) -> CameraView:
    """Return the lower camera's view as the maker specifies it; a fit asks for the same few very often."""
    return NAO_V4.view("bottom", head_yaw, head_pitch)


def predict(
    picture: RealPicture, values: FloatArray, correction: FloatArray, points: FloatArray
) -> FloatArray:
    """Pixels (N, 2) of points (N, 3) of the field."""
    view, pose = fitted_view(picture, values, correction)
    return view.project(points, pose)


def landmarks_of(kind: PointKind) -> FloatArray:
    """Landmarks (N, 3) of the whole field that a point of this kind may be, in metres."""
    if kind == "post_top":
        return FIELD.bars.reshape(-1, 3)
    shape = "post" if kind == "post_foot" else kind
    return np.array([(mark.x, mark.y, 0.0) for mark in FIELD.landmarks if mark.shape == shape])


# --- which landmark a point is ---


def match(picture: RealPicture, values: FloatArray, correction: FloatArray, gate: float) -> Matched:
    """Give each point the landmark of its kind whose projection is nearest, no landmark twice.

    Distances beyond the gate (pixels) all count as equally far, and such a point takes no part in fits.
    """
    pixels = np.array([(point.u, point.v) for point in picture.points])
    kinds = np.array([point.kind for point in picture.points])
    landmarks = np.empty((len(pixels), 3))
    used = np.zeros(len(pixels), dtype=bool)
    for kind in dict.fromkeys(kinds.tolist()):
        rows = np.flatnonzero(kinds == kind)
        known = landmarks_of(kind)
        apart = np.linalg.norm(pixels[rows, None] - predict(picture, values, correction, known), axis=2)
        apart = np.nan_to_num(apart, nan=1e6)
        # Beyond the gate a small slope keeps the nearest one first without outweighing a match within it.
        first, second = linear_sum_assignment(np.minimum(apart, gate + 1e-6 * apart))
        landmarks[rows[first]] = known[second]
        used[rows[first]] = apart[first, second] < gate
    return Matched(picture, pixels, landmarks, used)


# --- fits ---


def fit_set(pictures: Sequence[RealPicture], freedom: Freedom = Freedom()) -> SetFit:
    """Match and fit in turn, from the specified camera and the poses as given.

    Parameters
    ----------
    pictures : sequence of RealPicture
        Those with fewer than four points are left aside.
    freedom : Freedom
        A variant of the fit.

    Returns
    -------
    SetFit
        The pictures, their matches and what was fitted.
    """
    chosen = [picture for picture in pictures if len(picture.points) >= FEWEST_POINTS]
    fit = SetFit((), START, np.zeros((len(chosen), 5 if freedom.position_sd else 3)), freedom)
    for gate in GATES:
        matched = tuple(match(p, fit.values, c, gate) for p, c in zip(chosen, fit.corrections, strict=True))
        fit = _refit(replace(fit, matched=matched))
    return fit


def _refit(fit: SetFit) -> SetFit:
    """Fit a set's values and every picture's corrections together, matches fixed."""
    pictures, free = fit.corrections.shape
    ends = np.cumsum([0] + [2 * int(item.used.sum()) + free - 3 for item in fit.matched])

    def split(state: FloatArray) -> tuple[FloatArray, FloatArray]:
        return state[:5], state[5:].reshape(pictures, free)

    def residual(state: FloatArray) -> FloatArray:
        values, corrections = split(state)
        rows = [_residual(m, values, c, fit.freedom) for m, c in zip(fit.matched, corrections, strict=True)]
        return np.concatenate([*rows, _constraints(values, corrections, fit.freedom)])

    def jacobian(state: FloatArray) -> FloatArray:
        # A picture's corrections move only its own rows: one difference serves all pictures at once.
        base, step = residual(state), 1e-6
        full = np.zeros((len(base), len(state)))
        for j in range(5):
            full[:, j] = (residual(state + step * (np.arange(len(state)) == j)) - base) / step
        for j in range(free):
            each = np.arange(5 + j, len(state), free)
            column = (residual(state + step * np.isin(np.arange(len(state)), each)) - base) / step
            for i, k in enumerate(each):
                full[ends[i] : ends[i + 1], k] = column[ends[i] : ends[i + 1]]
        full[ends[-1], 5::free] = HELD / pictures
        return full

    start = np.concatenate([fit.values, fit.corrections.ravel()])
    room = np.full(fit.corrections.size, LARGEST_CORRECTION)
    bounds = (np.concatenate([LOWEST, -room]), np.concatenate([HIGHEST, room]))
    found = least_squares(
        residual,
        start,
        jacobian,
        bounds,
        loss="soft_l1",
        f_scale=NOISE,
        x_scale="jac",
        xtol=1e-6,
        ftol=1e-6,
        max_nfev=MOST_STEPS,
    )
    values, corrections = split(found.x)
    return replace(fit, values=values, corrections=corrections)


def _residual(item: Matched, values: FloatArray, correction: FloatArray, freedom: Freedom) -> FloatArray:
    """Return what a fit makes small: pixels between predicted and marked points; the position's prior."""
    off = predict(item.picture, values, correction, item.landmarks[item.used]) - item.pixels[item.used]
    off[np.isnan(off)] = 1e3  # a landmark that swings behind the camera during a fit: far off, but finite
    return np.concatenate([off.ravel(), correction[3:] / (freedom.position_sd or 1.0) * NOISE])


def _constraints(values: FloatArray, corrections: FloatArray, freedom: Freedom) -> FloatArray:
    """Return what a fit holds at zero: the pitch corrections' mean (it belongs to the offset), odd pixels."""
    square = 2 * np.arctan(np.tan(values[1] / 2) * 240 / 320)
    return HELD * np.array([corrections[:, 0].mean(), values[2] - square if freedom.square else 0.0])


def _refit_picture(item: Matched, values: FloatArray, correction: FloatArray, freedom: Freedom) -> FloatArray:
    """Fit one picture's corrections, the set's values fixed."""

    def residual(state: FloatArray) -> FloatArray:
        return _residual(item, values, state, freedom)

    return np.asarray(least_squares(residual, correction, loss="soft_l1", f_scale=NOISE).x, dtype=float)


# --- predictions ---


def leave_one_out(fit: SetFit, strict: bool = True) -> tuple[Prediction, ...]:
    """Predict every marked point of every picture from the others.

    Parameters
    ----------
    fit : SetFit
        A set.
    strict : bool
        Fit the set's values without the point's picture (and others: an eighth of the pictures are left
        out at a time); otherwise they are those fitted to all pictures, this point among hundreds.

    Returns
    -------
    tuple of Prediction
        One for each point, none left out.
    """
    values = [fit.values] * len(fit.matched)
    for fold in range(FOLDS if strict else 0):
        rest = [i for i in range(len(fit.matched)) if i % FOLDS != fold]
        others = SetFit(tuple(fit.matched[i] for i in rest), fit.values, fit.corrections[rest], fit.freedom)
        values[fold::FOLDS] = [_refit(others).values] * len(values[fold::FOLDS])
    return tuple(
        prediction
        for item, set_values, correction in zip(fit.matched, values, fit.corrections, strict=True)
        for prediction in _left_out_points(item, set_values, correction, fit.freedom)
    )


def _left_out_points(
    item: Matched, values: FloatArray, correction: FloatArray, freedom: Freedom
) -> Iterable[Prediction]:
    """Predict each of a picture's points with the picture's corrections fitted to the others."""
    for i, (point, landmark) in enumerate(zip(item.picture.points, item.landmarks, strict=True)):
        rest = replace(item, used=item.used & (np.arange(len(item.used)) != i))
        refitted = _refit_picture(rest, values, correction, freedom)
        ((u, v),) = predict(item.picture, values, refitted, landmark[None]).tolist()
        x, y, z = landmark.tolist()
        distance = float(np.hypot(x - item.picture.pose.x, y - item.picture.pose.y))
        yield Prediction(item.picture.name, point.kind, (x, y, z), distance, (point.u, point.v), (u, v))


def fit_residuals(fit: SetFit) -> dict[PointKind, FloatArray]:
    """Marked minus fitted pixels (N, 2) of each kind, nothing left out: what is left of a bias."""
    found: dict[PointKind, list[FloatArray]] = {kind: [] for kind in KINDS}
    for item, correction in zip(fit.matched, fit.corrections, strict=True):
        off = item.pixels - predict(item.picture, fit.values, correction, item.landmarks)
        for point, residual in zip(item.picture.points, off, strict=True):
            found[point.kind].append(residual)
    return {kind: np.array(rows) for kind, rows in found.items() if rows}


# --- the sets ---


def corrected_walk(pictures: Sequence[RealPicture]) -> tuple[RealPicture, ...]:
    """Return the walk with its first seven pictures one stop farther back, where they were taken."""
    back = Pose(-WALK_STOP, 0.0, 0.0)
    return tuple(
        replace(picture, pose=Pose(picture.pose.x + back.x, picture.pose.y, picture.pose.theta))
        if i < WALK_BEFORE_THE_GAP
        else picture
        for i, picture in enumerate(pictures)
    )


def errors_of(predictions: Iterable[Prediction]) -> FloatArray:
    """Errors (N,) in pixels; a point that is predicted behind the camera is infinitely wrong."""
    errors = np.array([prediction.error for prediction in predictions])
    return np.where(np.isnan(errors), np.inf, errors)


def summary(errors: npt.ArrayLike) -> dict[str, float]:
    """Median, 90 %, 95 % and largest of errors, in their unit."""
    e = np.asarray(errors, dtype=float)
    median, ninety, ninety_five = np.quantile(e, [0.5, 0.9, 0.95]).tolist()
    return {"median": median, "90%": ninety, "95%": ninety_five, "max": float(e.max())}


# --- the benchmark ---


@dataclass(frozen=True)
class Case:
    """One way of fitting one set, with its predictions."""

    title: str
    fit: SetFit
    predictions: tuple[Prediction, ...]


def run_case(title: str, pictures: Sequence[RealPicture], freedom: Freedom = Freedom()) -> Case:
    """Fit a set and predict its points."""
    fit = fit_set(pictures, freedom)
    return Case(title, fit, leave_one_out(fit))


def main() -> Result:
    """Run every case, draw the figure, and return tables and values.

    Raises
    ------
    FileNotFoundError
        If the recorded data is not there; it says what to do.
    """
    scenes, given = read_pictures("scenes"), read_pictures("straightwalk")
    walk = corrected_walk(given)
    judged = (run_case("scenes", scenes), run_case("straightwalk", walk))
    as_given = run_case("straightwalk, poses as given", given)
    variants = (
        run_case("scenes, square pixels", scenes, Freedom(square=True)),
        run_case("straightwalk, square pixels", walk, Freedom(square=True)),
        run_case("scenes, positions free (5 cm)", scenes, Freedom(position_sd=0.05)),
        run_case("straightwalk, positions free (5 cm)", walk, Freedom(position_sd=0.05)),
    )
    cases = (*judged, as_given, *variants)
    both = tuple(p for case in judged for p in case.predictions)
    both_as_given = (*judged[0].predictions, *as_given.predictions)
    figure = draw_pictures({name: case.fit for name, case in zip(SETS, judged, strict=True)}, judged)
    tables = (
        _fit_table(cases),
        _error_table(
            [
                *((c.title, c.predictions) for c in cases),
                ("both", both),
                ("both, poses as given", both_as_given),
            ]
        ),
        _kind_table(judged),
        _distance_table(judged),
        _correction_table(judged),
    )
    values: dict[str, Any] = {
        case.title: {
            "pictures": len(case.fit.matched),
            "points": len(case.predictions),
            **dict(zip(SET_VALUES, _readable(case.fit.values), strict=True)),
            "error_px": summary(errors_of(case.predictions)),
            "sd_deg": dict(zip(("pitch", "roll", "heading"), _spread(case.fit), strict=True)),
        }
        for case in cases
    }
    values["both"] = {"points": len(both), "error_px": summary(errors_of(both))}
    values["both, poses as given"] = {
        "points": len(both_as_given),
        "error_px": summary(errors_of(both_as_given)),
    }
    notes = (
        "Each point is predicted from its picture's other points, with set values fitted to other pictures.",
        "No point is left out of the errors. straightwalk: the first seven pictures stand one stop (0.2 m)",
        "farther back than their poses say (docs/real_data.md); all other poses as given.",
        f"Figure: {figure.relative_to(BUILD.parent).as_posix()} (real pictures: not ours to pass on)",
    )
    return Result("reality", values, tables, notes)


def _readable(values: FloatArray) -> list[float]:
    """Return a set's values with angles in degrees."""
    height, hfov, vfov, k1, offset = values.tolist()
    return [height, *np.degrees([hfov, vfov]).tolist(), k1, float(np.degrees(offset))]


def _spread(fit: SetFit) -> list[float]:
    """Return the standard deviations of pitch, roll and heading corrections over pictures, degrees."""
    found: list[float] = np.degrees(fit.corrections[:, :3].std(axis=0, ddof=1)).tolist()
    return found


def _spread_within_places(fit: SetFit) -> list[float]:
    """Return the same about the mean of each position at which more than one picture was taken."""
    places: dict[tuple[float, float], list[FloatArray]] = {}
    for item, correction in zip(fit.matched, fit.corrections, strict=True):
        places.setdefault((item.picture.pose.x, item.picture.pose.y), []).append(correction[:3])
    groups = [np.array(group) for group in places.values() if len(group) > 1]
    if not groups:
        return []
    off = np.concatenate([group - group.mean(axis=0) for group in groups])
    freedom = len(off) - len(groups)
    found: list[float] = np.degrees(np.sqrt((off**2).sum(axis=0) / freedom)).tolist()
    return found


def _fit_table(cases: Iterable[Case]) -> Table:
    rows = []
    for case in cases:
        height, hfov, vfov, k1, offset = _readable(case.fit.values)
        fitted = (f"{height:.3f}", f"{hfov:.1f}", f"{vfov:.1f}", f"{k1:+.3f}", f"{offset:+.1f}")
        rows.append((case.title, len(case.fit.matched), *fitted))
    heads = ("fitted once per set", "pictures", "height m", "hfov deg", "vfov deg", "k1", "pitch off deg")
    return Table("Camera", heads, tuple(rows))


def _error_table(named: Iterable[tuple[str, Sequence[Prediction]]]) -> Table:
    rows = tuple((name, len(found), *summary(errors_of(found)).values()) for name, found in named)
    return Table(
        "Error of left-out points, pixels at 320 x 240",
        ("set", "points", "median", "90%", "95%", "max"),
        rows,
    )


def _kind_table(cases: Iterable[Case]) -> Table:
    rows = []
    for case in cases:
        residuals = fit_residuals(case.fit)
        for kind, off in residuals.items():
            errors = summary(errors_of(p for p in case.predictions if p.kind == kind))
            bias = (f"{value:+.2f}" for value in np.median(off, axis=0))
            rows.append((f"{case.title}: {kind}", len(off), errors["median"], errors["90%"], *bias))
    heads = ("kind", "points", "median", "90%", "bias right", "bias down")
    return Table("By kind (bias: median of marked minus fitted)", heads, tuple(rows))


def _distance_table(cases: Iterable[Case]) -> Table:
    rows = []
    for case in cases:
        for near, far in pairwise(DISTANCES):
            found = [p for p in case.predictions if near <= p.distance < far]
            if found:
                errors = summary(errors_of(found))
                rows.append(
                    (f"{case.title}: {near:.0f}-{far:.0f} m", len(found), errors["median"], errors["90%"])
                )
    return Table("By distance from the robot", ("distance", "points", "median", "90%"), tuple(rows))


def _correction_table(cases: Iterable[Case]) -> Table:
    rows: list[tuple[object, ...]] = []
    for case in cases:
        rows.append((case.title, *_spread(case.fit), float(np.degrees(case.fit.corrections[:, 1].mean()))))
        if within := _spread_within_places(case.fit):
            rows.append((f"{case.title}, within a place", *within, ""))
    heads = ("set", "pitch sd", "roll sd", "heading sd", "mean roll")
    return Table("Corrections per picture, degrees", heads, tuple(rows))


# --- the figure ---

# Told apart by readers who see red and green alike: they differ in lightness, from each other and the carpet.
LINE_COLOUR, GOAL_COLOUR, EDGE_COLOUR = "#0033cc", "#cc0066", "#ff9d00"
SHOWN: tuple[tuple[PictureSet, str], ...] = (
    ("scenes", "scene_001.png"),
    ("scenes", "scene_030.png"),
    ("straightwalk", "walk_001.png"),
    ("scenes", "scene_017.png"),
    ("scenes", "scene_046.png"),
    ("straightwalk", "walk_010.png"),
    ("scenes", "scene_061.png"),
    ("scenes", "scene_014.png"),
    ("straightwalk", "walk_017.png"),
)


def field_curves(field: Field, camera: FloatArray) -> dict[str, list[FloatArray]]:
    """Sample a field as curves of points (N, 3) in metres, by the colour they are drawn in.

    Lines, arcs and marks by their two edges; posts and bars by their outlines, seen from above `camera` (2,).
    """
    d, half = field.dimensions, field.dimensions.line_width / 2
    lines = [edge for line in [*field.lines, *field.mark_lines] for edge in _outline(line, half)]
    for x, y, radius, first, last in field.arcs:
        angles = np.linspace(first, last, 240)
        for r in (radius - half, radius + half):
            lines.append(np.column_stack([x + r * np.cos(angles), y + r * np.sin(angles), 0 * angles]))
    goals = []
    for x, y in field.posts:
        away = np.array([x, y]) - camera
        aside = np.array([-away[1], away[0]]) / np.linalg.norm(away) * d.post_diameter / 2
        goals += [
            _straight((*((x, y) + s * aside), 0.0), (*((x, y) + s * aside), d.post_height)) for s in (-1, 1)
        ]
    for first_end, last_end in field.bars:
        goals += [
            _straight(first_end + (0, 0, s), last_end + (0, 0, s))
            for s in (-d.bar_diameter / 2, d.bar_diameter / 2)
        ]
    x0, y0, x1, y1 = field.carpet
    corners = [(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0), (x0, y0, 0.0)]
    edges = [_straight(a, b) for a, b in pairwise(corners)]
    return {LINE_COLOUR: lines, GOAL_COLOUR: goals, EDGE_COLOUR: edges}


def _straight(first: npt.ArrayLike, last: npt.ArrayLike) -> FloatArray:
    """Return points (300, 3) from one to the other; so many that a lens bends them smoothly."""
    return np.linspace(np.asarray(first, dtype=float), np.asarray(last, dtype=float), 300)


def _outline(line: FloatArray, half: float) -> list[FloatArray]:
    """Return the four sides of a line on the ground that is parallel to an axis."""
    x0, y0, x1, y1 = (*np.minimum(line[:2], line[2:]), *np.maximum(line[:2], line[2:]))
    if x0 == x1:
        corners = [(x0 - half, y0, 0.0), (x0 + half, y0, 0.0), (x0 + half, y1, 0.0), (x0 - half, y1, 0.0)]
    else:
        corners = [(x0, y0 - half, 0.0), (x1, y0 - half, 0.0), (x1, y0 + half, 0.0), (x0, y0 + half, 0.0)]
    return [_straight(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]


def draw_pictures(fits: dict[PictureSet, SetFit], cases: Sequence[Case]) -> Path:
    """Draw nine real pictures with the fitted field over them into ``build/reality.png``.

    Returns
    -------
    Path
        Of the figure, in a folder that git ignores.
    """
    predictions: dict[str, list[Prediction]] = {}
    for prediction in (p for case in cases for p in case.predictions):
        predictions.setdefault(prediction.picture, []).append(prediction)
    figure = Figure(figsize=(15, 13.8), dpi=130, layout="constrained")
    figure.set_layout_engine("constrained", hspace=0.05, h_pad=0.08)
    for axes, (name, file) in zip(figure.subplots(3, 3).flat, SHOWN, strict=True):
        fit = fits[name]
        number = [item.picture.name for item in fit.matched].index(file)
        _draw_picture(
            axes, fit.matched[number].picture, fit.values, fit.corrections[number], predictions[file]
        )
    figure.legend(handles=_legend(), loc="outside lower center", ncols=5, fontsize=13, frameon=False)
    figure.suptitle(
        "A real NAO's pictures and the library's field, seen through the fitted camera", fontsize=18
    )
    BUILD.mkdir(exist_ok=True)
    figure.savefig(BUILD / "reality.png")
    return BUILD / "reality.png"


def _draw_picture(
    axes: Axes,
    picture: RealPicture,
    values: FloatArray,
    correction: FloatArray,
    predictions: Sequence[Prediction],
) -> None:
    """Draw one picture, the field over it, and its marked and predicted points."""
    view, pose = fitted_view(picture, values, correction)
    width, height = view.size
    axes.imshow(picture.read(large=picture.has_large), extent=(-0.5, width - 0.5, height - 0.5, -0.5))
    camera = pose.to_parent(view.position[:2])[0]
    for colour, curves in field_curves(FIELD, camera).items():
        style = (0, (4, 2)) if colour == EDGE_COLOUR else "-"
        for curve in curves:
            axes.plot(*view.project(curve, pose).T, color=colour, linewidth=1.0, linestyle=style)
    axes.plot(*np.array([p.marked for p in predictions]).T, **MARKED)
    axes.plot(*np.array([p.predicted for p in predictions]).T, **PREDICTED)
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), xticks=[], yticks=[])
    middle = float(np.median(errors_of(predictions)))
    where = (
        f"from ({picture.pose.x:.2f}, {picture.pose.y:.2f}) m, heading {np.degrees(picture.pose.theta):.0f}°"
    )
    title = f"{picture.path.stem.replace('_', ' ')}, {where}".replace("-", "−")
    axes.set_title(f"{title}\n{len(predictions)} points, median error {middle:.1f} pixels", fontsize=12)


HALO = [withStroke(linewidth=2.6, foreground="white")]
MARKED: dict[str, Any] = {
    "linestyle": "",
    "marker": "o",
    "markersize": 10,
    "fillstyle": "none",
    "color": "black",
    "path_effects": HALO,
}
PREDICTED: dict[str, Any] = {
    "linestyle": "",
    "marker": "x",
    "markersize": 6,
    "markeredgewidth": 1.5,
    "color": "#d55e00",
    "path_effects": HALO,
}


def _legend() -> list[Line2D]:
    """Return what the curves and marks mean."""
    return [
        Line2D([], [], color=LINE_COLOUR, label="lines, circle, marks"),
        Line2D([], [], color=GOAL_COLOUR, label="goal"),
        Line2D([], [], color=EDGE_COLOUR, linestyle=(0, (4, 2)), label="edge of the carpet by the rules"),
        Line2D([], [], label="marked by hand", **MARKED),
        Line2D([], [], label="predicted from the other points", **PREDICTED),
    ]
