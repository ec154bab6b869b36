"""A progress bar: in a notebook, in a terminal, and nowhere else."""

from __future__ import annotations

import sys
import time
from typing import Any

PAUSE = 0.1  # s between two updates


class Progress:
    """Says how much of something is done.

    Parameters
    ----------
    total : int
        How many steps there are.
    what : str
        What they are, such as "scenes".
    """

    def __init__(self, total: int, what: str) -> None:
        """Show an empty bar."""
        self.total, self.what, self.done = total, what, 0
        self._shown, self._over = time.monotonic(), False
        self._handle = _display(self._html(), self._text())

    def step(self) -> None:
        """One more is done."""
        self.done += 1
        if time.monotonic() - self._shown > PAUSE:
            self._show()

    def end(self) -> None:
        """There is no more to come: leave what was done as a line of text."""
        self._over = True
        self._show()

    def _show(self) -> None:
        self._shown = time.monotonic()
        if self._handle is not None:
            self._handle.update(_Html(self._html(), self._text()))
        elif sys.stderr is not None and sys.stderr.isatty():
            end = "\n" if self._over else ""
            print(f"\r{self._text()}", end=end, file=sys.stderr, flush=True)  # noqa: T201 - for a person who waits

    def _text(self) -> str:
        return f"{self.done} of {self.total} {self.what}"

    def _html(self) -> str:
        if self._over:
            return f"<small>{self._text()}</small>"
        return (
            f'<progress aria-label="{self.what}" value="{self.done}" max="{self.total}"></progress> '
            f"<small>{self._text()}</small>"
        )


class _Html:
    """HTML for a notebook, and its words."""

    def __init__(self, html: str, text: str) -> None:
        self._html, self._text = html, text

    def _repr_html_(self) -> str:
        return self._html

    def __repr__(self) -> str:
        return self._text


def _display(html: str, text: str) -> Any:
    """A handle to what a notebook shows; None where there is no notebook."""
    ipython = sys.modules.get("IPython")  # nobody has a notebook open who has not imported it
    shell = ipython.get_ipython() if ipython is not None else None
    if shell is None or not hasattr(shell, "kernel"):
        return None
    from IPython.display import display

    return display(_Html(html, text), display_id=True)
