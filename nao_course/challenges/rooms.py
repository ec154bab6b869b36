"""Cases of a challenge that are pictures in simulated rooms."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nao_course.sim import Reality, Scene
from nao_course.sim.scenes import random_scene

SIZE = (320, 240)  # of a challenge's pictures


@dataclass(frozen=True)
class Place:
    """A picture of a room as a case of a challenge: "dark 7" is the seventh of the dark pictures.

    `preset` is a preset of `Reality`, `room` the seed of the room, and `number` the picture's in that room, from 0.
    """

    name: str
    preset: str
    room: int
    number: int

    def __str__(self) -> str:
        """Return its name."""
        return self.name

    @property
    def reality(self) -> Reality:
        """The effects in its pictures: its preset in its room."""
        preset: Reality = getattr(Reality, self.preset)(seed=self.room)
        return preset

    def scene(self, shows: Callable[[Scene], bool], stream: Sequence[int] = ()) -> Scene:
        """Take pictures of 320 x 240 pixels from random places until one suits the case, the same one at every call.

        ``shows(scene)`` returns whether a picture suits it; `stream` are further seeds, so that two challenges use
        different random numbers in the same room.
        """
        reality = self.reality
        rng = np.random.default_rng([self.room, self.number, *stream])
        while True:
            if shows(scene := random_scene(SIZE, reality, rng)):
                return scene


def places(rooms: Mapping[str, Sequence[int]], in_each: int) -> tuple[Place, ...]:
    """Return the cases of a challenge, `in_each` per room, numbered by preset.

    `rooms` has seeds by preset; entries of the board must be tuned in other rooms.
    """
    return tuple(
        Place(f"{preset} {before * in_each + number + 1}", preset, room, number)
        for preset, seeds in rooms.items()
        for before, room in enumerate(seeds)
        for number in range(in_each)
    )
