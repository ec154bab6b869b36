"""One temporary folder for all that a run lays down, so that a run which was killed leaves nothing for long."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

_NAME = re.compile(r"nao_course_run_(\d+)_\w+")


@contextlib.contextmanager
def scratch_folder() -> Iterator[Path]:
    """Make a folder in which this process puts everything temporary, and take away those of runs that were killed.

    Yields
    ------
    Path
        The folder; it goes when the block ends.
    """
    usual = Path(tempfile.gettempdir())
    _sweep(usual)
    before = tempfile.tempdir
    with tempfile.TemporaryDirectory(
        prefix=f"nao_course_run_{os.getpid()}_", dir=usual, ignore_cleanup_errors=True
    ) as folder:
        tempfile.tempdir = folder
        try:
            yield Path(folder)
        finally:
            tempfile.tempdir = before


def _sweep(folder: Path) -> None:
    """Take away what processes of this user left that are gone. Windows does not tell whether one is."""
    if sys.platform == "win32":
        return
    for path in folder.iterdir():
        match = _NAME.fullmatch(path.name)
        with contextlib.suppress(OSError):
            if match and path.lstat().st_uid == os.getuid() and not _lives(int(match[1])):
                shutil.rmtree(path, ignore_errors=True)


def _lives(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True
