"""The script that draws maps and plays films, and pages that play a film without Python."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

WEB = Path(__file__).with_name("web")


@cache
def script(*parts: str) -> str:
    """Return parts of the script, "map", "player" and "live", in this order; each uses those before it."""
    return "\n".join((WEB / f"{part}.js").read_text(encoding="utf-8") for part in parts)


@cache
def style_sheet() -> str:
    """Return the style sheet of maps and films."""
    return (WEB / "map.css").read_text(encoding="utf-8")


def film_html(film: Mapping[str, Any], fallback: str = "") -> str:
    """Return the element of a page in whose place the script puts a player.

    Parameters
    ----------
    film : mapping
        The data of a film.
    fallback : str
        HTML that is shown where scripts do not run, for example a picture.
    """
    # A "<" in a script's text may end the script ("</script>") or keep it from ending ("<!--<script>").
    data = json.dumps(film, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")
    return f'<div class="nao-film-here"><script type="application/json">{data}</script>{fallback}</div>'


def film_page(film: Mapping[str, Any]) -> str:
    """Return a page (HTML) that plays a film by itself: it needs no other file and no network."""
    title = html.escape(str(film["title"]))
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
:root {{ color-scheme: light dark; }}
body {{ margin: 1.5em auto; padding: 0 1em; max-width: 62em; font-family: system-ui, sans-serif; }}
{style_sheet()}</style>
</head>
<body>
<h1>{title}</h1>
{film_html(film)}
<script>
{script("map", "player")}
NaoFilm.startPage();
</script>
</body>
</html>
"""
