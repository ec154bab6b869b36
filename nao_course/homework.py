"""A student's notebooks as files: renewed by a newer release without losing work, and handed in."""

from __future__ import annotations

import hashlib
import io
import json
import platform
import shutil
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from nao_course.exercises import lesson_names
from nao_course.exercises.cells import grade_id, is_solution, metadata, source_of
from nao_course.exercises.definitions import LARGEST_HELPER, MOST_BYTES, MOST_HELPERS

__all__ = ["NOTEBOOKS", "RELEASE", "Receipt", "Renewal", "installed_versions", "renew", "submit", "zipped"]

RELEASE = Path("release")  # where an unpacked release lies; nobody works in it
NOTEBOOKS = Path("notebooks")  # where a student works; no release brings a file for it
_GIVEN = ".given"  # in NOTEBOOKS: each lesson as it was given, to see what the student did
_KEPT = "kept"  # in NOTEBOOKS: the student's notebooks as they were before a renewal
_VERSIONS = ("nao-course", "numpy", "opencv-python-headless", "scipy")

Cell = dict[str, Any]
Notebook = dict[str, Any]


def zipped(files: Mapping[str, bytes], modes: Mapping[str, int] | None = None) -> bytes:
    """Pack files into a zip that is the same for the same files.

    Parameters
    ----------
    files : mapping of str to bytes
        Contents by the path in the zip.
    modes : mapping of str to int, optional
        Permissions of those that are not 0o644.
    """
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name)  # its date is 1980, always
            entry.compress_type, entry.create_system = zipfile.ZIP_DEFLATED, 3  # permissions as on Unix
            entry.external_attr = (0o100000 | (modes or {}).get(name, 0o644)) << 16
            archive.writestr(entry, files[name])
    return packed.getvalue()


# --- handing in ---


@dataclass(frozen=True)
class Receipt:
    """What was handed in, and when.

    Parameters
    ----------
    path : Path
        The zip.
    time : str
        In UTC.
    files : mapping of str to str
        SHA-256 of each file by its name.
    versions : mapping of str to str
        Of the release, Python and libraries.
    code : str
        SHA-256 of all of this: two receipts with one code are of the same work.
    """

    path: Path
    time: str
    files: Mapping[str, str]
    versions: Mapping[str, str]
    code: str


def submit(folder: Path, out: Path) -> Receipt:
    """Pack a student's notebooks, and the helper files beside them, with a receipt.

    Parameters
    ----------
    folder : Path
        Where the notebooks are.
    out : Path
        Folder for the zip.

    Returns
    -------
    Receipt
        Also in the zip, as receipt.json.

    Raises
    ------
    ValueError
        If there is no lesson's notebook, or a file is broken or too large.
    """
    if not folder.is_dir():
        raise ValueError(f"{folder} is no folder: submit packs a folder of notebooks")
    found = [*sorted(folder.glob(f"{lesson_names.PATTERN}.ipynb")), *sorted(folder.glob("*.py"))]
    files = {path.name: path.read_bytes() for path in found if path.is_file() and not path.is_symlink()}
    notebooks = {name: _parsed(name, content) for name, content in files.items() if name.endswith(".ipynb")}
    if not notebooks:
        raise ValueError(f"no lesson's notebook (such as 01_hsl_filtering.ipynb) in {folder}")
    for name, content in files.items():
        if len(content) > MOST_BYTES:
            raise ValueError(
                f"{name} has {len(content) / 2**20:.0f} MB, {MOST_BYTES // 2**20} are the most: "
                "in JupyterLab choose Edit, Clear Outputs of All Cells, and save"
            )
    helpers = [name for name in files if name.endswith(".py")]
    if len(helpers) > MOST_HELPERS:
        raise ValueError(
            f"{len(helpers)} Python files are beside the notebooks, {MOST_HELPERS} are the most: "
            "move away what the notebooks do not import"
        )
    if large := [name for name in helpers if len(files[name]) > LARGEST_HELPER]:
        raise ValueError(
            f"{large[0]} has {len(files[large[0]]) / 2**20:.1f} MB, "
            f"{LARGEST_HELPER // 2**20} MB is the most for a Python file"
        )
    now = datetime.now(UTC)
    releases = {str(metadata(each, "nao_course").get("version", "unknown")) for each in notebooks.values()}
    time = now.isoformat(timespec="seconds")
    hashes = {name: hashlib.sha256(each).hexdigest() for name, each in files.items()}
    versions = {"release": ", ".join(sorted(releases))} | installed_versions()
    told: dict[str, object] = {"time": time, "files": hashes, "versions": versions}
    code = hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()
    path = out / f"submission-{now:%Y%m%d-%H%M%S}.zip"
    out.mkdir(parents=True, exist_ok=True)
    path.write_bytes(zipped(files | {"receipt.json": _json(told | {"code": code})}))
    return Receipt(path, time, hashes, versions, code)


def installed_versions() -> dict[str, str]:
    """Return the versions of Python and of what a lesson's numbers depend on."""
    found = {"python": platform.python_version()}
    for name in _VERSIONS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # OpenCV comes under several names
            continue
    return found


# --- a newer release ---


@dataclass(frozen=True)
class Renewal:
    """What a release did to a student's notebook.

    Parameters
    ----------
    name : str
        Of the notebook.
    carried : int
        How many cells of the student's were carried over.
    kept : Path, optional
        Where the notebook is kept as it was.
    lost : tuple of str
        Beginnings of the student's cells that the new lesson has no place for; they are in the kept notebook.
    """

    name: str
    carried: int = 0
    kept: Path | None = None
    lost: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Say it in a sentence."""
        if self.kept is None:
            return f"{self.name}: as released"
        said = f"{self.name}: renewed, {self.carried} of your cells carried over; it was kept as {self.kept}"
        missing = f". The new lesson has no place for: {', '.join(map(repr, self.lost))}" if self.lost else ""
        return said + missing


def renew(root: Path) -> list[Renewal]:
    """Bring the lessons of an unpacked release to where the student works.

    A notebook that the student has not touched is replaced. One that was changed is kept as it was, and in the new one
    stand the student's answers (by the exercise), the text and code cells the student changed where the release did
    not change them too, and the cells the student added.

    Parameters
    ----------
    root : Path
        The folder with `release` and `notebooks`.

    Returns
    -------
    list of Renewal
        For each notebook that is new or newer.
    """
    mine, given = root / NOTEBOOKS, root / NOTEBOOKS / _GIVEN
    done = []
    for source in sorted((root / RELEASE / NOTEBOOKS).glob("*.ipynb")):
        target, base = mine / source.name, given / source.name
        if target.is_file() and base.is_file() and base.read_bytes() == source.read_bytes():
            continue
        given.mkdir(parents=True, exist_ok=True)
        done.append(_bring(source, target, base))
        shutil.copyfile(source, base)
    images = root / RELEASE / NOTEBOOKS / "images"
    if images.is_dir():
        shutil.copytree(images, mine / "images", dirs_exist_ok=True)
    return done


def _bring(source: Path, target: Path, base: Path) -> Renewal:
    new = _parsed(source.name, source.read_bytes())  # a broken release replaces nothing
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
    """Copy a notebook beside the others, under a name that nothing has yet."""
    folder = path.parent / _KEPT
    folder.mkdir(exist_ok=True)
    number = 1
    while (kept := folder / f"{path.stem}-{number}.ipynb").exists():
        number += 1
    shutil.copy2(path, kept)
    return kept


def _carry_over(before: list[Cell] | None, own: list[Cell], new: list[Cell]) -> tuple[int, list[str]]:
    """Put a student's cells into a new notebook's; return how many, and those that found no place."""
    given = {_key(cell): source_of(cell) for cell in before or new}
    exercises = {_key(cell): cell for cell in new if is_solution(cell)}
    unchanged = {source_of(cell): cell for cell in new if not is_solution(cell)}
    carried, lost, seen = 0, list[str](), set[str]()
    at = -1  # in `new`: where the student's last known cell stands
    for cell in own:
        key, source = _key(cell), source_of(cell)
        added = key not in given or key in seen
        seen.add(key)
        home = exercises.get(key) or unchanged.get(given.get(key, ""))
        if home is not None and not added:
            at = next(i for i, each in enumerate(new) if each is home)
        if not source.strip() or source == given.get(key) or _is_locked(cell):
            continue
        if added:
            cell["metadata"].pop("nbgrader", None)  # a copy of an exercise's cell is no exercise
            cell["metadata"].pop("nao_course", None)
            new.insert(at + 1, _blank(cell))
            at += 1
        elif home is None or (before is None and not is_solution(home)):
            lost.append(source.strip().splitlines()[0][:60])
            continue
        else:
            home["source"] = cell["source"]
        carried += 1
    return carried, lost


def _blank(cell: Cell) -> Cell:
    return cell | ({"outputs": [], "execution_count": None} if cell["cell_type"] == "code" else {})


def _key(cell: Cell) -> str:
    return grade_id(cell) or str(cell.get("id", ""))


def _is_locked(cell: Cell) -> bool:
    return bool(metadata(cell, "nbgrader").get("locked"))


def _cells_or_none(path: Path) -> list[Cell] | None:
    """A notebook's cells without outputs; nothing where it is missing or broken."""
    try:
        cells = _parsed(path.name, path.read_bytes())["cells"]
    except (OSError, ValueError):
        return None
    return [_blank(cell) | {"source": source_of(cell)} for cell in cells]


def _parsed(name: str, content: bytes) -> Notebook:
    try:
        notebook: Notebook = json.loads(content)
        for cell in notebook["cells"]:
            "".join(cell["source"]), cell["cell_type"], cell.get("metadata", {}).keys()
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise ValueError(f"{name} is not a notebook ({type(error).__name__}: {error})") from None
    return notebook


def _json(value: object) -> bytes:
    return (json.dumps(value, indent=1, ensure_ascii=False) + "\n").encode()


def __dir__() -> list[str]:
    """What tab completion shows: not what this module imports."""
    return __all__
