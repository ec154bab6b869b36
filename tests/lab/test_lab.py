"""The course opens JupyterLab with its own settings, and changes nothing in the environment for that."""

import json
import os
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient

from nao_course import lab
from tests.paths import PROJECT

PACKAGE = Path(lab.__file__).parents[1]
STYLES = (PACKAGE / "lab" / "custom" / "custom.css").read_text()
USES = "\n".join(path.read_text() for path in PACKAGE.rglob("*.py"))


def test_jupyterlab_is_given_the_courses_settings_and_further_arguments():
    program, *arguments = lab.command(Path("notebooks"), ["--no-browser"])
    assert program == sys.executable
    assert arguments[:3] == ["-m", "jupyterlab", "notebooks"] and arguments[-1] == "--no-browser"
    (settings,) = [Path(each.split("=")[1]) for each in arguments if "app_settings_dir" in each]
    disabled = json.loads((settings / "page_config.json").read_text())["disabledExtensions"]
    busy_icon = "@jupyterlab/application-extension:faviconbusy"  # it asks the server thrice for each picture
    assert disabled == {"@jupyter/nbgrader": True, busy_icon: True}
    news = json.loads((settings / "overrides.json").read_text())[
        "@jupyterlab/apputils-extension:notification"
    ]
    assert news["fetchNews"] == "false"


def test_the_lesson_that_was_run_and_saved_last_is_opened_and_at_first_the_first(tmp_path):
    assert "default_url" not in str(lab.command(tmp_path, hub=False))
    for number, name in enumerate(("00_meet", "01_filter", "02_posts", "my notes")):
        cell = nbformat.v4.new_code_cell("1")
        nbformat.write(nbformat.v4.new_notebook(cells=[cell]), tmp_path / f"{name}.ipynb")
        os.utime(tmp_path / f"{name}.ipynb", (number, number))
    assert "--LabApp.default_url=/doc/tree/00_meet.ipynb" in lab.command(tmp_path, hub=False)
    cell.execution_count = 3
    for name in ("02_posts", "01_filter"):
        nbformat.write(nbformat.v4.new_notebook(cells=[cell]), tmp_path / f"{name}.ipynb")
    os.utime(tmp_path / "01_filter.ipynb", (5, 5))
    assert lab.lesson_to_open(tmp_path) == tmp_path / "02_posts.ipynb"
    (tmp_path / "03_lost.ipynb").symlink_to(tmp_path / "nowhere")
    (tmp_path / "00_a_folder.ipynb").mkdir()
    assert lab.lesson_to_open(tmp_path) == tmp_path / "02_posts.ipynb"
    assert "default_url" not in str(lab.command(tmp_path, hub=True))


def test_the_keys_that_drive_the_robot_change_no_cell_beside_its_panel():
    overrides = json.loads((PACKAGE / "lab" / "settings" / "overrides.json").read_text())
    ours = overrides["@jupyterlab/shortcuts-extension:shortcuts"]["shortcuts"]
    off = [(each["command"], each["keys"], each["selector"]) for each in ours if each["disabled"]]
    assert [(command, keys) for command, keys, _ in off] == [
        ("notebook:delete-cell", ["D", "D"]),
        ("notebook:cut-cell", ["X"]),
        ("notebook:paste-cell-below", ["V"]),
        ("notebook:change-cell-to-markdown", ["M"]),
        ("notebook:insert-cell-above", ["A"]),
        ("kernelmenu:interrupt", ["I", "I"]),
    ]
    schemas = Path(sys.prefix, "share", "jupyter", "lab", "schemas", "@jupyterlab")
    shipped = [
        (each["command"], each["keys"], each["selector"])
        for path in schemas.rglob("*.json")
        for each in json.loads(path.read_text()).get("jupyter.lab.shortcuts", [])
    ]
    for each in off if shipped else ():
        assert each in shipped, "JupyterLab's own shortcut has another selector, so it would stay"


def test_on_a_hub_the_same_settings_open_a_server_that_the_hub_knows_and_whose_kernels_have_no_ports(
    monkeypatch,
):
    monkeypatch.setenv("JUPYTERHUB_SERVICE_URL", "http://127.0.0.1:8001/")
    arguments = lab.command(Path("notebooks"))[1:]
    assert arguments[:3] == ["-m", "jupyterhub.singleuser", "--ServerApp.root_dir=notebooks"]
    assert "--KernelManager.transport=ipc" in arguments
    monkeypatch.delenv("JUPYTERHUB_SERVICE_URL")
    at_home = lab.command(Path("notebooks"))[1:]
    assert [each for each in at_home if each.startswith("--")][1:] == arguments[5:]  # without the lesson
    assert not any("transport" in each for each in at_home)


def test_the_server_finds_the_courses_style_sheet_behind_the_users_own():
    (point,) = lab._jupyter_server_extension_points()
    assert point["module"] == lab.__name__ and f"'{lab.__name__}': True" in " ".join(lab.command(Path()))
    server = SimpleNamespace(web_app=SimpleNamespace(settings={"static_custom_path": ["own"]}))
    lab._load_jupyter_server_extension(server)
    own, courses = server.web_app.settings["static_custom_path"]
    assert own == "own" and (Path(courses) / "custom.css").is_file()


@pytest.mark.parametrize("name", ["right", "wrong", "open", "mark"])
def test_colours_of_text_have_enough_contrast_on_light_and_dark_pages(name):
    dark = re.findall(rf"--nao-{name}: (#\w+);", STYLES)
    assert len(dark) == 2 and len(set(dark)) == 1  # JupyterLab's and the pages' theme, and the system's
    light = [each for each in re.findall(r"var\(--nao-(\w+), (#\w+)\)", USES) if each[0] == name]
    assert light
    assert all(contrast(colour, "#ffffff") >= 4.5 for _, colour in light)
    assert contrast(dark[0], "#111111") >= 4.5


def contrast(one, other):
    """Return the contrast ratio of two colours by WCAG 2.2."""

    def luminance(colour):
        parts = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
        linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        return linear @ (0.2126, 0.7152, 0.0722)

    low, high = sorted(luminance(each) + 0.05 for each in (one, other))
    return high / low


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


@pytest.mark.parametrize("name", ["01_hsl_filtering", "02_goalposts", "03_hough_corners", "04_distance"])
def test_the_photographs_at_the_top_of_a_lesson_keep_their_colours(name):
    """The style sheet has the clip paths that the same figures have at the lessons' ends."""
    cells = nbformat.read(PROJECT / "solutions" / f"{name}.ipynb", as_version=4).cells
    (payoff,) = (str(each.outputs) for each in cells if "check.payoff(" in each.source)
    (path,) = re.findall(r"clip-path: polygon\(evenodd, [\d.,% ]+\)", payoff)
    assert f'"{name[:2]}_payoff.jpeg"])::after {{ {path}; }}' in STYLES
