"""Names that students' notebooks may still use although this release calls them something else."""

from __future__ import annotations

import re

__all__ = ["RENAMED", "with_new_names"]

# The old name and the new one. A name that begins with a dot is replaced only where it is an attribute, because
# students may have variables of that name.
RENAMED = {
    "FieldOdometry": "OdometryNoisePerMove",
    "whole_picture": "joint_update",
    "WholePicture": "JointUpdate",
    "lean_from_lines": "estimate_body_tilt",
    ".about": ".linearised_at",
    ".apart": ".decorrelated",
}
_WORDS = re.compile(
    "|".join(("" if old.startswith(".") else r"\b") + re.escape(old) + r"\b" for old in RENAMED)
)


def with_new_names(source: str) -> str:
    """Replace the old names in a piece of Python code by the new ones."""
    return _WORDS.sub(lambda found: RENAMED[found.group()], source)
