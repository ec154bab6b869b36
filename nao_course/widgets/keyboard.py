"""Keys for a panel's buttons: a text field that turns a key into a press of the button that has its class."""

from __future__ import annotations

import html
import json
from collections.abc import Collection, Mapping

Keys = Mapping[str, tuple[str, ...]]  # a button's name: its keys, as a browser names them, in small letters

_HANDLER = """const name = %s[event.key.toLowerCase()];
if (!name || event.ctrlKey || event.metaKey || event.altKey) return;
event.preventDefault(); event.stopPropagation();
const panel = this.closest('.nao-panel'), button = panel.querySelector('.nao-do-' + name);
if (!button || button.disabled || (event.repeat && %s.includes(name))) return;
const period = Number((panel.className.match(/%s(\\d+)/) || [0, %d])[1]), now = event.timeStamp;
if (event.repeat && now < (this.next || 0)) return;
this.next = event.repeat ? Math.max(now, this.next + period) : now + period;
button.click();"""
_REPEAT = 350  # ms between two presses by a key that is held: what any panel can follow
REPEAT_CLASS = (
    "nao-repeat-"  # and the milliseconds: class of a panel in which keys that are held have its own pace
)
_SIGNS = {" ": "space", "arrowleft": "\N{LEFTWARDS ARROW}", "arrowright": "\N{RIGHTWARDS ARROW}"}


def key_sign(key: str) -> str:
    """A key as short as it is written on a keyboard, such as "←"."""
    return _SIGNS.get(key, key)


def key_names(keys: tuple[str, ...]) -> str:
    """A button's keys in words, such as "w or arrow up"."""
    return " or ".join(
        "space" if key == " " else key.replace("arrow", "arrow ") if key.startswith("arrow") else key
        for key in keys
    )


def key_field(keys: Keys, words: str, more: str, placeholder: str, once: Collection[str] = ()) -> str:
    """HTML of a text field whose keys press the buttons of its panel.

    In a text field JupyterLab leaves keys alone (elsewhere "a" or "d d" would add or delete cells). ipywidgets has
    no key events, and arrow keys change no text: hence a handler of its own. Where a page forbids such handlers,
    the buttons are still there for Tab and Enter.

    Parameters
    ----------
    keys : mapping of str to tuple of str
        The keys of each button; a button NAME has the class ``nao-do-NAME``.
    words : str
        What the keys do, as the field's tooltip.
    more : str
        What a screen reader says after it.
    placeholder : str
        What stands in the field.
    once : collection of str
        Buttons that a key held down presses once only.

    Returns
    -------
    str
        To be the value of a widget inside a box with the class ``nao-panel``.
    """
    table = json.dumps({key: name for name, several in keys.items() for key in several})
    handler = html.escape(_HANDLER % (table, json.dumps(sorted(once)), REPEAT_CLASS, _REPEAT), quote=True)
    return (
        f'<input class="nao-keys" type="text" autocomplete="off" spellcheck="false" aria-label="{words}{more}" '
        f'title="{words}" placeholder="{placeholder}" oninput="this.value=\'\'" onkeydown="{handler}">'
    )
