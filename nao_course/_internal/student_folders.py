"""The folders in which a student's copy is unpacked and worked on."""

from __future__ import annotations

from pathlib import Path

__all__ = ["NOTEBOOKS", "RELEASE"]

RELEASE = Path("release")  # folder of an unpacked release, which is never edited
NOTEBOOKS = Path("notebooks")  # the student's working folder, which no release contains
