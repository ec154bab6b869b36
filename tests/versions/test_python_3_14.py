"""Students' code and the codec on Python 3.14, which the npm package `pyodide` runs in node without NumPy."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.paths import PROJECT

HERE = Path(__file__).parent
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    if not shutil.which("npm"):
        pytest.skip("npm is not installed")
    folder = tmp_path_factory.mktemp("node")
    for name in ("package.json", "package-lock.json", "run_python.mjs"):
        shutil.copy(HERE / name, folder)
    install = ["npm", "ci", "--ignore-scripts", "--no-fund", "--no-audit"]
    done = subprocess.run(install, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"npm cannot install pyodide: {done.stderr[-200:]}")
    command = ["node", "run_python.mjs", str(PROJECT), str(HERE / "on_python_3_14.py")]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout.splitlines()[-1])


def test_plain_values_are_sent_and_received_without_numpy(reported):
    assert reported["python"] == [3, 14] and reported["codec"]


def test_new_syntax_and_late_annotations_run_and_annotate_is_no_function_of_the_notebook(reported):
    for version, loaded in reported["loaded"].items():
        assert loaded["names"] == ["Box", "first", "guarded", "late", "nested", "template"], version
        assert loaded["results"] == {
            "late": 1,
            "first": 5,
            "guarded": 3,
            "template": "nao",
            "nested": "a, b 3",
        }
        (reason,) = loaded["skipped"]
        assert reason.startswith("SyntaxError")
