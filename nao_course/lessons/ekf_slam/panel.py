"""The player of lesson 07: the film of a log, step by step, forwards and backwards, at speed."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterator
from typing import Any

from nao_course.lessons.ekf_slam.film import Film, FilmStrip, record_film, say_frame
from nao_course.lessons.ekf_slam.homework_log import own_log
from nao_course.widgets import Action, Choice, FunctionPanel, Slider
from nao_course.widgets.attempts import newest_definition
from nao_course.widgets.inputs import Values
from nao_course.widgets.parts import BREATH

SPEEDS = {"1 a second": 1.0, "3 a second": 3.0, "8 a second": 8.0}
FRAMES = "frame"


class FilmPanel(FunctionPanel):
    """The log's film, made by your functions: run once, then played.

    Parameters
    ----------
    init_landmarks, predict, update : callable
        Your functions, as in exercises 7.2, 7.3 and 7.5.
    """

    def __init__(
        self, init_landmarks: Callable[..., Any], predict: Callable[..., Any], update: Callable[..., Any]
    ) -> None:
        """Begin at the start of the log."""
        self._functions = {"init_landmarks": init_landmarks, "predict": predict, "update": update}
        self._made: dict[Any, tuple[Film, FilmStrip]] = {}
        self._playing: asyncio.Task[None] | None = None
        self._direction = 1
        self._last = 2 * len(own_log().controls)
        super().__init__(
            "The film",
            self._play,
            [
                Slider(
                    FRAMES,
                    "Half step",
                    0,
                    self._last,
                    1,
                    0,
                    tooltip="Even: updated; odd: predicted. The arrow keys go one on or back",
                ),
                Action("forwards", "Play", key=" ", tooltip="Play forwards, or stop"),
                Action("backwards", "Backwards", key="b", tooltip="Play backwards, or stop"),
                Action("back", "One back", key="arrowleft"),
                Action("on", "One on", key="arrowright"),
                Choice("speed", "Speed", list(SPEEDS), start="3 a second", tooltip="Half steps in a second"),
            ],
            student=self._functions,
            unfinished={
                "init_landmarks": "Finish exercise 7.2: the film begins with the landmarks of the first look.",
                "predict": "Finish exercise 7.3 to see the film.",
                "update": "Finish exercises 7.4 and 7.5 to see the film.",
            },
        )

    @property
    def playing(self) -> bool:
        """Whether the film runs."""
        return self._playing is not None and not self._playing.done()

    def stop(self) -> None:
        """Stop the film where it is."""
        if self._playing is not None:
            self._playing.cancel()
        self._playing = None

    def _play(self, values: Values, student: Any) -> Iterator[Any]:
        """Show one half step; the log is run only where a function has changed."""
        key = tuple(newest_definition(each) for each in self._functions.values())
        if key not in self._made:
            film = record_film(student.init_landmarks, student.predict, student.update)
            self._made = {key: (film, FilmStrip(film))}
        film, strip = self._made[key]
        map_picture, matrix = strip.pictures(values.frame)
        yield {"The map": map_picture, "Correlations": matrix}
        yield say_frame(film, values.frame)

    def _pressed(self, action: Action) -> None:
        """Go one on or back; begin to play, turn round, or stop."""
        direction = 1 if action.name in ("on", "forwards") else -1
        stops = self.playing and direction == self._direction
        self.stop()
        if action.name in ("on", "back"):
            self._go(direction)
        elif not stops:
            self._begin(direction)

    def _begin(self, direction: int) -> None:
        end = self._last if direction > 0 else 0
        if self.values.frame == end:
            self.set(frame=self._last - end)
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:  # no kernel: a plain Python program has nobody who watches
            self.set(frame=end)
            return
        self._direction = direction
        self._playing = loop.create_task(self._follow(direction))

    async def _follow(self, direction: int) -> None:
        began = time.perf_counter()
        while self._go(direction):
            took = time.perf_counter() - began
            await asyncio.sleep(max(BREATH, 1 / SPEEDS[self.values.speed] - took))
            began = time.perf_counter()

    def _go(self, direction: int) -> bool:
        """Go by half a step, where there is one; whether there is another after it."""
        frame = self.values.frame + direction
        if 0 <= frame <= self._last:
            self.set(frame=frame)
        return bool(0 < frame < self._last and self._latest.done)
