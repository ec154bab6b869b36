"""A read-write lock: many may share it, and one may have it alone."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator


class ReadWriteLock:
    """Lets the calls of several submissions run side by side, and one alone: so that no time-out is another's fault.

    Who waits to have it alone goes before those who come to share it.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._sharing, self._taken = 0, False

    @contextlib.contextmanager
    def shared(self) -> Iterator[None]:
        """Run the block beside others, once nobody has the lock alone."""
        with self._changed:
            self._changed.wait_for(lambda: not self._taken)
            self._sharing += 1
        try:
            yield
        finally:
            with self._changed:
                self._sharing -= 1
                self._changed.notify_all()

    @contextlib.contextmanager
    def exclusive(self) -> Iterator[None]:
        """Run the block once all others have ended; none begins meanwhile."""
        with self._changed:
            self._changed.wait_for(lambda: not self._taken)
            self._taken = True
            self._changed.wait_for(lambda: not self._sharing)
        try:
            yield
        finally:
            with self._changed:
                self._taken = False
                self._changed.notify_all()
