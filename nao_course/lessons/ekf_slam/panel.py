"""The film panel of lesson 07: play the run of a log step by step, forwards and backwards."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from nao_course.lessons.ekf_slam.film import Film, FilmStrip, record_film, say_frame
from nao_course.lessons.ekf_slam.homework_log import own_log
from nao_course.widgets import PlayerPanel, Slider
from nao_course.widgets.attempts import newest_definition
from nao_course.widgets.inputs import Values

SPEEDS = {"1 a second": 1.0, "3 a second": 3.0, "8 a second": 8.0}
FRAMES = "frame"


class FilmPanel(PlayerPanel):
    """Film of the log, computed once with your functions and then played.

    Parameters
    ----------
    init_landmarks, predict, update : callable
        Your functions, as in exercises 7.2, 7.3 and 7.5.
    """

    def __init__(
        self, init_landmarks: Callable[..., Any], predict: Callable[..., Any], update: Callable[..., Any]
    ) -> None:
        """Create the panel at the start of the log."""
        self._functions = {"init_landmarks": init_landmarks, "predict": predict, "update": update}
        self._made: dict[Any, tuple[Film, FilmStrip]] = {}
        super().__init__(
            "The film",
            self._play,
            Slider(
                FRAMES,
                "Half step",
                0,
                2 * len(own_log().controls),
                1,
                0,
                tooltip="Even half steps are updates, odd ones predictions. The arrow keys move by one half step",
            ),
            speeds=SPEEDS,
            speed="3 a second",
            student=self._functions,
            unfinished={
                "init_landmarks": "Finish exercise 7.2 to see the film: it begins with your first landmarks.",
                "predict": "Finish exercise 7.3 to see the film.",
                "update": "Finish exercises 7.4 and 7.5 to see the film.",
            },
        )

    def _play(self, values: Values, student: Any) -> Iterator[Any]:
        """Show one half step; run the log again only if a function has changed."""
        key = tuple(newest_definition(each) for each in self._functions.values())
        if key not in self._made:
            film = record_film(student.init_landmarks, student.predict, student.update)
            self._made = {key: (film, FilmStrip(film))}
        film, strip = self._made[key]
        map_picture, matrix = strip.pictures(values.frame)
        yield {"The map": map_picture, "Correlations": matrix}
        yield say_frame(film, values.frame)

    def say_pace(self, seconds: float) -> str:
        """Return a sentence on the time that the student's code took for the whole log."""
        return f"Your code took {1000 * seconds:.0f} ms for the whole log." if self._student.called else ""
