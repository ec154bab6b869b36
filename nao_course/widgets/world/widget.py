"""The widget that draws a scene in the browser."""

from __future__ import annotations

from pathlib import Path

import anywidget
import traitlets

BUNDLE = Path(__file__).parent / "static" / "world.js"  # made from web/world by `make bundles`


class WorldWidget(anywidget.AnyWidget):
    """The state that Python and the browser share: the scene once, and what changes in small messages."""

    _esm = BUNDLE
    scene = traitlets.Dict().tag(sync=True)
    size = traitlets.List([640, 400]).tag(sync=True)
    source = traitlets.Unicode("ekf").tag(sync=True)
    contents = traitlets.Dict().tag(sync=True)
    trails = traitlets.Dict().tag(sync=True)
    top = traitlets.Bytes().tag(sync=True)  # JPEG files
    bottom = traitlets.Bytes().tag(sync=True)
    viewpoint = traitlets.Dict().tag(sync=True)
    summary = traitlets.Unicode().tag(sync=True)
    hint = traitlets.Unicode(
        "Drag to turn, or use the arrow keys; + and \N{MINUS SIGN} zoom, as does the mouse wheel from a click "
        "until Escape; 1, 2, 3 choose a view."
    ).tag(sync=True)
    estimate_name = traitlets.Unicode("").tag(sync=True)  # for the legend; by default the source's name
    needs_still = traitlets.Bool(False).tag(sync=True)  # a browser without WebGL shows pictures
    still = traitlets.Bytes().tag(sync=True)
