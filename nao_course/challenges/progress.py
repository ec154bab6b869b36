"""A progress bar, which is shown only in a notebook or a terminal."""

from __future__ import annotations

import sys
import time
from typing import Any

PAUSE = 0.1  # s between two updates


class Progress:
    """A progress bar for a number of steps, named by a noun such as "scenes"."""

    def __init__(self, total: int, what: str) -> None:
        """Show an empty bar."""
        self.total, self.what, self.done = total, what, 0
        self._shown, self._over = time.monotonic(), False
        self._handle = _display(self._html(), self._text())

    def step(self) -> None:
        """Show that one more case is done."""
        self.done += 1
        if time.monotonic() - self._shown > PAUSE:
            self._show()

    def end(self) -> None:
        """Replace the bar by a line of text."""
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
    """An output with HTML for a notebook and plain text."""

    def __init__(self, html: str, text: str) -> None:
        self._html, self._text = html, text

    def _repr_html_(self) -> str:
        return self._html

    def __repr__(self) -> str:
        return self._text


def _display(html: str, text: str) -> Any:
    """Return a handle to an output of the notebook; None outside of a notebook."""
    ipython = sys.modules.get("IPython")  # IPython is always imported in a notebook
    shell = ipython.get_ipython() if ipython is not None else None
    if shell is None or not hasattr(shell, "kernel"):
        return None
    from IPython.display import display

    return display(_Html(html, text), display_id=True)
