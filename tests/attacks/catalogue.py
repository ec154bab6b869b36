"""What each hostile submission is after, and which of them are graded at lower levels, too."""

from tests.attacks.code import ATTACKS

# By the row of the table of attacks and accidents.
KINDS = (
    dict.fromkeys(("loops", "ends", "hogs"), "denial")
    | dict.fromkeys(("writes", "signals"), "harm")
    | dict.fromkeys(("patches", "answers", "earlier", "metadata"), "gain")
    | dict.fromkeys(("reads", "looks", "network"), "leak")
    | dict.fromkeys(("large", "broken", "styles", "honest"), "odd files and work")
)
HOSTILE = tuple(each for each in ATTACKS if KINDS[each.row] in ("denial", "harm", "gain", "leak"))
# What is graded at lower levels: all that depends on the layers of the sandbox, and every fifth of the rest.
_LAYERED = {"hogs", "writes", "signals", "reads", "looks", "network"}
_REST = [each.name for each in HOSTILE if each.row not in _LAYERED]
AT_LOWER_LEVELS = tuple(each for each in HOSTILE if each.row in _LAYERED or each.name in _REST[::5])
