"""The layout of every panel: pictures as wide as the page allows, with the controls beside or below them."""

from __future__ import annotations

from typing import Any

from nao_course.widgets.parts import box, styles

BESIDE = 1.7  # width / height of all pictures together; controls are below pictures that are wider than that
# A panel is as wide as its cell, which JupyterLab's file list makes narrower, so the rules go by the panel's own width.
# Controls are beside a picture where there is room for 414 px of picture, a gap of 16 px and 330 px of controls, such
# as in JupyterLab with its list of files on a page of 1280 px; tall controls also beside a narrower picture. Below the
# pictures of a wide panel, the groups and the status share the width; in a narrower panel the status has its own line.
# Many controls (nao-wide) have a line above the others, unless these have small pictures and little width.
# --nao-tallest is the largest height of a picture, so that pictures and controls are on a laptop's screen together:
# --nao-most, or less in a low window, such as on an enlarged page, of which --nao-rest are for everything else.
_CSS = """
.nao-laid-out { container-type: inline-size; width: 100%; max-width: 1240px; overflow: visible; }
.nao-laid-out .nao-body { display: grid; grid-template-columns: minmax(0, 1fr); gap: 6px 16px; align-items: start;
  overflow: visible; margin: 0; width: 100%; --nao-most: 400px;
  --nao-rest: 330px; --nao-tallest: min(var(--nao-most), max(240px, var(--nao-screen, 100vh) - var(--nao-rest))); }
.nao-beside .nao-body { --nao-most: 440px; --nao-rest: 290px; }
.nao-laid-out .nao-main { overflow: visible; min-width: 0; }
.nao-laid-out .nao-side { gap: 6px 16px; flex-wrap: wrap; align-items: flex-start; overflow: visible; margin: 0; }
.nao-laid-out .nao-side > * { flex: 1 1 300px; max-width: 100%; margin: 0; overflow: visible; }
.nao-laid-out .nao-side :is(.nao-empty, .nao-group:not(:has(> :not(.nao-empty)))) { display: none; }
.nao-laid-out .nao-side > .nao-last, .nao-side:not(:has(> .nao-group img)) > .nao-wide { flex-basis: 100%; }
.nao-side:not(:has(> .nao-group img)) > .nao-wide ~ .nao-last { flex-basis: 300px; }
@container (min-width: 1000px) {
  :not(.nao-beside) > .nao-body > .nao-side > .nao-group { display: contents; }
  :not(.nao-beside) > .nao-body > .nao-side > .nao-group > * { flex: 1 1 300px; }
  :not(.nao-beside) > .nao-body > .nao-side > .nao-last { flex-basis: 300px; }
  :not(.nao-beside) > .nao-body > .nao-side > .nao-wide { flex-basis: 100%; }
}
""" + "".join(
    f"""@container (min-width: {width}px) {{
  {panel} .nao-body {{ --nao-most: 510px; --nao-rest: 150px;
    grid-template-columns: minmax(0, max-content) minmax(330px, 1fr); }}
  {panel} .nao-side {{ flex-flow: column; align-items: stretch; }}
  {panel} .nao-side > * {{ flex: 0 0 auto; }}
}}
"""
    for panel, width in ((".nao-beside", 760), (".nao-beside.nao-tall-side", 640))
)


def lay_out(css: str, main: Any, side: list[Any], *last: Any) -> Any:
    """Return a panel's box with the class ``nao-panel``, whose groups `place_beside` moves.

    `side` are groups of controls, tables and small pictures, which share the width below the pictures or stand under
    each other beside them; a group with the class ``nao-empty`` takes no place, and the parts of one with the class
    ``nao-group`` stand beside each other where there is room. `last` are the legend and the status after all of them.
    """
    main.add_class("nao-main")
    ending = box("V", "nao-last", *last)
    body = box("", "nao-body", main, box("", "nao-side", *side, ending))
    panel = box("V", "nao-panel", styles(_CSS + css), body)
    panel.add_class("nao-laid-out")
    return panel


def place_beside(panel: Any, ratio: float) -> None:
    """Set whether the groups are beside the pictures or, if these are wide, below: `ratio` is width / height."""
    switch(panel, "nao-beside", ratio < BESIDE)


def switch(widget: Any, name: str, holds: bool) -> None:
    """Give a widget a class, or take it away."""
    (widget.add_class if holds else widget.remove_class)(name)
