"""The robot's motions in small steps: code runs them to the end, and buttons run them as a task in the background."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Generator
from contextlib import suppress

from nao_course.robot import RobotError
from nao_course.sim import SimulatedNao
from nao_course.slam import Motion
from nao_course.widgets.control_panel.cockpit import Cockpit, small_steps
from nao_course.widgets.control_panel.waiting import WaitingMotions, in_words
from nao_course.widgets.parts import BREATH, PERIOD

PATIENCE = 1.0  # s that a drive waits until a page has shown its picture; the page may be closed


class MotionRunner:
    """Runs the motions of a panel's robot, one after the other.

    `by_itself` returns the next motion while the robot drives by itself, or None. `refresh` takes new pictures and
    shows everything after each small step; `show_status` is called when only the message has changed. The next step
    waits while `is_behind`, which says whether a page is more than one picture behind the robot; `give_up` ends this.
    """

    def __init__(
        self,
        cockpit: Cockpit,
        by_itself: Callable[[], Motion | None],
        refresh: Callable[[], None],
        show_status: Callable[[], None],
        is_behind: Callable[[], bool] = lambda: False,
        give_up: Callable[[], None] = lambda: None,
    ) -> None:
        """Begin while the robot stands still."""
        self._is_behind, self._give_up = is_behind, give_up
        self._cockpit, self._refresh, self._show_status = cockpit, refresh, show_status
        self._waiting = WaitingMotions(by_itself)
        self._task: asyncio.Task[None] | None = None
        self._stopping = False
        self.closed = False

    @property
    def going(self) -> bool:
        """Whether a drive that a button started is still running."""
        return self._task is not None and not self._task.done()

    def waiting_text(self) -> str:
        """Return a sentence about the waiting motions; empty if none waits."""
        return self._waiting.text()

    def run(self, motion: Motion) -> None:
        """Run a motion to its end. Raise a ValueError if the panel is closed."""
        if self.closed:
            raise ValueError(
                "this panel is closed, because a newer panel drives this robot: use the newer panel"
            )
        steps = self._steps(motion)
        part = next(steps, None)
        while part is not None:
            part = _after(steps, self._cockpit.step(part))

    def press(self, motion: Motion) -> None:
        """Run a motion as a task of the kernel's loop, so that the buttons still respond; later motions wait."""
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
        """Run the motions that the student's code chooses until the drive is stopped."""
        self._waiting.by_itself = True
        if not self.going and (motion := self._waiting.take()) is not None:
            self.press(motion)

    def stop(self) -> None:
        """Stop a real robot at once and a simulated one after the present step, and discard the waiting motions."""
        self._waiting.clear()
        self._stopping = self.going
        if self.going:
            with suppress(RobotError):  # the step that runs says what is wrong
                self._cockpit.nao.stop()

    def close(self) -> None:
        """Stop, and refuse further motions."""
        self.stop()
        self.closed = True

    def report_panel_error(self, error: Exception) -> None:
        """Show an error of the panel itself."""
        self._cockpit.complain("the panel", error)
        self._show_status()

    async def _go(self, motion: Motion) -> None:
        """Run a drive as a task; after an error it is reported, and nothing waits any longer."""
        try:
            await self._go_on(motion)
        except Exception as error:  # noqa: BLE001 - no caller of a task could catch this
            self._waiting.clear()
            self.report_panel_error(error)

    async def _go_on(self, motion: Motion) -> None:
        """Run a motion and then the waiting ones, with at most one step per `PERIOD`."""
        upcoming: Motion | None = motion
        while upcoming is not None:
            began = time.perf_counter()
            steps = self._steps(upcoming)
            part = next(steps, None)
            while part is not None:
                part = _after(steps, await self._step(part))
                await asyncio.sleep(max(BREATH, PERIOD - (time.perf_counter() - began)))
                await self._until_shown()
                began = time.perf_counter()
                if self._stopping:
                    self._waiting.clear()
                    if not self.closed:
                        self._cockpit.say("Stopped.")
                    self._show_status()
                    return
            upcoming = self._waiting.take()

    async def _step(self, part: Motion) -> Motion:
        """Run a step; a robot that takes its time walks in a thread, so that the buttons still respond."""
        if isinstance(self._cockpit.nao, SimulatedNao):
            return self._cockpit.step(part)
        return await asyncio.to_thread(self._cockpit.step, part)

    async def _until_shown(self) -> None:
        """Wait until at most one picture is on its way to the pages, so that they do not fall behind the robot."""
        end = time.perf_counter() + PATIENCE
        while self._is_behind():
            if self._stopping or time.perf_counter() > end:
                self._give_up()
            await asyncio.sleep(BREATH)

    def _steps(self, motion: Motion) -> Generator[Motion, Motion, None]:
        """Yield the steps of a motion, and show new pictures and a new map after each step that comes back as run.

        It ends if `slam` fails or the carpet ends, which also stops a robot that drives by itself.
        """
        self._cockpit.moves += 1
        self._cockpit.say(f"{in_words(motion)} …")
        self._cockpit.printed = ""
        for part in small_steps(motion):
            if self._cockpit.is_blocked(part):
                self._waiting.by_itself = False
                self._cockpit.say(f"{in_words(motion)}: stopped, because the carpet ends here.")
                self._show_status()
                return
            done = yield part
            succeeded = self._cockpit.note(done)
            self._refresh()
            if not succeeded:
                return
        if not self._cockpit.alarm:
            self._cockpit.say(f"{in_words(motion)}: done.")
            self._show_status()


def _after(steps: Generator[Motion, Motion, None], done: Motion) -> Motion | None:
    """Return the step after a step that was run; None after the last."""
    try:
        return steps.send(done)
    except StopIteration:
        return None
