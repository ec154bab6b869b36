"""A short queue of motions that wait while the robot still drives."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from itertools import groupby

import numpy as np

from nao_course.slam import Motion

MOST_WAITING = 6  # motions; a longer queue would be a key that is held, not quick taps


class WaitingMotions:
    """A queue of motions that can describe its contents.

    While the robot drives `by_itself`, an empty queue takes the next motion from the student's code.
    """

    def __init__(self, next_motion: Callable[[], Motion | None] = lambda: None) -> None:
        """Create an empty queue; ``next_motion()`` returns the next motion while the robot drives by itself."""
        self._motions: deque[Motion] = deque()
        self._refused = False
        self._next_motion, self.by_itself = next_motion, False

    def add(self, motion: Motion) -> None:
        """Append a motion; if the queue is full, discard the motion, and `text` reports that."""
        self._refused = len(self._motions) >= MOST_WAITING
        if not self._refused:
            self._motions.append(motion)

    def take(self) -> Motion | None:
        """Take the oldest motion from the queue; None if it is empty and the robot does not drive by itself."""
        self._refused = False
        if self._motions:
            return self._motions.popleft()
        motion = self._next_motion() if self.by_itself else None
        self.by_itself = motion is not None and bool(motion.distance or motion.turn)
        return motion if self.by_itself else None

    def clear(self) -> None:
        """Discard all motions, and stop driving by itself."""
        self._motions.clear()
        self._refused = self.by_itself = False

    def text(self) -> str:
        """Return a sentence that lists the waiting motions; empty if none waits."""
        if not self._motions:
            return ""
        runs = [(in_words(motion), len(list(run))) for motion, run in groupby(self._motions)]
        words = "; ".join(f"{text} ({times} times)" if times > 1 else text for text, times in runs)
        full = (
            f" At most {MOST_WAITING} commands can wait, so the last press was ignored."
            if self._refused
            else ""
        )
        return f"Then: {words}.{full}"


def in_words(motion: Motion) -> str:
    """Describe a motion in a few words.

    >>> in_words(Motion(0.2, 0.0))
    'Walk 0.20 m ahead'
    """
    parts = []
    if motion.distance:
        parts.append(f"Walk {abs(motion.distance):.2f} m {'ahead' if motion.distance > 0 else 'back'}")
    if motion.turn:
        parts.append(f"Turn {abs(np.degrees(motion.turn)):.0f}° {'left' if motion.turn > 0 else 'right'}")
    return ", ".join(parts) or "Stand still"
