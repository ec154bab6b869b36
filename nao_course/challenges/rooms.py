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
    """A case of a challenge: a picture in a room.

    Parameters
    ----------
    name : str
        Name, such as "dark 7" for the seventh of the dark pictures.
    preset : str
        Preset of `Reality`.
    room : int
        Seed of the room.
    number : int
        Number of the picture in that room, from 0.
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
        """Take pictures from random places until one of them suits the case.

        Parameters
        ----------
        shows : callable
            ``shows(scene)`` returns whether a picture suits the case.
        stream : sequence of int
            Further seeds, so that two challenges use different random numbers in the same room.

        Returns
        -------
        Scene
            A scene of 320 x 240 pixels, the same at every call.
        """
        reality = self.reality
        rng = np.random.default_rng([self.room, self.number, *stream])
        while True:
            if shows(scene := random_scene(SIZE, reality, rng)):
                return scene


def places(rooms: Mapping[str, Sequence[int]], in_each: int) -> tuple[Place, ...]:
    """Return the cases of a challenge, `in_each` per room, numbered by preset.

    Parameters
    ----------
    rooms : mapping of str to sequence of int
        Seeds of rooms by preset. Entries of the board must be tuned in other rooms.
    in_each : int
        Number of pictures per room.
    """
    return tuple(
        Place(f"{preset} {before * in_each + number + 1}", preset, room, number)
        for preset, seeds in rooms.items()
        for before, room in enumerate(seeds)
        for number in range(in_each)
    )
