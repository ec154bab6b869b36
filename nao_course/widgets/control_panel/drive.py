"""The drive: motions in small steps, at once from code, or as a task beside which the panel's buttons stay live."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterator

from nao_course.slam import Motion
from nao_course.widgets.control_panel.cockpit import Cockpit, pieces
from nao_course.widgets.control_panel.waiting import WaitingMotions, in_words
from nao_course.widgets.parts import BREATH, PERIOD


class Drive:
    """What moves a panel's robot, one motion after the other.

    Parameters
    ----------
    cockpit : Cockpit
        With the robot; it is told what is being done.
    by_itself : callable
        Returns the motion to go on with by itself, or None.
    look : callable
        Called after each small step: takes new pictures and shows everything.
    show_status : callable
        Called where only what is said has changed.
    """

    def __init__(
        self,
        cockpit: Cockpit,
        by_itself: Callable[[], Motion | None],
        look: Callable[[], None],
        show_status: Callable[[], None],
    ) -> None:
        """Begin with a robot that stands."""
        self._cockpit, self._look, self._show_status = cockpit, look, show_status
        self._waiting = WaitingMotions(by_itself)
        self._task: asyncio.Task[None] | None = None
        self._stopping = False
        self.closed = False

    @property
    def going(self) -> bool:
        """Whether a drive that a button began is going on."""
        return self._task is not None and not self._task.done()

    def said(self) -> str:
        """Say what waits for its turn; empty where nothing does."""
        return self._waiting.said()

    def run(self, motion: Motion) -> None:
        """Drive now and to the end.

        Raises
        ------
        ValueError
            If it is closed.
        """
        if self.closed:
            raise ValueError("this panel is closed: a newer one drives this robot")
        for _ in self._steps(motion):
            pass

    def press(self, motion: Motion) -> None:
        """Drive as a task of the kernel's loop, so that the buttons stay live; further commands wait their turn."""
        if self.going:
            self._waiting.add(motion)
            self._show_status()
            return
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:  # no kernel: a plain Python program
            self.run(motion)
            return
        self._stopping = False
        self._task = loop.create_task(self._go(motion))

    def go_by_itself(self) -> None:
        """Drive where the student's code says until somebody stops it."""
        self._waiting.itself = True
        if not self.going and (motion := self._waiting.take()) is not None:
            self.press(motion)

    def stop(self) -> None:
        """Stop after the present step, and forget what was to come next."""
        self._waiting.clear()
        self._stopping = self.going

    def close(self) -> None:
        """Stop, and drive no more."""
        self.stop()
        self.closed = True

    def admit(self, error: Exception) -> None:
        """Say that the panel itself failed."""
        self._cockpit.complain("the panel", error)
        self._show_status()

    async def _go(self, motion: Motion) -> None:
        """Drive with nobody above who could catch a mistake."""
        try:
            await self._go_on(motion)
        except Exception as error:  # noqa: BLE001 - a task has nobody above it who could catch this
            self.admit(error)

    async def _go_on(self, motion: Motion) -> None:
        """Drive, and then what was asked for meanwhile; at most one step each `PERIOD`."""
        upcoming: Motion | None = motion
        while upcoming is not None:
            began = time.perf_counter()
            for _ in self._steps(upcoming):
                await asyncio.sleep(max(BREATH, PERIOD - (time.perf_counter() - began)))
                began = time.perf_counter()
                if self._stopping:
                    if not self.closed:
                        self._cockpit.say("Stopped.")
                    self._show_status()
                    return
            upcoming = self._waiting.take()

    def _steps(self, motion: Motion) -> Iterator[None]:
        """Do a motion step by step, with new pictures and a new map after each; end where `slam` fails."""
        self._cockpit.say(f"{in_words(motion)} …")
        self._cockpit.printed = ""
        for part in pieces(motion):
            went_well = self._cockpit.move(part)
            self._look()
            if not went_well:
                return
            yield
        if not self._cockpit.alarm:
            self._cockpit.say(f"{in_words(motion)}: done.")
            self._show_status()
