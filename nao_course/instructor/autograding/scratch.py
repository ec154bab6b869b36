"""One temporary folder for all that a run lays down, so that a run which was killed leaves nothing for long."""

import contextlib
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from nao_course.instructor.collecting.files import Files

_NAME = re.compile(r"nao_course_run_(\d+)_\w+")


@contextlib.contextmanager
def scratch_folder() -> Iterator[Path]:
    """Make a folder for all temporary files of this process, and delete the folders of killed runs.

    The folder is deleted when the block ends.
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


@contextlib.contextmanager
def laid_out(files: Files, lesson: str) -> Iterator[Path]:
    """Write a submission's files, as they were read and hashed, into a folder that is deleted in any case.

    Yield the path of the notebook; its helper files are beside it.
    """
    with tempfile.TemporaryDirectory(prefix="nao_course_", ignore_cleanup_errors=True) as folder:
        notebook = Path(folder, f"{lesson}.ipynb")
        notebook.write_bytes(files.notebook)
        for name, content in files.helpers.items():
            notebook.with_name(name).write_bytes(content)
        yield notebook


def _sweep(folder: Path) -> None:
    """Delete files of this user's processes that have ended. On Windows this cannot be determined."""
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
