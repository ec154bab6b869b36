"""Panels whose picture is a view of the world."""

from __future__ import annotations

from typing import Any

from nao_course.plotting import Drawing
from nao_course.widgets.function_panel import FunctionPanel, Show
from nao_course.widgets.parts import box
from nao_course.widgets.player import PlayerPanel
from nao_course.widgets.world.view import WorldView, drawing_of


class WorldPanel(FunctionPanel):
    """A view of the world with controls.

    Parameters
    ----------
    title : str
        Title for texts and screen readers.
    world : WorldView
        The view.
    show : callable
        ``show(values, student)`` calls ``world.update(...)``, and returns or yields texts and tables as for a
        `FunctionPanel`.
    *controls, **options
        Further arguments of `FunctionPanel`.
    """

    css = """
.nao-function .nao-world-main { overflow: visible; align-items: stretch; }
@container (max-width: 860px) {
  .nao-beside .nao-body:has(> .nao-world-main) { grid-template-columns: minmax(0, 1fr); }
}
"""

    def __init__(self, title: str, world: WorldView, show: Show, *controls: Any, **options: Any) -> None:
        """Build the widgets, and show the results for the first values."""
        self.world = world
        super().__init__(title, show, *controls, **options)

    def summary(self) -> str:
        """Return the controls' values, the results and the contents of the view as text."""
        return f"{super().summary()}\n{self.world.summary()}"

    def drawing(self) -> Drawing:
        """Return the view as a figure, for places without widgets."""
        return drawing_of(self.world.pixels, f"{self.title}: {'; '.join(self.summary().splitlines())}")

    def _build(self) -> None:
        """Put the view above the pictures."""
        super()._build()
        (body,) = self.widget.children[1:]
        pictures, *others = body.children
        main = box("V", "nao-world-main", self.world.widget, pictures)
        main.add_class("nao-main")
        body.children = (main, *others)


class WorldPlayer(WorldPanel, PlayerPanel):
    """A view of the world with a slider that plays; `PlayerPanel` describes `controls` and `options`."""
