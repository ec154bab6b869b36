"""A student's notebook as other programs save it: what they add to it, and what they drop.

The forms follow the programs' published sources and the structure of files in public repositories. Where these do not
show that a program keeps something, it is dropped.
"""

import json
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Cell = dict[str, Any]
Notebook = dict[str, Any]

PYTHON = {
    "codemirror_mode": {"name": "ipython", "version": 3},
    "file_extension": ".py",
    "mimetype": "text/x-python",
    "name": "python",
    "nbconvert_exporter": "python",
    "pygments_lexer": "ipython3",
    "version": "3.11.7",
}
PRINTED = {"output_type": "stream", "name": "stdout", "text": ["1\n", "2"]}


@dataclass(frozen=True)
class FrontEnd:
    """A program: how it saves a notebook, and the name of the file that a student then has."""

    save: Callable[[Notebook], Notebook]
    indent: int = 1
    file: Callable[[str], str] = "{}.ipynb".format

    def write(self, folder: Path, lesson: str, content: bytes) -> Path:
        """Write a lesson's notebook, given as the release or JupyterLab saves it."""
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / self.file(lesson)
        text = json.dumps(self.save(json.loads(content)), indent=self.indent, ensure_ascii=False)
        path.write_text(text + "\n", encoding="utf-8")
        return path


def code(source: str, **metadata: Any) -> Cell:
    """Return a code cell that the student or the program adds."""
    return {
        "cell_type": "code",
        "metadata": metadata,
        "source": source,
        "outputs": [],
        "execution_count": None,
    }


def lines(cell: Cell) -> list[str]:
    """Return a cell's text as most programs store it."""
    return "".join(cell["source"]).splitlines(keepends=True)


def run(cells: list[Cell]) -> list[Cell]:
    """Let each code cell have run and printed something."""
    ran = [cell for cell in cells if cell["cell_type"] == "code"]
    for number, cell in enumerate(ran, start=1):
        cell |= {"execution_count": number, "outputs": [deepcopy(PRINTED)]}
    return cells


def hexadecimal(number: int, digits: int = 8) -> str:
    """Return an identifier of the kind that programs make up."""
    return f"{(number + 1) * 0x9E3779B97F4A7C15 % 16**digits:0{digits}x}"


def notebook_7(notebook: Notebook) -> Notebook:
    """Keep everything; the property inspector leaves empty values behind."""
    # Notebook 7.5 and JupyterLab 4.5, which have one document model: from their sources and from files of theirs.
    for cell in run(notebook["cells"]):
        cell["metadata"] |= {"tags": [], "slideshow": {"slide_type": ""}, "scrolled": True}
        cell["metadata"].setdefault("editable", True)
        cell["source"] = lines(cell)
    notebook["metadata"] |= {
        "kernelspec": {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"},
        "language_info": PYTHON,
    }
    return notebook


def shared_editing(notebook: Notebook) -> Notebook:
    """Keep everything, and store which code cells are trusted."""
    # jupyter-collaboration 4 with jupyter_ydoc 3: from the source of YNotebook.
    notebook = notebook_7(notebook)
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            cell["metadata"]["trusted"] = True
    return notebook


def doubled(notebook: Notebook) -> Notebook:
    """Repeat all cells; nbformat gives the copies identifiers of their own."""
    # jupyter-collaboration up to 4, after a reconnection: from reports in its repository of 2022 to 2026.
    notebook = shared_editing(notebook)
    copies = deepcopy(notebook["cells"])
    for number, cell in enumerate(copies):
        cell["id"] = hexadecimal(number)
    notebook["cells"] += copies
    return notebook


def vs_code(notebook: Notebook) -> Notebook:
    """Keep metadata and identifiers, sort all keys, and write the whole version string of a Windows Python."""
    # VS Code 1.7x to 1.9x: from the serialiser of its extension "ipynb", and from files of 2022 to 2025.
    notebook["cells"].insert(0, code("%pip install nao-course", vscode={"languageId": "python"}))
    for number, cell in enumerate(run(notebook["cells"])):
        cell["source"] = lines(cell)
        cell.setdefault("id", hexadecimal(number))
    version = "3.11.7 (tags/v3.11.7:fa7a6f2, Dec  4 2023, 19:24:49) [MSC v.1937 64 bit (AMD64)]"
    notebook["metadata"] |= {
        "kernelspec": {"display_name": ".venv (3.11.7)", "language": "python", "name": "python3"},
        "language_info": PYTHON | {"version": version},
        "orig_nbformat": 4,
        "vscode": {"interpreter": {"hash": "0" * 64}},
    }
    return json.loads(json.dumps(notebook, sort_keys=True))


def pycharm(notebook: Notebook) -> Notebook:
    """Add marks and times to the metadata, end each cell with an empty line, and name Python 2 as the language."""
    # PyCharm and DataSpell 2022 to 2025: from files, and from a report of changed cells (JetBrains' DS-3228).
    cells = notebook["cells"]
    cells.append(code(""))
    for number, cell in enumerate(run(cells)):
        cell.setdefault("id", hexadecimal(number, 16))
        mark = "#%%\n" if cell["cell_type"] == "code" else "#%% md\n"
        times = {"start_time": "2025-01-29T14:54:00.761223Z", "end_time": "2025-01-29T14:54:06.650315Z"}
        cell["metadata"] |= {"collapsed": False, "pycharm": {"name": mark}, "ExecuteTime": times}
        cell["source"] = [*lines(cell), "\n"]
    notebook["metadata"]["language_info"] = PYTHON | {
        "codemirror_mode": {"name": "ipython", "version": 2},
        "pygments_lexer": "ipython2",
        "version": "2.7.6",
    }
    return notebook


def colab(notebook: Notebook) -> Notebook:
    """Move identifiers into the metadata, drop the language, and put a badge first; other metadata stay."""
    # Google Colab 2023 to 2025: from files, one of them with the metadata of nbgrader.
    mount = (
        "from google.colab import drive\ndrive.mount('/content/drive')\n%cd /content/drive/MyDrive/nao_course"
    )
    cells = [code("!pip install -q nao-course"), code(mount), *notebook["cells"]]
    for number, cell in enumerate(run(cells)):
        cell["metadata"]["id"] = cell.pop("id", None) or hexadecimal(number, 12)
        if cell["cell_type"] == "code":
            cell["metadata"] |= {
                "colab": {"base_uri": "https://localhost:8080/", "height": 35},
                "outputId": f"{hexadecimal(number)}-0000-4000-8000-{hexadecimal(number, 12)}",
            }
        cell["source"] = lines(cell)
    address = "https://colab.research.google.com"
    badge = (
        f'<a href="{address}/github/a/b" target="_parent"><img src="{address}/assets/colab-badge.svg"/></a>'
    )
    mark = {"id": "view-in-github", "colab_type": "text"}
    cells.insert(0, {"cell_type": "markdown", "metadata": mark, "source": [badge]})
    metadata = {key: value for key, value in notebook["metadata"].items() if key != "language_info"}
    metadata |= {"colab": {"provenance": [], "include_colab_link": True}, "accelerator": "GPU"}
    metadata["kernelspec"] = {"display_name": "Python 3", "name": "python3"}
    return {"nbformat": 4, "nbformat_minor": 0, "metadata": metadata, "cells": cells}


def kaggle(notebook: Notebook) -> Notebook:
    """Make new identifiers, drop the notebook's own metadata, and end with an empty cell."""
    # Kaggle 2022 to 2026: from files, which its batch run with papermill 2.6 has written.
    cells = [code("!pip install -q nao-course"), *notebook["cells"], code("")]
    for number, cell in enumerate(run(cells)):
        cell["id"] = hexadecimal(number)
        hidden = bool(cell["metadata"].get("jupyter", {}).get("source_hidden"))
        cell["metadata"] |= {
            "_kg_hide-input": hidden,
            "_uuid": hexadecimal(number, 12),
            "trusted": True,
            "execution": {"iopub.status.busy": "2024-04-22T14:09:38.134240Z"},
            "papermill": {"duration": 1.2, "exception": False, "status": "completed"},
            "tags": [],
        }
        cell["source"] = lines(cell)
    metadata = {
        "kaggle": {"accelerator": "none", "dataSources": [], "language": "python", "sourceType": "notebook"},
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": PYTHON,
        "papermill": {"input_path": "__notebook__.ipynb", "output_path": "__notebook__.ipynb"},
    }
    return {"nbformat": 4, "nbformat_minor": 5, "metadata": metadata, "cells": cells}


def deepnote(notebook: Notebook) -> Notebook:
    """Turn cells into blocks and back: identifiers, raw cells and the notebook's own metadata are lost."""
    # Deepnote, November 2025: from the source of its converter between projects and notebooks, and a file in its tests.
    cells = []
    for number, cell in enumerate([code("!pip install nao-course"), *notebook["cells"]]):
        is_code, text = cell["cell_type"] == "code", "".join(cell["source"])
        added = {
            "cell_id": hexadecimal(number, 16),
            "deepnote_block_group": hexadecimal(number + 1, 16),
            "deepnote_cell_type": "code" if is_code else "markdown",
            "deepnote_sorting_key": f"{number:04}",
            "deepnote_source": text,
        }
        cells.append(
            {
                "block_group": added["deepnote_block_group"],
                "cell_type": added["deepnote_cell_type"],
                "execution_count": None,
                "metadata": added | cell["metadata"],
                "source": text,
            }
        )
    metadata = {"deepnote_notebook_id": hexadecimal(0, 16), "deepnote_execution_mode": "block"}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 0}


def jupyterlite(notebook: Notebook) -> Notebook:
    """Keep identifiers and metadata, and store each text as one string; the kernel runs in the browser."""
    # JupyterLite 0.4 to 0.6 with the Pyodide kernel: from files and from the kernel's tests.
    cells = [code("import piplite\nawait piplite.install('nao-course')"), *notebook["cells"]]
    for number, cell in enumerate(run(cells)):
        cell.setdefault("id", hexadecimal(number))
        cell["metadata"]["trusted"] = True
        cell["source"] = "".join(cell["source"])
    kernel = {"name": "python", "display_name": "Python (Pyodide)", "language": "python"}
    info = PYTHON | {"version": "3.12.8", "codemirror_mode": {"name": "python", "version": 3}}
    metadata = notebook["metadata"] | {"kernelspec": kernel, "language_info": info}
    return {"metadata": metadata, "nbformat_minor": 5, "nbformat": 4, "cells": cells}


FRONT_ENDS = {
    "Notebook 7": FrontEnd(notebook_7),
    "JupyterLab with shared editing": FrontEnd(shared_editing),
    "the same, after it has doubled all cells": FrontEnd(doubled),
    "JupyterLite": FrontEnd(jupyterlite, indent=2),
    "VS Code": FrontEnd(vs_code),
    "PyCharm, DataSpell": FrontEnd(pycharm),
    "Google Colab": FrontEnd(colab, indent=2, file="Copy of {}.ipynb".format),
    "Kaggle": FrontEnd(kaggle, file=lambda lesson: f"{lesson.replace('_', '-')}.ipynb"),
    "Deepnote": FrontEnd(deepnote, indent=2),
}
