"""Cases of a challenge in rooms: which preset, which room, which picture in it, and the pictures themselves."""

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
        Such as "dark 7": the seventh of the dark pictures.
    preset : str
        Of `Reality`.
    room : int
        Seed of the room.
    number : int
        Of the picture in that room, from 0.
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
        """How real its pictures look, in its room."""
        preset: Reality = getattr(Reality, self.preset)(seed=self.room)
        return preset

    def scene(self, shows: Callable[[Scene], bool], stream: Sequence[int] = ()) -> Scene:
        """Take pictures from random places until one shows what a case needs.

        Parameters
        ----------
        shows : callable
            ``shows(scene)`` says whether a picture will do.
        stream : sequence of int
            Tells the random numbers of one challenge from another's in the same room.

        Returns
        -------
        Scene
            The same at every call, 320 x 240.
        """
        reality = self.reality
        rng = np.random.default_rng([self.room, self.number, *stream])
        while True:
            if shows(scene := random_scene(SIZE, reality, rng)):
                return scene


def places(rooms: Mapping[str, Sequence[int]], in_each: int) -> tuple[Place, ...]:
    """List the cases of a challenge: so many in each room, counted by preset.

    Parameters
    ----------
    rooms : mapping of str to sequence of int
        Seeds of rooms by their preset. Whoever tunes an entry of the board tunes it in others.
    in_each : int
        How many pictures a room has.
    """
    return tuple(
        Place(f"{preset} {before * in_each + number + 1}", preset, room, number)
        for preset, seeds in rooms.items()
        for before, room in enumerate(seeds)
        for number in range(in_each)
    )
