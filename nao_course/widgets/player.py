"""A panel whose first slider can be played like a film, forwards and backwards."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Mapping, Sequence
from typing import Any

from nao_course.widgets.function_panel import FunctionPanel, Show
from nao_course.widgets.inputs import Action, Choice, Control, Slider
from nao_course.widgets.keyboard import REPEAT_CLASS
from nao_course.widgets.parts import BREATH

_DIRECTIONS = {"forwards": 1, "backwards": -1}  # the buttons that play
_LABELS = {"forwards": "Play", "backwards": "Backwards"}


class PlayerPanel(FunctionPanel):
    """A panel whose first slider plays.

    While the slider plays, its button is labelled Pause. Moving the slider, pressing a button of the player or pressing
    Reset stops it. A held key steps at the playing speed.

    Parameters
    ----------
    title, show
        As in `FunctionPanel`.
    slider : Slider
        The slider that plays; its values must be integers.
    others : sequence of Control
        Further controls.
    speeds : mapping of str to float
        Steps per second, by their names on the panel; a single speed has no menu.
    speed : str, optional
        Name of the start value; by default the first speed.
    backwards : bool
        Whether it can also play backwards.
    **more : object
        As in `FunctionPanel`.
    """

    def __init__(
        self,
        title: str,
        show: Show,
        slider: Slider,
        others: Sequence[Control] = (),
        *,
        speeds: Mapping[str, float],
        speed: str = "",
        backwards: bool = True,
        **more: Any,
    ) -> None:
        """Build the widgets, and show the results for the first values."""
        self._played, self._speeds = slider, dict(speeds)
        self._playing: asyncio.Task[None] | None = None
        self._direction = 1
        self._pace = REPEAT_CLASS
        own = _buttons(slider, backwards=backwards)
        if len(speeds) > 1:
            words = f"{slider.label}s per second"
            first = speed or next(iter(speeds))
            own.append(Choice("speed", "Speed", list(speeds), start=first, tooltip=words, stays=True))
        super().__init__(title, show, [slider, *own, *others], **more)
        self._keep_keys_in_pace()

    @property
    def playing(self) -> bool:
        """Whether the slider is playing."""
        return self._playing is not None and not self._playing.done()

    @property
    def speed(self) -> float:
        """Steps per second."""
        return self._speeds[self._values.get("speed", next(iter(self._speeds)))]

    def stop(self) -> None:
        """Stop at the present step."""
        if self._playing is not None:
            self._playing.cancel()
        self._playing = None
        self._name_buttons()

    def reset(self) -> None:
        """Stop, and set all controls to their start values, except the choices that stay, such as the speed."""
        self.stop()
        super().reset()

    def _moved(self, control: Control, change: Any) -> None:
        """Update the value of a control that was moved on the page; moving the slider stops playing."""
        if control is self._played and not self._moving:
            self.stop()
        super()._moved(control, change)
        self._keep_keys_in_pace()

    def _pressed(self, action: Action) -> None:
        """Run the action of a player's button: one step, play, change the direction, or stop."""
        if action.name in _DIRECTIONS:
            direction = _DIRECTIONS[action.name]
            stops = self.playing and direction == self._direction
            self.stop()
            if not stops:
                self._begin(direction)
        elif action.name in ("on", "back"):
            self.stop()
            self._step(1 if action.name == "on" else -1)
        else:
            super()._pressed(action)

    def _step(self, direction: int) -> None:
        """Move by one step, and draw it when there is time, so that a held key never runs ahead of the pictures."""
        place = self._place + direction
        if self._played.low <= place <= self._played.high:
            self._take(self._checked({self._played.name: place}))
            self._newest.ask()

    def _begin(self, direction: int) -> None:
        low, high = self._played.low, self._played.high
        end, start = (high, low) if direction > 0 else (low, high)
        if self._place == end:
            self.set(**{self._played.name: start})
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:  # no kernel: a plain Python program shows no film
            self.set(**{self._played.name: end})
            return
        self._direction = direction
        self._playing = loop.create_task(self._run_steps(direction))
        self._name_buttons()

    async def _run_steps(self, direction: int) -> None:
        try:
            began = time.perf_counter()
            while self._go(direction):
                took = time.perf_counter() - began
                await asyncio.sleep(max(BREATH, 1 / self.speed - took))
                began = time.perf_counter()
        finally:
            if self._playing is asyncio.current_task():
                self._playing = None
            self._name_buttons()

    def _go(self, direction: int) -> bool:
        """Move by one step if possible; return whether a further step is possible."""
        low, high, place = self._played.low, self._played.high, self._place + direction
        if low <= place <= high:
            self.set(**{self._played.name: place})
        return bool(low < place < high and self._latest.done)

    @property
    def _place(self) -> int:
        return int(self._values[self._played.name])

    def _name_buttons(self) -> None:
        """Label the button of the playing direction Pause."""
        for name, label in _LABELS.items():
            if name in self._widgets:
                pauses = self.playing and _DIRECTIONS[name] == self._direction
                self._widgets[name].description = "Pause" if pauses else label

    def _keep_keys_in_pace(self) -> None:
        """Let a held key step at the playing speed."""
        self.widget.remove_class(self._pace)
        self._pace = f"{REPEAT_CLASS}{round(1000 / self.speed)}"
        self.widget.add_class(self._pace)


def _buttons(slider: Slider, *, backwards: bool) -> list[Control]:
    """Return the buttons of a player."""
    one = f"One {slider.label.lower()}"
    turned = [Action("backwards", _LABELS["backwards"], key="b", tooltip="Play backwards, or pause")]
    return [
        Action("forwards", _LABELS["forwards"], key=" ", tooltip="Play forwards, or pause"),
        *(turned if backwards else []),
        Action("back", "Step back", key="arrowleft", tooltip=f"{one} back"),
        Action("on", "Step on", key="arrowright", tooltip=f"{one} on"),
    ]
