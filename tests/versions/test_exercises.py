"""All exercises with the oldest and the newest versions of their libraries, and the lines that differ between them."""

import json
import re
import shutil
import subprocess

import pytest

from tests.paths import PROJECT
from tests.test_installed import Environment, declared
from tests.versions.differences import DIFFERENCES, result

# A student's overview gives each notebook some seconds; here no notebook is too late.
OVERVIEW = (
    "from nao_course.student import notebooks, progress; notebooks.SECONDS = 600.0; print(repr(progress()))"
)
PYTHONS = {"lowest-direct": ["3.11"], "highest": ["3.13", "3.12"]}


@pytest.mark.parametrize("difference", DIFFERENCES, ids=[each.code for each in DIFFERENCES])
def test_the_installed_versions_give_one_of_both_results_and_the_documents_have_the_line(difference):
    assert result(difference.code) in (difference.oldest, difference.newest)
    page = (PROJECT / "docs" / "dependencies.md").read_text(encoding="utf-8")
    assert f"| `{difference.code}` |" in page


@pytest.mark.slow
@pytest.mark.parametrize("resolution", PYTHONS)
def test_all_exercises_pass_their_public_checks_and_the_differences_are_as_written(resolution, tmp_path):
    found = [path for each in PYTHONS[resolution] if (path := runs(each))]
    if not found:
        pytest.skip(f"none of Python {', '.join(PYTHONS[resolution])} is on this machine")
    environment = Environment(tmp_path, found[0])
    core = [each for each in declared() if not each.startswith(("nao-course", "jupyterlab"))]
    done = environment.install("--resolution", resolution, *core, "hatchling>=1.27", "editables")
    if re.search("Failed to fetch|error sending request|dns error|network", done.stderr):
        pytest.skip(f"no package index can be reached: {done.stderr[-300:]}")
    assert done.returncode == 0, done.stderr
    assert environment.install("--no-deps", "--no-build-isolation", "-e", PROJECT).returncode == 0
    for path in (PROJECT / "solutions").glob("*.ipynb"):
        shutil.copy(path, environment.folder)
    said = environment.says("python", "-c", OVERVIEW)
    passed, points = re.search(r"All lessons: (\d+) of (\d+) points", " ".join(said.split())).groups()
    assert passed == points and int(points) > 200, said
    results = json.loads(environment.says("python", str(PROJECT / "tests" / "versions" / "differences.py")))
    expected = [each.newest if resolution == "highest" else each.oldest for each in DIFFERENCES]
    assert list(results.values()) == expected
    shutil.rmtree(environment.prefix)  # some hundred megabytes


def runs(version: str) -> str:
    """Return the path of an interpreter that runs; a version manager may only seem to have one."""
    path = shutil.which(f"python{version}")
    if path is None or subprocess.run([path, "--version"], capture_output=True).returncode:
        return ""
    command = [path, "-c", "import sys; print(sys.executable)"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
