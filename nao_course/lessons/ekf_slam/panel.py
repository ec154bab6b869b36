"""The film panel of lesson 07: the run of a log, half step by half step, with the correlations beside the map."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course import films
from nao_course.lessons.ekf_slam.film import (
    IMPROVED,
    INITIAL,
    KEYS,
    PREDICTED,
    UPDATED,
    FilterFilm,
    correlations,
    draw_frames,
    record_film,
    say_frame,
)
from nao_course.plotting.style import STYLES
from nao_course.sim.drives import landmark_blocks
from nao_course.widgets.vector_map import VectorFilmPanel


class FilmPanel(VectorFilmPanel):
    """Film of the log, computed once with your functions and then played.

    Parameters
    ----------
    init_landmarks, predict, update : callable
        Your functions, as in exercises 7.2, 7.3 and 7.5.
    """

    def __init__(
        self, init_landmarks: Callable[..., Any], predict: Callable[..., Any], update: Callable[..., Any]
    ) -> None:
        """Record the film."""
        super().__init__(
            "The film",
            lambda student: browser_film(_recorded(student)),
            student={"init_landmarks": init_landmarks, "predict": predict, "update": update},
            unfinished={
                "init_landmarks": "Finish exercise 7.2 to see the film: it begins with your first landmarks.",
                "predict": "Finish exercise 7.3 to see the film.",
                "update": "Finish exercises 7.4 and 7.5 to see the film.",
            },
            still=lambda student: draw_frames(_recorded(student)),
        )


def _recorded(student: Any) -> FilterFilm:
    return record_film(student.init_landmarks, student.predict, student.update)


def browser_film(film: FilterFilm) -> films.Film:
    """Return a run as a film for the browser, with two frames for each step: the prediction and the update."""
    frames = [film.at(number) for number in range(film.last + 1)]
    robots = [(state[None, :2], covariance[None, :2, :2]) for _, state, covariance in frames]
    nothing = np.empty((0, 2)), np.empty((0, 2, 2))
    # A prediction leaves the landmarks as they were.
    landmarks = [
        (frames[number - number % 2][1][3:].reshape(-1, 2), landmark_blocks(frames[number - number % 2][2]))
        for number in range(film.last + 1)
    ]
    predicted = [each if number % 2 else nothing for number, each in enumerate(robots)]
    updated = [nothing if number % 2 else each for number, each in enumerate(robots)]
    k = len(film.truth)
    numbers = [str(number) for number in range(1, k + 1)]
    layers = [
        films.ellipse_layer(INITIAL, landmarks[:1], KEYS[INITIAL], fill=0.07),
        films.ellipse_layer(PREDICTED, predicted, KEYS[PREDICTED], keeps=True, fill=0.07),
        films.ellipse_layer(UPDATED, updated, KEYS[UPDATED], keeps=True, fill=0.07),
        films.ellipse_layer(IMPROVED, landmarks, KEYS[IMPROVED], fill=0.07),
        films.point_layer(IMPROVED, [places for places, _ in landmarks], marker="+", size=5),
        films.point_layer(STYLES["truth"].colour, [film.truth], "landmark, true", size=3, texts=numbers),
        films.path_layer("ekf", [state[:3] for _, state, _ in frames], "robot, estimated", dash=[]),
    ]
    matrix = films.Matrix(
        "Correlations",
        [correlations(covariance) for _, _, covariance in frames],
        [3, *[2] * k],
        ["pose", *numbers],
    )
    captions = [say_frame(film, number) for number in range(film.last + 1)]
    return films.Film("EKF SLAM on our log", layers, captions, matrices=[matrix], step="Half step")
