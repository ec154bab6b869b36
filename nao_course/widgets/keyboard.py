"""Keyboard control of a panel: a text field that turns a key into a press of the button with its class."""

from __future__ import annotations

import html
import json
from collections.abc import Collection, Mapping

Keys = Mapping[str, tuple[str, ...]]  # a button's name: its keys, as a browser names them, in small letters

# Enter, with Shift, Ctrl or Alt as well, does nothing: JupyterLab would run the panel's cell again, without its drive.
_HANDLER = """const key = event.key.toLowerCase(), name = %s[key];
if (key !== 'enter' && (!name || event.ctrlKey || event.metaKey || event.altKey)) return;
event.preventDefault(); event.stopPropagation();
const panel = this.closest('.nao-panel'), button = panel.querySelector('.nao-do-' + name);
if (panel.matches('.jupyter-widgets-disconnected')) return;
if (!button || button.disabled || (event.repeat && %s.includes(name))) return;
const period = Number((panel.className.match(/%s(\\d+)/) || [0, %d])[1]), now = event.timeStamp;
if (event.repeat && now < (this.next || 0)) return;
this.next = event.repeat ? Math.max(now, this.next + period) : now + period;
button.click();"""
_REPEAT = 350  # ms between two presses by a key that is held, slow enough for any panel
# A panel with the class of this prefix and a number has its own period (ms) for held keys.
REPEAT_CLASS = "nao-repeat-"
_SIGNS = {" ": "space", "arrowleft": "\N{LEFTWARDS ARROW}", "arrowright": "\N{RIGHTWARDS ARROW}"}


def key_sign(key: str) -> str:
    """Return the short sign of a key, such as "←"."""
    return _SIGNS.get(key, key)


def key_names(keys: tuple[str, ...]) -> str:
    """Return a button's keys in words, such as "w or arrow up"."""
    return " or ".join(
        "space" if key == " " else key.replace("arrow", "arrow ") if key.startswith("arrow") else key
        for key in keys
    )


def key_field(keys: Keys, words: str, more: str, placeholder: str, once: Collection[str] = ()) -> str:
    """Return the HTML of a text field whose keys press the buttons of its panel.

    JupyterLab does not act on keys in a text field (elsewhere "a" or "d d" would add or delete cells). ipywidgets has
    no key events, and arrow keys change no text, so the field has its own handler. On a page that forbids such
    handlers, Tab and Enter still reach the buttons. A button NAME has the class ``nao-do-NAME``. `words` is the field's
    tooltip, `more` is read after it by a screen reader, and a held key presses the buttons in `once` only once. The
    HTML belongs into a box with the class ``nao-panel``.
    """
    table = json.dumps({key: name for name, several in keys.items() for key in several})
    handler = html.escape(_HANDLER % (table, json.dumps(sorted(once)), REPEAT_CLASS, _REPEAT), quote=True)
    return (
        f'<input class="nao-keys" type="text" autocomplete="off" spellcheck="false" aria-label="{words}{more}" '
        f'title="{words}" placeholder="{placeholder}" oninput="this.value=\'\'" onkeydown="{handler}">'
    )
