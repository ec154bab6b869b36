"""What the panels' tests drive: robots without noise, algorithms that remember or fail, hands and eyes."""

import asyncio

import cv2
import numpy as np

from nao_course.sim import Reality, SimulatedNao
from nao_course.slam import DeadReckoning


class Recorder(DeadReckoning):
    """Remembers what it was told."""

    def __init__(self, start=None):
        super().__init__(start)
        self.motions, self.seen = [], []

    def move(self, motion):
        self.motions.append(motion)
        super().move(motion)

    def observe(self, measurements):
        self.seen.append(tuple(measurements))


class Failing(Recorder):
    """Raises where it is told to."""

    def __init__(self, where):
        super().__init__()
        self.where = where

    def move(self, motion):
        super().move(motion)
        if self.where == "move":
            raise IndexError("index 9 is out of bounds <b>for</b> axis 0")

    def observe(self, measurements):
        if self.where == "observe":
            raise ZeroDivisionError("division by zero")

    def estimate(self):
        return None if self.where == "estimate" else super().estimate()


def clean_nao(seed=1, **options):
    return SimulatedNao(rng=seed, reality=Reality.clean(), **options)


def press(panel, name):
    """Press the button that the browser would press."""

    def find(widget):
        if f"nao-do-{name}" in widget._dom_classes:
            return widget
        return next(filter(None, map(find, getattr(widget, "children", ()))), None)

    find(panel.widget).click()


def all_widgets(widget):
    yield widget
    for child in getattr(widget, "children", ()):
        yield from all_widgets(child)


def decoded(image):
    """The pixels that the browser would show."""
    return cv2.imdecode(np.frombuffer(image.value, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def in_a_loop(scenario):
    """Run a scenario in a loop as a kernel has one."""
    return asyncio.run(scenario())


async def until_it_stands(panel):
    """Wait until nothing drives any longer."""
    while panel.driving:
        await asyncio.sleep(0.01)
