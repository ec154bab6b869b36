"""A panel that plays: one slider goes step by step, forwards and backwards, at speed, until somebody takes over."""

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

    While it plays, its button says Pause. Whoever moves the slider, presses a button of the player or Reset takes over:
    then it plays no longer. A key that is held goes on at the speed at which it plays.

    Parameters
    ----------
    title, show
        As of `FunctionPanel`.
    slider : Slider
        What plays: whole numbers.
    others : sequence of Control
        What else can be set.
    speeds : mapping of str to float
        Steps in a second, by what the panel calls them; with a single one there is nothing to choose.
    speed : str, optional
        The one at first; by default the first.
    backwards : bool
        Whether it plays backwards, too.
    **more : object
        As of `FunctionPanel`.
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
        """Show the start and build the widgets."""
        self._played, self._speeds = slider, dict(speeds)
        self._playing: asyncio.Task[None] | None = None
        self._direction = 1
        self._pace = REPEAT_CLASS
        own = _buttons(slider, backwards=backwards)
        if len(speeds) > 1:
            words = f"{slider.label}s in a second"
            first = speed or next(iter(speeds))
            own.append(Choice("speed", "Speed", list(speeds), start=first, tooltip=words, stays=True))
        super().__init__(title, show, [slider, *own, *others], **more)
        self._keep_keys_in_pace()

    @property
    def playing(self) -> bool:
        """Whether it plays."""
        return self._playing is not None and not self._playing.done()

    @property
    def speed(self) -> float:
        """How many steps it plays in a second."""
        return self._speeds[self._values.get("speed", next(iter(self._speeds)))]

    def stop(self) -> None:
        """Stop where it is."""
        if self._playing is not None:
            self._playing.cancel()
        self._playing = None
        self._name_buttons()

    def reset(self) -> None:
        """Stop, and set all controls back to where they began, but for those that stay, such as the speed."""
        self.stop()
        super().reset()

    def _moved(self, control: Control, change: Any) -> None:
        """Follow a control on the page; who moves the slider takes over."""
        if control is self._played and not self._moving:
            self.stop()
        super()._moved(control, change)
        self._keep_keys_in_pace()

    def _pressed(self, action: Action) -> None:
        """Go one on or back; begin to play, turn round, or stop."""
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
        """Go one on or back, and draw it when there is time: a key that is held never runs ahead of the pictures."""
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
        except RuntimeError:  # no kernel: a plain Python program has nobody who watches
            self.set(**{self._played.name: end})
            return
        self._direction = direction
        self._playing = loop.create_task(self._follow(direction))
        self._name_buttons()

    async def _follow(self, direction: int) -> None:
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
        """Go one step, where there is one; whether there is another after it."""
        low, high, place = self._played.low, self._played.high, self._place + direction
        if low <= place <= high:
            self.set(**{self._played.name: place})
        return bool(low < place < high and self._latest.done)

    @property
    def _place(self) -> int:
        return int(self._values[self._played.name])

    def _name_buttons(self) -> None:
        """Say Pause on the button of the direction in which it plays."""
        for name, label in _LABELS.items():
            if name in self._widgets:
                pauses = self.playing and _DIRECTIONS[name] == self._direction
                self._widgets[name].description = "Pause" if pauses else label

    def _keep_keys_in_pace(self) -> None:
        """Let a key that is held press as often as it plays."""
        self.widget.remove_class(self._pace)
        self._pace = f"{REPEAT_CLASS}{round(1000 / self.speed)}"
        self.widget.add_class(self._pace)


def _buttons(slider: Slider, *, backwards: bool) -> list[Control]:
    """The buttons of a player."""
    one = f"One {slider.label.lower()}"
    turned = [Action("backwards", _LABELS["backwards"], key="b", tooltip="Play backwards, or pause")]
    return [
        Action("forwards", _LABELS["forwards"], key=" ", tooltip="Play forwards, or pause"),
        *(turned if backwards else []),
        Action("back", "One back", key="arrowleft", tooltip=f"{one} back"),
        Action("on", "One on", key="arrowright", tooltip=f"{one} on"),
    ]
