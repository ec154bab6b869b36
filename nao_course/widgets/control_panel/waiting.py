"""Commands that wait while the robot still drives: a few, in the order in which they came."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from itertools import groupby

import numpy as np

from nao_course.slam import Motion

MOST_WAITING = 6  # commands; more are no quick taps any longer


class WaitingMotions:
    """A queue of motions that says what is in it."""

    def __init__(self, by_itself: Callable[[], Motion | None] = lambda: None) -> None:
        """Begin with none; `by_itself` says what comes where none waits, while `itself` is set."""
        self._motions: deque[Motion] = deque()
        self._refused = False
        self._by_itself, self.itself = by_itself, False

    def add(self, motion: Motion) -> None:
        """Let a motion wait its turn; where too many do, it is left out, and `said` says so."""
        self._refused = len(self._motions) >= MOST_WAITING
        if not self._refused:
            self._motions.append(motion)

    def take(self) -> Motion | None:
        """Take the oldest out; None where there is none, and the robot does not go by itself."""
        self._refused = False
        if self._motions:
            return self._motions.popleft()
        motion = self._by_itself() if self.itself else None
        self.itself = motion is not None and bool(motion.distance or motion.turn)
        return motion if self.itself else None

    def clear(self) -> None:
        """Forget them all, and go by itself no longer."""
        self._motions.clear()
        self._refused = self.itself = False

    def said(self) -> str:
        """Say what waits, equal motions in a row at once; empty where nothing does."""
        if not self._motions:
            return ""
        runs = [(in_words(motion), len(list(run))) for motion, run in groupby(self._motions)]
        words = "; ".join(f"{text} ({times} times)" if times > 1 else text for text, times in runs)
        full = f" No more than {MOST_WAITING} can wait: the last press was left out." if self._refused else ""
        return f"Then: {words}.{full}"


def in_words(motion: Motion) -> str:
    """A command in a few words.

    Examples
    --------
    >>> in_words(Motion(0.2, 0.0))
    'Walk 0.20 m ahead'
    """
    parts = []
    if motion.distance:
        parts.append(f"Walk {abs(motion.distance):.2f} m {'ahead' if motion.distance > 0 else 'back'}")
    if motion.turn:
        parts.append(f"Turn {abs(np.degrees(motion.turn)):.0f}° {'left' if motion.turn > 0 else 'right'}")
    return ", ".join(parts) or "Stand still"
