"""The course opens JupyterLab with its own settings, and changes nothing in the environment for that."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from nao_course import lab


def test_jupyterlab_is_given_the_courses_settings_and_further_arguments():
    program, *arguments = lab.command(Path("notebooks"), ["--no-browser"])
    assert program == sys.executable
    assert arguments[:3] == ["-m", "jupyterlab", "notebooks"] and arguments[-1] == "--no-browser"
    (settings,) = [Path(each.split("=")[1]) for each in arguments if "app_settings_dir" in each]
    disabled = json.loads((settings / "page_config.json").read_text())["disabledExtensions"]
    assert disabled == {"@jupyter/nbgrader": True}
    news = json.loads((settings / "overrides.json").read_text())[
        "@jupyterlab/apputils-extension:notification"
    ]
    assert news["fetchNews"] == "false"


def test_without_jupyterlab_its_name_is_said(monkeypatch):
    monkeypatch.setattr(lab, "find_spec", lambda name: None)
    with pytest.raises(ModuleNotFoundError, match="JupyterLab is not installed") as caught:
        lab.command(Path())
    assert caught.value.name == "jupyterlab"


def test_a_startup_file_of_the_users_own_is_kept():
    assert lab.environment({"PYTHONSTARTUP": "mine.py"})["PYTHONSTARTUP"] == "mine.py"
    assert lab.environment({"HOME": "x"})["HOME"] == "x"


def test_a_kernel_explains_an_unknown_name_before_any_cell_has_run(monkeypatch):
    monkeypatch.setenv("PYTHONSTARTUP", lab.environment({})["PYTHONSTARTUP"])
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("draw_picture")])
    NotebookClient(notebook, kernel_name="python3", allow_errors=True, timeout=60).execute()
    shown = json.dumps(notebook.cells[0].outputs)
    assert "did the cells above run" in shown.lower() or "is not defined" in shown
    assert "Traceback" not in shown
