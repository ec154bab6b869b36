"""A demo as a figure, as a film in which the map grows beside what the robot sees, and in a folder with its errors."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from nao_course.geometry import FloatArray
from nao_course.lessons.slam_on_the_field.system.compass import lean_from_lines
from nao_course.lessons.slam_on_the_field.system.demo.drive import Story
from nao_course.lessons.slam_on_the_field.system.demo.report import errors_of, make_folder, results, way_of
from nao_course.lessons.slam_on_the_field.system.lines import read_lines
from nao_course.lessons.slam_on_the_field.system.observation import POST_RADIUS, leaning
from nao_course.plotting import (
    LANDMARK_MARKERS,
    STYLES,
    Drawing,
    course_style,
    plot_estimate,
    plot_field,
    plot_path,
    plot_picture,
    style_of,
)
from nao_course.plotting.drawing import say_count
from nao_course.plotting.legends import landmark_keys, legend_below, source_key
from nao_course.plotting.marks import rgb
from nao_course.plotting.style import CARPET, FOUND, YELLOW
from nao_course.sim import Field

LINES = "#00c8ff"  # over lines that were found in a picture
FRAMES, PER_SECOND, LAST = 31, 3.0, 3.0  # of the film: pictures, pictures a second, seconds of the last one
COMMON, RARE = 64, 32  # colours of a frame beside the figures' own: few, so that the film stays small
MILLIMETRE = 0.1  # cm: below that an error is not drawn


def write_all(story: Story, field: Field, folder: Path) -> list[Path]:
    """Write figure, film and errors into a folder; return the files."""
    path = make_folder(folder) / "demo.json"
    path.write_text(json.dumps(results(story, field), indent=2) + "\n", encoding="utf-8")
    return [
        path,
        draw_story(story, field).save(folder / "demo.png"),
        write_film(story, field, folder / "demo.gif"),
    ]


def draw_story(story: Story, field: Field) -> Drawing:
    """Draw the map at the end by each algorithm, and below them the error on the way with what was stated of it."""
    names = list(story.estimates)
    with course_style():
        figure = Figure(figsize=(5.0 * max(len(names), 1.6), 8.2))
        grid = figure.add_gridspec(2, len(names), height_ratios=(1.75, 1))
        for column, name in enumerate(names):
            ax = figure.add_subplot(grid[0, column])
            plot_field(field, ax)
            _plot_drive(ax, story, name, len(story.sights) - 1)
            ax.set_title(f"{style_of(name).label}: {_say_off(story, name, -1)}")
        _plot_errors(figure.add_subplot(grid[1, :]), story)
        legend_below(figure, _keys(story, names), columns=6)
    told = "; ".join(f"{style_of(name).label} {_say_off(story, name, -1)}" for name in names)
    return Drawing(
        figure,
        f"A drive of {way_of(story.poses):.0f} m over the field, {len(story.sights)} pictures. At its end odometry is "
        f"{_off(story, 'odometry', -1):.0f} cm off; {told}. Below, the errors on the way.",
    )


def write_film(story: Story, field: Field, path: Path, frames: int = FRAMES) -> Path:
    """Write the drive as a GIF: the picture with what was found in it beside the first algorithm's map."""
    chosen = np.unique(np.linspace(0, len(story.sights) - 1, frames).astype(int)).tolist()
    first, *others = map(_few_colours, _frames(story, field, chosen))
    durations = [round(1000 / PER_SECOND)] * len(others) + [round(1000 * LAST)]
    first.save(path, save_all=True, append_images=others, duration=durations, loop=0, optimize=True)
    return path


def _frames(story: Story, field: Field, chosen: list[int]) -> Iterator[Image.Image]:
    """Draw the chosen pictures, each with the map of its time: field and frame once, what moves each time."""
    name = next(iter(story.estimates))
    with course_style():
        figure = Figure(figsize=(8.4, 4.3), dpi=100)
        seen, above = figure.subplots(1, 2, width_ratios=(1.28, 1))
        plot_field(field, above)
        legend_below(figure, _keys(story, [name])[:3], columns=3)
        still = {ax: set(ax.get_children()) for ax in (seen, above)}
        for number in chosen:
            for ax, kept in still.items():
                for artist in set(ax.get_children()) - kept:
                    artist.remove()
            seen.set_title(
                f"after {way_of(story.poses[: number + 1]):.1f} m: {_plot_sight(seen, story, number)}",
                fontsize=11,
            )
            _plot_drive(above, story, name, number)
            above.set_title(_say_frame(story, name, number), fontsize=10)
            if figure.get_layout_engine() is not None:
                figure.draw_without_rendering()
                figure.set_layout_engine("none")
            buffer = io.BytesIO()
            figure.savefig(buffer, format="png")
            yield Image.open(buffer).convert("RGB")


def _few_colours(shown: Image.Image) -> Image.Image:
    """A frame with a palette of its own, in which the colours of paths and marks are what they are elsewhere."""
    common = shown.quantize(COMMON).getpalette() or []
    rare = shown.quantize(RARE, Image.Quantize.MAXCOVERAGE).getpalette() or []  # a post's yellow
    own = [LINES, FOUND, CARPET, YELLOW, "#ffffff", *(style.colour for style in STYLES.values())]
    palette = Image.new("P", (1, 1))
    fixed = [part for colour in own for part in rgb(colour)]
    palette.putpalette([*fixed, *common[: 3 * COMMON], *rare[: 3 * RARE]])
    return shown.quantize(palette=palette, dither=Image.Dither.NONE)


def _plot_drive(ax: Axes, story: Story, name: str, number: int) -> None:
    """Truth, odometry and an algorithm's path and map up to a picture, on a field that is there."""
    plot_path(story.odometry[: number + 1], ax, "odometry")
    plot_path(story.poses[: number + 1], ax, "truth")
    plot_path([each.pose for each in story.estimates[name][: number + 1]], ax, name, robot=False)
    plot_estimate(story.estimates[name][number], ax, name)


def _plot_errors(ax: Axes, story: Story) -> None:
    """Errors of the position over the way, logarithmic; dotted, how far an algorithm states that it may be."""
    poses = story.poses
    way = [way_of(poses[: number + 1]) for number in range(len(poses))]
    for name in ("odometry", *story.estimates):
        style = style_of(name)
        errors = [max(_off(story, name, number), MILLIMETRE) for number in range(len(poses))]
        ax.semilogy(way, errors, color=style.colour, ls="--" if name == "odometry" else "-", lw=1.6)
        if name != "odometry":
            stated = [100 * np.sqrt(np.trace(each.covariance[:2, :2])) for each in story.estimates[name]]
            ax.semilogy(way, np.maximum(stated, MILLIMETRE), color=style.colour, ls=":", lw=1.4)
    ax.set(xlabel="way (m)", ylabel="position error (cm)", xlim=(0, max(way[-1], 0.1)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.grid(alpha=0.3)
    ax.set_title("error on the way; dotted: standard deviation as stated", fontsize=11)


def _plot_sight(ax: Axes, story: Story, number: int) -> str:
    """A picture with the lines, posts and corners that were found in it; return them in words."""
    sight, observed = story.sights[number], story.seen[number]
    lines = read_lines(sight.pixels, sight.view)
    lean = lean_from_lines(lines, sight.view)
    level = leaning(sight.view, lean.pitch, lean.roll)
    plot_picture(sight.pixels, ax, ticks=False)
    for ends in sight.view.distort(lines.reshape(-1, 2)).reshape(-1, 2, 2):
        ax.plot(*ends.T, color=LINES, lw=1.8)
    told = [say_count(len(lines), "line")]
    for kind, radius in (("corner", 0.0), ("post", POST_RADIUS)):
        own = np.array([(m.bearing, m.range - radius) for m in observed if m.kind == kind]).reshape(-1, 2)
        pixels = level.project(_points(own))
        ax.plot(*pixels.T, LANDMARK_MARKERS[kind], color=FOUND, mec="white", ms=11, mew=1.3)
        told.append(say_count(len(own), kind))
    ax.set(xlim=(-0.5, sight.view.size[0] - 0.5), ylim=(sight.view.size[1] - 0.5, -0.5))
    return ", ".join(told)


def _points(polar: FloatArray) -> FloatArray:
    """Points (N, 2) of the robot frame from bearing and range (N, 2)."""
    bearing, away = polar.T
    return np.column_stack([away * np.cos(bearing), away * np.sin(bearing)])


def _keys(story: Story, names: list[str]) -> list[Any]:
    """Keys of what the figure shows."""
    keys = [source_key("truth", "true path"), source_key("odometry")]
    keys += [source_key(name, f"{style_of(name).label}, 95 %") for name in names]
    kinds = {kind for name in names for kind in story.estimates[name][-1].kinds}
    return keys + landmark_keys(kinds, "#4b5563", "mapped")


def _off(story: Story, name: str, number: int) -> float:
    """How far odometry or an algorithm is off at a picture, cm."""
    pose = story.odometry[number] if name == "odometry" else story.estimates[name][number].pose
    return 100 * errors_of(pose, story.poses[number])["position"]


def _say_off(story: Story, name: str, number: int) -> str:
    return f"{_off(story, name, number):.1f} cm off"


def _say_frame(story: Story, name: str, number: int) -> str:
    odometry = f"odometry {_off(story, 'odometry', number):.0f} cm off"
    return f"{odometry}, {style_of(name).label} {_off(story, name, number):.1f} cm"
