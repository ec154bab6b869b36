"""Figure and film of a demo; the film shows each picture beside the map at that time."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from nao_course._internal.counts import say_count
from nao_course.field_slam.compass import estimate_body_tilt
from nao_course.field_slam.demo.drive import Story
from nao_course.field_slam.demo.report import (
    errors_of,
    kidnapping_in_words,
    make_folder,
    results,
    sigma_of,
    way_of,
)
from nao_course.field_slam.lines import read_lines
from nao_course.field_slam.observation import radius_of, tilted
from nao_course.films import Film, drive_film, film_page, line_layer
from nao_course.geometry import FloatArray, Pose
from nao_course.plotting import (
    LANDMARK_MARKERS,
    Drawing,
    course_style,
    plot_estimate,
    plot_field,
    plot_path,
    plot_picture,
    style_of,
)
from nao_course.plotting.legends import landmark_keys, legend_below, source_key
from nao_course.plotting.style import FOUND
from nao_course.sim import Field
from nao_course.slam import KINDS, Estimate

LINES = "#00c8ff"  # over lines that were found in a picture
# Pictures in the film, pictures per second, seconds of the last picture.
FRAMES, PER_SECOND, LAST = (31, 3.0, 3.0)
QUALITY = 80  # of 100: the carpet looks as in the pictures, and the file has half the size of a GIF
CARRIED = "carried away"  # in legends
ARROW = {"arrowstyle": "-|>", "ls": ":", "lw": 2.2, "shrinkA": 0, "shrinkB": 0}
MILLIMETRE = 0.1  # cm: smallest error in the figure, whose axis is logarithmic


def write_all(story: Story, field: Field, folder: Path) -> list[Path]:
    """Write the errors, the figure, and the film as WebP, as numbers and as a page; return the paths of the files."""
    path = make_folder(folder) / "demo.json"
    path.write_text(json.dumps(results(story, field), indent=2) + "\n", encoding="utf-8")
    numbers = film_of(story, field)
    page = folder / "demo.html"
    page.write_text(film_page(numbers.data()), encoding="utf-8")
    return [
        path,
        draw_story(story, field).save(folder / "demo.png"),
        write_film(story, field, folder / "demo.webp"),
        numbers.save(folder / "film.json"),
        page,
    ]


def film_of(story: Story, field: Field) -> Film:
    """Return the drive as a film of numbers, which a browser draws and plays."""
    estimates = {"odometry": _as_estimates(story.odometry), **story.estimates}
    truth = story.poses if story.has_truth else None
    film = drive_film("The robot maps the field by its pictures", field, truth, estimates, story.seen)
    if story.carried is None:
        return film
    ends = [_carried(story, number).reshape(-1, 4) for number in range(len(story.frames))]
    return replace(film, layers=[*film.layers, line_layer(FOUND, ends, CARRIED, jumps=True, width=3)])


def _as_estimates(poses: Sequence[Pose]) -> list[Estimate]:
    """Return poses as estimates without uncertainty and without landmarks."""
    return [Estimate(pose, np.zeros((3, 3)), np.empty((0, 2)), np.empty((0, 2, 2))) for pose in poses]


@course_style()
def draw_story(story: Story, field: Field) -> Drawing:
    """Draw the last map of each algorithm, and below the maps the errors of the position with their stated sigmas."""
    names = list(story.estimates)
    figure = Figure(figsize=(5.0 * max(len(names), 1.6), 8.2))
    grid = figure.add_gridspec(2, len(names), height_ratios=(1.75, 1))
    for column, name in enumerate(names):
        ax = figure.add_subplot(grid[0, column])
        plot_field(field, ax)
        _plot_drive(ax, story, name, len(story.frames) - 1)
        ax.set_title(f"{style_of(name).label}: {_say_off(story, name, -1)}")
    _plot_errors(figure.add_subplot(grid[1, :]), story)
    legend_below(figure, _keys(story, names), columns=6)
    at_end = "; ".join(f"{style_of(name).label} {_say_off(story, name, -1)}" for name in names)
    if story.has_truth:
        at_end = (
            f"odometry is {_off(story, 'odometry', -1):.0f} cm off; {at_end}. Below, the errors along the way"
        )
    drive = f"A drive of {way_of(story.frames):.0f} m over the field, {len(story.frames)} pictures"
    return Drawing(figure, " ".join([f"{drive}. At its end {at_end}.", *kidnapping_in_words(story)]))


def write_film(story: Story, field: Field, path: Path, frames: int = FRAMES) -> Path:
    """Write the drive as an animated WebP: each picture with its detections beside the map of the first algorithm."""
    chosen = np.unique(np.linspace(0, len(story.frames) - 1, frames).astype(int)).tolist()
    first, *others = _frames(story, field, chosen)
    durations = [round(1000 / PER_SECOND)] * len(others) + [round(1000 * LAST)]
    first.save(
        path, save_all=True, append_images=others, duration=durations, loop=0, quality=QUALITY, method=4
    )
    return path


def _frames(story: Story, field: Field, chosen: list[int]) -> Iterator[Image.Image]:
    """Yield the frames of the film; the field and the axes are drawn only once, because that takes the longest."""
    name = next(iter(story.estimates))
    with course_style():
        figure = Figure(figsize=(8.4, 4.3), dpi=100)
        seen, above = figure.subplots(1, 2, width_ratios=(1.28, 1))
        plot_field(field, above)
        legend_below(figure, _keys(story, [name])[: 3 + (story.carried is not None)])
        still = {ax: set(ax.get_children()) for ax in (seen, above)}
        for number in chosen:
            for ax, kept in still.items():
                for artist in set(ax.get_children()) - kept:
                    artist.remove()
            seen.set_title(
                f"after {way_of(story.frames[: number + 1]):.1f} m: {_plot_detections(seen, story, field, number)}",
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


def _plot_drive(ax: Axes, story: Story, name: str, number: int) -> None:
    """Plot the true path, the odometry, and the path and map of an algorithm up to a picture, over a field."""
    plot_path(story.odometry[: number + 1], ax, "odometry")
    if story.has_truth:
        poses, first = story.poses[: number + 1], story.carried or 0
        plot_path(poses[:first], ax, robot=number < first)
        plot_path(poses[first:], ax)
    plot_path([each.pose for each in story.estimates[name][: number + 1]], ax, name, robot=False)
    if len(ends := _carried(story, number)):
        ax.annotate("", ends[1], ends[0], arrowprops={"color": FOUND, **ARROW}, zorder=4.2)
    plot_estimate(story.estimates[name][number], ax, name)


def _carried(story: Story, number: int) -> FloatArray:
    """Return both ends (2, 2) of the robot's way while it was carried, m; (0, 2) if that was not before a picture."""
    first = story.carried
    ends = [] if first is None or first > number else story.poses[first - 1 : first + 1]
    return np.array([(pose.x, pose.y) for pose in ends]).reshape(-1, 2)


def _plot_errors(ax: Axes, story: Story) -> None:
    """Plot the known errors of the position over the way on a logarithmic axis, and dotted the stated sigmas."""
    poses = story.poses
    way = [way_of(story.frames[: number + 1]) for number in range(len(poses))]
    for name in ("odometry", *story.estimates):
        style = style_of(name)
        if story.has_truth:
            errors = [max(_off(story, name, number), MILLIMETRE) for number in range(len(poses))]
            ax.semilogy(way, errors, color=style.colour, ls="--" if name == "odometry" else "-", lw=1.6)
        if name != "odometry":
            stated = [100 * sigma_of(each) for each in story.estimates[name]]
            ax.semilogy(way, np.maximum(stated, MILLIMETRE), color=style.colour, ls=":", lw=1.4)
    if story.carried is not None:
        ax.axvline(way[story.carried], color=FOUND, ls=":", lw=2.2)
    ax.set(xlabel="way (m)", ylabel="position error (cm)", xlim=(0, max(way[-1], 0.1)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.grid(alpha=0.3)
    error = "error on the way; " if story.has_truth else ""
    ax.set_title(f"{error}dotted: standard deviation as stated", fontsize=11)


def _plot_detections(ax: Axes, story: Story, field: Field, number: int) -> str:
    """Plot a picture with the lines, posts and corners that were found in it, and return their numbers as text."""
    seen, observed = story.frames[number], story.seen[number]
    lines = read_lines(seen.pixels, seen.view, field.dimensions.line_width)
    tilt = estimate_body_tilt(lines, seen.view)
    level = tilted(seen.view, tilt.pitch, tilt.roll)
    plot_picture(seen.pixels, ax, ticks=False)
    for ends in seen.view.distort(lines.reshape(-1, 2)).reshape(-1, 2, 2):
        ax.plot(*ends.T, color=LINES, lw=1.8)
    counts = [say_count(len(lines), "line")]
    for kind in KINDS:
        own = np.array([(m.bearing, m.range - radius_of(kind)) for m in observed if m.kind == kind]).reshape(
            -1, 2
        )
        pixels = level.project(_points(own))
        ax.plot(*pixels.T, LANDMARK_MARKERS[kind], color=FOUND, mec="white", ms=11, mew=1.3)
        counts.append(say_count(len(own), kind))
    ax.set(xlim=(-0.5, seen.view.size[0] - 0.5), ylim=(seen.view.size[1] - 0.5, -0.5))
    return ", ".join(counts)


def _points(polar: FloatArray) -> FloatArray:
    """Return the points (N, 2) in the robot frame with some bearings and ranges (N, 2)."""
    bearing, distance = polar.T
    return np.column_stack([distance * np.cos(bearing), distance * np.sin(bearing)])


def _keys(story: Story, names: list[str]) -> list[Any]:
    """Return the entries of the legend."""
    keys = [source_key("truth", "true path")] if story.has_truth else []
    keys.append(source_key("odometry"))
    keys += [source_key(name, f"{style_of(name).label}, 95 %") for name in names]
    if story.carried is not None:
        keys.append(Line2D([], [], color=FOUND, ls=":", lw=2.2, marker=">", label=CARRIED))
    kinds = {kind for name in names for kind in story.estimates[name][-1].kinds}
    return keys + landmark_keys(kinds, "#4b5563", "mapped")


def _off(story: Story, name: str, number: int) -> float:
    """Return the error of the position by odometry or by an algorithm at a picture, cm."""
    pose = story.odometry[number] if name == "odometry" else story.estimates[name][number].pose
    return 100 * errors_of(pose, story.poses[number])["position"]


def _say_off(story: Story, name: str, number: int) -> str:
    """Say how far off an algorithm is at a picture, or else what it states."""
    if story.has_truth:
        return f"{_off(story, name, number):.1f} cm off"
    return f"states {100 * sigma_of(story.estimates[name][number]):.1f} cm"


def _say_frame(story: Story, name: str, number: int) -> str:
    if not story.has_truth:
        return f"{style_of(name).label} {_say_off(story, name, number)}"
    odometry = f"odometry {_off(story, 'odometry', number):.0f} cm off"
    found = "is lost" if story.lost[number] else f"{_off(story, name, number):.1f} cm"
    return f"{odometry}, {style_of(name).label} {found}"
