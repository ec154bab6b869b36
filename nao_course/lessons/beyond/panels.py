"""Panels of lesson 12: distances by two cameras, the exploration of a room, and a drive with chosen moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nao_course._internal.counts import say_count
from nao_course.geometry import Pose
from nao_course.lessons.beyond import exploring, planning
from nao_course.lessons.beyond.exploring import (
    Choose,
    Known,
    anywhere_known,
    as_mask,
    explore,
    lawn_mower,
    nearest_frontier,
)
from nao_course.lessons.beyond.planning import journey
from nao_course.lessons.beyond.two_cameras import Distances, measure_again
from nao_course.lessons.beyond.worlds import FIELD, LANDMARKS
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import style_of
from nao_course.sim import NAO_V4
from nao_course.widgets import Choice, FunctionPanel, PlayerPanel, Ray, Slider, Toggle, WorldPlayer, WorldView

MEASUREMENTS = 120
MOVES = 80
_COLOURS = {"unknown": "#c9ccd1", "free": "#ffffff", "box": "#444444"}  # as the grid's -1, 0 and 1
# A grid on which different functions give different answers
_PROBE = np.random.default_rng(12).integers(0, 3, (7, 9))
_STRATEGIES: Mapping[str, Callable[[Any, int], Choose]] = {
    "to the nearest frontier": lambda student, room: nearest_frontier(student.find_frontiers),
    "to random places": lambda student, room: anywhere_known(np.random.default_rng([room, 32])),
    "in lanes": lambda student, room: lawn_mower(),
}

_RULES: Mapping[str, Callable[[Any, int], planning.Choose]] = {
    "your choice": lambda student, seed: student.choose_move,
    "at random": lambda student, seed: planning.at_random(seed),
    "in a circle": lambda student, seed: planning.in_a_circle,
    "along the edge": lambda student, seed: planning.straight_on,
}


class TwoCamerasPanel(FunctionPanel):
    """Distances of a point on the floor, measured by one camera and by both while the body tilts.

    Parameters
    ----------
    intersect_rays, pixel_to_ground : callable
        The student's functions of this lesson and of lesson 04.
    """

    def __init__(self, intersect_rays: Callable[..., Any], pixel_to_ground: Callable[..., Any]) -> None:
        """Start 2 m away, with the point in both pictures."""
        low, high = np.degrees(NAO_V4.pitch_limits)
        super().__init__(
            "How far is it?",
            _measured,
            [
                Slider(
                    "distance",
                    "Distance",
                    1.0,
                    5.0,
                    0.5,
                    2.0,
                    unit="m",
                    tooltip="Distance of the point on the floor",
                ),
                Slider(
                    "pitch",
                    "Head",
                    float(np.ceil(low)),
                    float(np.floor(high)),
                    1.0,
                    -6.0,
                    unit="°",
                    tooltip="Pitch: positive looks down",
                ),
                Slider(
                    "tilt",
                    "Tilt",
                    0.0,
                    3.0,
                    0.1,
                    1.3,
                    unit="°",
                    tooltip="Standard deviation of the body's pitch",
                ),
                Choice("width", "Pixels across", (320, 640, 1280), tooltip="Resolution of both cameras"),
            ],
            student={"intersect_rays": intersect_rays, "pixel_to_ground": pixel_to_ground},
            unfinished={
                "intersect_rays": "Finish exercise 12.4 to measure with two cameras.",
                "pixel_to_ground": "Finish exercise 4.4 to measure with one camera.",
            },
        )


def _measured(values: Any, student: Any) -> Iterator[Any]:
    size = (int(values.width), int(values.width) * 3 // 4)
    tilt = float(np.radians(values.tilt))
    distances = measure_again(
        student.intersect_rays,
        student.pixel_to_ground,
        values.distance,
        size,
        pitch=float(np.radians(values.pitch)),
        tilt=(tilt, tilt * 0.8 / 1.3),
        count=MEASUREMENTS,
    )
    yield {"": draw_distances(distances)}
    yield say_sigmas(distances)


def say_sigmas(distances: Distances) -> str:
    """Describe both standard deviations, as far as they exist."""
    one, both = distances.sigmas
    alone = f"Standard deviation: one camera {one:.3f} m"
    if np.isnan(one):
        alone = "The bottom camera does not see it"
    if not distances.seen:
        return f"The point is not in both pictures: pitch the head. {alone}."
    return f"{alone}, both {both:.3f} m; both see it in {distances.seen:.0%} of the measurements."


@course_style()
def draw_distances(distances: Distances) -> Drawing:
    """Draw histograms of the distances measured by one camera and by both."""
    figure = Figure(figsize=(7.4, 3.4))
    ax = figure.add_subplot()
    edges = np.linspace(0, 2 * distances.truth, 81).tolist()
    for values, source, name in ((distances.one, "odometry", "one camera"), (distances.both, "ekf", "both")):
        measured, colour = values[np.isfinite(values)], style_of(source).colour
        ax.hist(measured, edges, color=colour, alpha=0.35, label=name)
        ax.hist(measured, edges, color=colour, histtype="step", lw=1.5)
    ax.axvline(distances.truth, color=STYLES["truth"].colour, lw=2, label="truth")
    ax.set(
        xlabel="measured distance (m)",
        ylabel=f"count of {len(distances.one)} measurements",
        xlim=(0, 2 * distances.truth),
    )
    ax.legend(loc="upper right")
    return Drawing(
        figure,
        f"Distances measured of a point {distances.truth:g} m away, {len(distances.one)} measurements. "
        f"{say_sigmas(distances)}",
    )


class ExplorePanel(PlayerPanel):
    """A robot that explores a room of boxes, move by move.

    Parameters
    ----------
    find_frontiers, travel_steps : callable
        The student's functions.
    """

    def __init__(self, find_frontiers: Callable[..., Any], travel_steps: Callable[..., Any]) -> None:
        """Start after ten moves in the first room."""
        self._explored: dict[Any, list[Known]] = {}
        super().__init__(
            "Where nobody has looked",
            self._draw,
            Slider("move", "Move", 0, MOVES - 1, 1, 10, tooltip="Number of moves"),
            [
                Slider("room", "Room", 0, 9, 1, 0, tooltip="Arrangement of the boxes"),
                Choice("strategy", "Drives", tuple(_STRATEGIES), tooltip="How the next goal is chosen"),
            ],
            speeds={"3 moves a second": 3.0},
            student={"find_frontiers": find_frontiers, "travel_steps": travel_steps},
            unfinished={
                "find_frontiers": "Finish exercise 12.5 to see the frontiers.",
                "travel_steps": "Finish exercise 12.6 to see the robot go there.",
            },
        )

    def _draw(self, values: Any, student: Any) -> Iterator[Any]:
        """Draw a move of a drive, which is computed again only if the student's functions have changed."""
        tried = [np.array(student.find_frontiers(_PROBE - 1)), student.travel_steps(_PROBE != 0, (0, 0))]
        key = (int(values.room), values.strategy, *(np.array(each).tobytes() for each in tried))
        if key not in self._explored:
            choose = _STRATEGIES[values.strategy](student, int(values.room))
            self._explored[key] = list(explore(student.travel_steps, choose, int(values.room), MOVES))
        known = self._explored[key][int(values.move)]
        frontiers = as_mask(student.find_frontiers(known.grid.copy()), known.grid.shape)
        yield {"": draw_known(known, frontiers)}
        yield (
            f"After {int(values.move)} moves {known.part:.0%} of the visible area is known, "
            f"with {say_count(int(frontiers.sum()), 'frontier cell')}."
        )


class MovesPanel(WorldPlayer):
    """A drive over the half field, move by move, whose moves are chosen by one of several rules.

    Parameters
    ----------
    choose_move, predict, update_landmarks, add_landmark : callable
        The student's functions of this lesson and of lesson 07.
    """

    def __init__(
        self,
        choose_move: Callable[..., Any],
        predict: Callable[..., Any],
        update_landmarks: Callable[..., Any],
        add_landmark: Callable[..., Any],
    ) -> None:
        """Begin at the start of a drive with chosen moves."""
        super().__init__(
            "The drive in the room",
            WorldView(FIELD),
            self._show_move,
            Slider("move", "Move", 0, planning.MOVES, 1, 0, tooltip="Number of moves"),
            [
                Slider("drive", "Drive", 0, 11, 1, 0, tooltip="Another start, other errors"),
                Choice("rule", "Moves", tuple(_RULES), tooltip="How the next move is chosen"),
                Toggle("behind", "Goal behind", tooltip="Start with the goal behind the robot"),
            ],
            speeds={"2 moves a second": 2.0},
            student={
                "choose_move": choose_move,
                "predict": predict,
                "update_landmarks": update_landmarks,
                "add_landmark": add_landmark,
            },
            unfinished={"choose_move": "Finish exercise 12.7 to see your choice, or try the other rules."},
        )

    def _show_move(self, values: Any, student: Any) -> Iterator[str]:
        """Show both robots after a move, with the rays to the landmarks that were measured."""
        rule, number = _RULES[values.rule](student, int(values.drive)), int(values.move)
        ekf = student.predict, student.update_landmarks, student.add_landmark
        drive = journey(rule, ekf, int(values.drive), number, back=values.behind)
        self.world.update(
            Pose.from_array(drive.truth[-1]),
            drive.estimates[-1],
            rays=[Ray(tuple(LANDMARKS[each].tolist())) for each in drive.seen[-1]],
            paths={"truth": drive.truth, "ekf": [each.pose for each in drive.estimates]},
        )
        yield (
            f"After {say_count(number, 'move')}: standard deviation {100 * drive.sigmas[-1]:.0f} cm, "
            f"off by {100 * drive.errors[-1]:.0f} cm, {say_count(len(drive.known), 'landmark')} on the map."
        )


@course_style()
def draw_known(known: Known, frontiers: Any) -> Drawing:
    """Draw the known part of a room, the frontiers, the robot and its goal."""
    x0, y0, x1, y1 = exploring.X0, exploring.Y0, exploring.X1, exploring.Y1
    ends = exploring.cell_centres()[frontiers]
    figure = Figure(figsize=(5.6, 5.9))
    ax = figure.add_subplot()
    ax.imshow(
        known.grid,
        cmap=ListedColormap(list(_COLOURS.values())),
        vmin=-1,
        vmax=1,
        origin="lower",
        extent=(x0, x1, y0, y1),
    )
    ax.plot(*ends.T, "s", color=STYLES["odometry"].colour, ms=4)
    if known.goal is not None:
        ax.plot(*exploring.cell_centres()[known.goal], "x", color=STYLES["ekf"].colour, ms=11, mew=3.5)
    ax.plot(*known.place, "o", color=STYLES["truth"].colour, ms=10, mec="white")
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    legend_below(figure, _keys(), columns=3)
    return Drawing(
        figure,
        f"A room of {x1 - x0:.1f} by {y1 - y0:.1f} m from above: grey is unknown, white free, black a box. "
        f"{known.part:.0%} is known, and {say_count(len(ends), 'cell')} are frontiers.",
    )


def _keys() -> list[Any]:
    """Return the legend of the map of a room."""
    patches = [Patch(fc=colour, ec="#8a8f98", label=label) for label, colour in _COLOURS.items()]
    marks = (("robot", "o", "truth"), ("frontier", "s", "odometry"), ("goal", "x", "ekf"))
    return [
        *patches,
        *(
            Line2D([], [], ls="", marker=marker, color=style_of(source).colour, mew=2.5, label=label)
            for label, marker, source in marks
        ),
    ]
