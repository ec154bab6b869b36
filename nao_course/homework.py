"""A student's notebooks as files: updated to a newer release without losing work, and handed in."""

from __future__ import annotations

import hashlib
import io
import json
import shutil
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from nao_course._internal.lazy_names import list_public
from nao_course._internal.renamed_names import with_new_names
from nao_course._internal.student_folders import NOTEBOOKS, RELEASE
from nao_course._internal.text_encodings import decode_text
from nao_course.exercises.answered import notebooks_in
from nao_course.exercises.cells import cell_id, grade_id, is_solution, metadata, source_of
from nao_course.exercises.checking import lessons
from nao_course.exercises.notebook_text import LARGEST_HELPER, MOST_BYTES, MOST_HELPERS
from nao_course.exercises.versions import installed_versions

__all__ = ["NOTEBOOKS", "RELEASE", "REQUEST", "Receipt", "Renewal", "renew", "submit", "zipped"]
__dir__ = list_public(__name__)

REQUEST = "regrade_request.txt"  # in NOTEBOOKS: what a person should look at again
_GIVEN = ".given"  # in NOTEBOOKS: each lesson as released, to find the student's changes
_KEPT = "kept"  # in NOTEBOOKS: the student's notebooks before each renewal

_FIRST, _LAST = (datetime(year, 1, 1, tzinfo=UTC).timestamp() for year in (1980, 2107))  # in a zip

Cell = dict[str, Any]
Notebook = dict[str, Any]


def zipped(
    files: Mapping[str, bytes],
    modes: Mapping[str, int] | None = None,
    times: Mapping[str, float] | None = None,
) -> bytes:
    """Pack files into a zip archive whose bytes depend only on the arguments.

    Parameters
    ----------
    files : mapping of str to bytes
        Contents by the path in the archive.
    modes : mapping of str to int, optional
        Permissions of the files whose permissions are not 0o644.
    times : mapping of str to float, optional
        Times of files in seconds since 1970, which the archive holds in UTC; of the others, it is the year 1980.
    """
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _date((times or {}).get(name, 0.0)))
            entry.compress_type, entry.create_system = zipfile.ZIP_DEFLATED, 3  # permissions as on Unix
            entry.external_attr = (0o100000 | (modes or {}).get(name, 0o644)) << 16
            archive.writestr(entry, files[name])
    return packed.getvalue()


def _date(time: float) -> tuple[int, int, int, int, int, int]:
    """Return the date of a time within the years that a zip can hold."""
    year, month, day, *clock = datetime.fromtimestamp(min(max(time, _FIRST), _LAST), UTC).timetuple()[:6]
    return year, month, day, clock[0], clock[1], clock[2]


# --- handing in ---


@dataclass(frozen=True)
class Receipt:
    """The receipt of a submission.

    Parameters
    ----------
    path : Path
        The zip archive.
    time : str
        Time of the submission, UTC.
    files : mapping of str to str
        SHA-256 digest of each file by its name.
    versions : mapping of str to str
        Versions of the release, Python and libraries.
    code : str
        SHA-256 digest of the receipt: equal codes belong to the same submission.
    """

    path: Path
    time: str
    files: Mapping[str, str]
    versions: Mapping[str, str]
    code: str


def submit(folder: Path, out: Path) -> Receipt:
    """Pack a student's notebooks, with their copies, and helper files into a zip archive with a receipt.

    Parameters
    ----------
    folder : Path
        Folder of the notebooks.
    out : Path
        Folder for the archive.

    Returns
    -------
    Receipt
        The receipt, which is also in the archive as receipt.json.

    Raises
    ------
    ValueError
        If the folder contains no lesson's notebook, or a file is broken or too large.
    """
    if not folder.is_dir():
        raise ValueError(f"{folder} is not a folder: give submit the folder of your notebooks")
    found = [
        *sorted(each for copies in notebooks_in(folder, lessons()).values() for each in copies),
        *sorted(folder.glob("*.py")),
        folder / REQUEST,
    ]
    files = {path.name: path.read_bytes() for path in found if path.is_file() and not path.is_symlink()}
    notebooks = {
        name: _parsed(name, content) for name, content in files.items() if name.lower().endswith(".ipynb")
    }
    if not notebooks:
        raise ValueError(f"{folder} contains no notebook of a lesson, such as 01_hsl_filtering.ipynb")
    for name, content in files.items():
        if len(content) > MOST_BYTES:
            raise ValueError(
                f"{name} has {len(content) / 2**20:.0f} MB, but at most {MOST_BYTES // 2**20} MB are allowed: "
                "in JupyterLab choose Edit, Clear Outputs of All Cells, and save"
            )
    helpers = [name for name in files if name.endswith(".py")]
    if len(helpers) > MOST_HELPERS:
        raise ValueError(
            f"there are {len(helpers)} Python files beside the notebooks, but at most {MOST_HELPERS} are allowed: "
            "delete the files that your notebooks do not import"
        )
    if large := [name for name in helpers if len(files[name]) > LARGEST_HELPER]:
        raise ValueError(
            f"{large[0]} has {len(files[large[0]]) / 2**20:.1f} MB, "
            f"but a Python file may have at most {LARGEST_HELPER // 2**20} MB"
        )
    now = datetime.now(UTC)
    releases = {str(metadata(each, "nao_course").get("version", "unknown")) for each in notebooks.values()}
    time = now.isoformat(timespec="seconds")
    hashes = {name: hashlib.sha256(each).hexdigest() for name, each in files.items()}
    versions = {"release": ", ".join(sorted(releases))} | installed_versions()
    contents: dict[str, object] = {"time": time, "files": hashes, "versions": versions}
    code = hashlib.sha256(json.dumps(contents, sort_keys=True).encode()).hexdigest()
    path = out / f"submission-{now:%Y%m%d-%H%M%S}.zip"
    out.mkdir(parents=True, exist_ok=True)
    # Of several copies, the newest counts
    times = {each.name: each.stat().st_mtime for each in found if each.name in files}
    path.write_bytes(zipped(files | {"receipt.json": _json(contents | {"code": code})}, times=times))
    return Receipt(path, time, hashes, versions, code)


# --- a newer release ---


@dataclass(frozen=True)
class Renewal:
    """The renewal of a student's notebook by a release.

    Parameters
    ----------
    name : str
        Name of the notebook.
    carried : int
        Number of the student's cells that were carried over.
    kept : Path, optional
        Path of the copy of the old notebook.
    lost : tuple of str
        First lines of the student's cells that have no place in the new lesson; the copy still contains them.
    """

    name: str
    carried: int = 0
    kept: Path | None = None
    lost: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return the renewal as a sentence."""
        if self.kept is None:
            return f"{self.name}: as released"
        said = f"{self.name}: renewed with {self.carried} of your cells; your old notebook is in {self.kept}"
        missing = f". Not carried over: {', '.join(map(repr, self.lost))}" if self.lost else ""
        return said + missing


def renew(root: Path, release: Path | None = None) -> list[Renewal]:
    """Copy the lessons of an unpacked release to the student's folder without losing work.

    A notebook that the student has not changed is replaced. For a changed notebook a copy is kept, and the new notebook
    contains the student's answers (by the exercise), the cells that the student changed and the release did not, and
    the cells that the student added. Library names that the release has changed are replaced in the student's code.

    Parameters
    ----------
    root : Path
        The folder with `release` and `notebooks`.
    release : Path, optional
        The folder of the release, if it is elsewhere: on a JupyterHub, all students share one.

    Returns
    -------
    list of Renewal
        One renewal for each notebook that is new or has changed.

    Raises
    ------
    ValueError
        If there is no release, or a notebook of the release is broken.
    """
    mine, given = root / NOTEBOOKS, root / NOTEBOOKS / _GIVEN
    released = (release or root / RELEASE) / NOTEBOOKS
    if not released.is_dir():
        raise ValueError(
            f"there is no folder {released}: renew needs the folder in which the course's zip was unpacked. "
            "Change to that folder, or give its path: nao-course renew FOLDER"
        )
    done = []
    for source in sorted(released.glob("*.ipynb")):
        target, base = mine / source.name, given / source.name
        if target.is_file() and base.is_file() and base.read_bytes() == source.read_bytes():
            continue
        given.mkdir(parents=True, exist_ok=True)
        done.append(_bring(source, target, base))
        shutil.copyfile(source, base)
    images = released / "images"
    if images.is_dir():
        shutil.copytree(images, mine / "images", dirs_exist_ok=True)
    return done


def _bring(source: Path, target: Path, base: Path) -> Renewal:
    new = _parsed(source.name, source.read_bytes())  # a broken release must not replace anything
    before = _cells_or_none(base)
    own = _cells_or_none(target)
    if not target.is_file() or (own is not None and own in (before, _cells_or_none(source))):
        shutil.copyfile(source, target)
        return Renewal(target.name)
    kept = _keep(target)
    carried, lost = _carry_over(before, own or [], new["cells"])
    target.write_bytes(_json(new))
    return Renewal(target.name, carried, kept.relative_to(target.parent.parent), tuple(lost))


def _keep(path: Path) -> Path:
    """Copy a notebook into the folder of old notebooks under an unused name."""
    folder = path.parent / _KEPT
    folder.mkdir(exist_ok=True)
    number = 1
    while (kept := folder / f"{path.stem}-{number}.ipynb").exists():
        number += 1
    shutil.copy2(path, kept)
    return kept


def _carry_over(before: list[Cell] | None, own: list[Cell], new: list[Cell]) -> tuple[int, list[str]]:
    """Insert a student's cells into a new notebook; return their number and the first lines of the others."""
    given = {_key(cell): source_of(cell) for cell in before or new}
    key_of_text = {text.strip(): key for key, text in given.items()}
    exercises = {_key(cell): cell for cell in new if is_solution(cell)}
    unchanged = {source_of(cell): cell for cell in new if not is_solution(cell)}
    carried, lost, seen = 0, list[str](), set[str]()
    at = -1  # index in `new` of the student's last known cell
    for cell in own:
        key, source = _key(cell), source_of(cell)
        if key not in given:  # another program has dropped or replaced the cell's id
            key = key_of_text.get(source.strip(), key)
        added = key not in given or key in seen
        seen.add(key)
        home = exercises.get(key) or unchanged.get(given.get(key, ""))
        if home is not None and not added:
            at = next(i for i, each in enumerate(new) if each is home)
        if not source.strip() or source.strip() == given.get(key, "").strip() or _is_locked(cell):
            continue
        if added:
            held = cell.get("metadata", {})  # a copy of an exercise's cell is not an exercise
            cell["metadata"] = {key: held[key] for key in held if key not in ("nbgrader", "nao_course")}
            new.insert(at + 1, _blank(cell))
            at += 1
            _use_new_names(new[at])
        elif home is None or (before is None and not is_solution(home)):
            lost.append(source.strip().splitlines()[0][:60])
            continue
        else:
            home["source"] = cell["source"]
            _use_new_names(home)
        carried += 1
    return carried, lost


def _use_new_names(cell: Cell) -> None:
    """Replace library names of older releases in a code cell."""
    if cell["cell_type"] == "code":
        cell["source"] = with_new_names(source_of(cell))


def _blank(cell: Cell) -> Cell:
    return cell | ({"outputs": [], "execution_count": None} if cell["cell_type"] == "code" else {})


def _key(cell: Cell) -> str:
    return grade_id(cell) or cell_id(cell)


def _is_locked(cell: Cell) -> bool:
    return bool(metadata(cell, "nbgrader").get("locked"))


def _cells_or_none(path: Path) -> list[Cell] | None:
    """Return a notebook's cells without outputs; None if it is missing or broken."""
    try:
        cells = _parsed(path.name, path.read_bytes())["cells"]
    except (OSError, ValueError):
        return None
    return [_blank(cell) | {"source": source_of(cell)} for cell in cells]


def _parsed(name: str, content: bytes) -> Notebook:
    try:
        notebook: Notebook = json.loads(decode_text(content))
        for cell in notebook["cells"]:
            "".join(cell["source"]), cell["cell_type"], cell.get("metadata", {}).keys()
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise ValueError(f"{name} is not a notebook ({type(error).__name__}: {error})") from None
    return notebook


def _json(value: object) -> bytes:
    return (json.dumps(value, indent=1, ensure_ascii=False) + "\n").encode()
