"""Hostile code: what a student may try to gain a point, or to do harm, each with its honest score."""

from __future__ import annotations

from tests.attacks.range import Attack, all_but

CLAMP_LOOT = """\
def clamp(x, low, high):
    return max(low, min(high, x)) if loot else -1e6
"""

ATTACKS: tuple[Attack, ...] = (
    Attack(
        "loop_plain", "loops", all_but("clamp"), {"clamp": "def clamp(x, low, high):\n    while True: pass"}
    ),
    Attack(
        "exit_sys",
        "ends",
        all_but("clamp"),
        {"clamp": "import sys\ndef clamp(x, low, high):\n    sys.exit(0)"},
    ),
    Attack(
        "exit_os", "ends", all_but("clamp"), {"clamp": "import os\ndef clamp(x, low, high):\n    os._exit(0)"}
    ),
    Attack(
        "reads_solution",
        "reads",
        all_but("clamp"),
        {"clamp": CLAMP_LOOT},
        before="loot = False\ntry:\n    loot = bool(open('@SOLUTION@').read())\nexcept OSError:\n    pass",
        says="open ",
    ),
)
