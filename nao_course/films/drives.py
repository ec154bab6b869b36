"""The film of a drive over a field: the true path, odometry, and the estimates of one or more algorithms."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.films.film import Film
from nao_course.films.layers import Layer, ellipse_layer, landmark_layer, line_layer, path_layer
from nao_course.geometry import FloatArray, Pose
from nao_course.plotting.style import GREY, style_of
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement, measured_points

DEAD_RECKONING = "odometry"  # has no map


def drive_film(
    title: str,
    field: Field,
    truth: Sequence[Pose] | None,
    estimates: Mapping[str, Sequence[Estimate]],
    seen: Sequence[Iterable[Measurement]],
    pace: int = 3,
) -> Film:
    """Return the film of a drive with a frame for each picture.

    Parameters
    ----------
    title : str
        Title of the film.
    field : Field
        The field.
    truth : sequence of Pose or None
        True pose at each picture, if it is known.
    estimates : mapping of str to sequence of Estimate
        Estimates at each picture, by source ("odometry", "ekf" or "graph"), in the frame of `truth`. The measurements
        are drawn from the pose of the last source.
    seen : sequence of iterable of Measurement
        Measurements of each picture.
    pace : int
        Frames a second at first.

    Returns
    -------
    Film
        Its captions say how far off every estimated position is, if the truth is known.
    """
    maps = [source for source in estimates if source != DEAD_RECKONING]
    rays = [
        _rays(each.pose, measurements) for each, measurements in zip(estimates[maps[-1]], seen, strict=True)
    ]
    layers = [layer for source in maps for layer in _map_layers(source, estimates[source])]
    layers.append(line_layer(GREY, rays, "measured", alpha=0.9, jumps=True))
    if truth is not None:
        layers.append(path_layer("truth", [each.as_array() for each in truth], "true path"))
    layers += [
        path_layer(source, [each.pose.as_array() for each in found]) for source, found in estimates.items()
    ]
    captions = [f"After {say_count(number + 1, 'picture')}." for number in range(len(seen))]
    if truth is not None:
        captions = [
            f"{caption} Position off: {_say_errors(estimates, number, truth[number])}."
            for number, caption in enumerate(captions)
        ]
    return Film(title, layers, captions, field, step="Picture", pace=pace)


def _map_layers(source: str, estimates: Sequence[Estimate]) -> list[Layer]:
    """Return the ellipses and the landmarks of an algorithm."""
    style = style_of(source)
    spreads = [
        (
            np.vstack([[each.pose.x, each.pose.y], each.landmarks]),
            np.concatenate([each.covariance[None, :2, :2], each.landmark_covariances]),
        )
        for each in estimates
    ]
    places = [(each.landmarks, each.kinds) for each in estimates]
    return [
        ellipse_layer(style.colour, spreads, f"{style.label}, 95 %"),
        landmark_layer(style.colour, places, f"{style.label}: landmark"),
    ]


def _rays(pose: Pose, measurements: Iterable[Measurement]) -> FloatArray:
    ends = measured_points(measurements, pose)
    return np.hstack([np.tile([pose.x, pose.y], (len(ends), 1)), ends])


def _say_errors(estimates: Mapping[str, Sequence[Estimate]], number: int, true: Pose) -> str:
    found = {style_of(source).label: each[number].pose for source, each in estimates.items()}
    off = {name: 100 * float(np.hypot(pose.x - true.x, pose.y - true.y)) for name, pose in found.items()}
    return ", ".join(f"{name} {each:.{int(each < 10)}f} cm" for name, each in off.items())
