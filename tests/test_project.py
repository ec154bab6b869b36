"""The laws of the repository: what may import what, what may stand in a file, and what the lock files hold.

Each law is a function that lists its offences, so that it can be tried on a broken example too.
"""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from tests.paths import PROJECT

LOCKS = ("requirements.lock", "requirements-dev.lock")


# Lock files


def lock_entries(text: str) -> dict[str, str]:
    """Requirement line ("name==version ; marker") -> the lines that follow it."""
    parts = re.split(r"^(?=[A-Za-z0-9])", text, flags=re.MULTILINE)
    return {part.splitlines()[0].rstrip(" \\"): part for part in parts if part.strip()}


def lock_offences(text: str) -> list[str]:
    addresses = [line for line in text.splitlines() if "://" in line or line.lstrip().startswith("--index")]
    entries = lock_entries(text)
    loose = [name for name in entries if not re.match(r"[\w.\[\],-]+==[\w.!+]+( ; .+)?$", name)]
    bare = [name for name, entry in entries.items() if not re.search(r"--hash=sha256:[0-9a-f]{64}\b", entry)]
    return addresses + loose + bare


def locked_names(text: str) -> set[str]:
    return {requirement_name(entry) for entry in lock_entries(text)}


def requirement_name(requirement: str) -> str:
    match = re.match(r"[\w.-]+", requirement)
    assert match, requirement
    return match.group().lower().replace("_", "-")


def declared() -> dict[str, list[str]]:
    """Every table of dependencies in pyproject.toml, by its name."""
    table = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))
    project = table["project"]
    return {"core": project["dependencies"], **project["optional-dependencies"], **table["dependency-groups"]}


@pytest.mark.parametrize("name", LOCKS)
def test_a_lock_holds_exact_versions_with_hashes_and_no_address(name):
    text = (PROJECT / name).read_text(encoding="utf-8")
    assert len(lock_entries(text)) > 50
    assert lock_offences(text) == []


@pytest.mark.parametrize(
    "broken",
    [
        "numpy==2.4.6 \\\n    # via scipy\n",
        "numpy>=2 \\\n    --hash=sha256:" + 64 * "a",
        "--index-url https:" + "//example.org/simple\nnumpy==2.4.6 \\\n    --hash=sha256:" + 64 * "a",
        "numpy @ file:" + "///wheels/numpy.whl \\\n    --hash=sha256:" + 64 * "a",
    ],
)
def test_a_lock_without_hash_or_version_or_with_an_address_is_found_out(broken):
    assert lock_offences(broken)


def test_what_a_student_runs_is_what_the_instructor_tests():
    student, instructor = ((PROJECT / name).read_text(encoding="utf-8") for name in LOCKS)
    without_marker = [
        {entry.split(" ;")[0] for entry in lock_entries(text)} for text in (student, instructor)
    ]
    assert without_marker[0] - without_marker[1] == set()


def test_every_dependency_is_locked_and_has_its_reason_written_down():
    tables = declared()
    small, big = (locked_names((PROJECT / name).read_text(encoding="utf-8")) for name in LOCKS)
    student = {requirement_name(each) for table in ("core", "lab", "build") for each in tables[table]}
    everything = {requirement_name(each) for table in tables.values() for each in table}
    assert student - small == set()
    assert everything - big == set()
    page = (PROJECT / "docs" / "dependencies.md").read_text(encoding="utf-8")
    explained = {name.lower() for name in re.findall(r"^\| `([\w.-]+)", page, re.MULTILINE)}
    assert explained == everything


# Text of every tracked file

INDEX_HOSTS = re.compile(
    r"pypi\.(?:org|python\.org)|pythonhosted\.org|registry\.npmjs|anaconda\.org|deb\.debian\.org",
    re.IGNORECASE,
)
MACHINE_PATHS = re.compile(r"(?<![\w.~/-])/(?:work|root|home)/[\w.]")


def text_offences(name: str, content: bytes) -> list[str]:
    if b"\0" in content:
        return []
    lines = content.decode("utf-8", errors="replace").splitlines()
    return [
        f"{name}:{number}: {found.group()}"
        for number, line in enumerate(lines, start=1)
        for pattern in (INDEX_HOSTS, MACHINE_PATHS)
        if (found := pattern.search(line))
    ]


def tracked_files() -> list[str]:
    try:
        listed = subprocess.run(
            ["git", "ls-files", "-z"], cwd=PROJECT, capture_output=True, check=True, text=True
        )
    except (OSError, subprocess.CalledProcessError) as problem:
        pytest.skip(f"not a git checkout: {problem}")
    return [name for name in listed.stdout.split("\0") if (PROJECT / name).is_file()]


def test_no_tracked_file_names_a_package_index_or_a_path_of_one_machine():
    found = [text_offences(name, (PROJECT / name).read_bytes()) for name in tracked_files()]
    assert [offence for offences in found for offence in offences] == []


@pytest.mark.parametrize(
    "line",
    [
        "see https:" + "//py" + "pi.org/project/numpy",
        "files.python" + "hosted.org",
        'open("/' + 'home/ada/data.csv")',
        "cd /" + "work/x",
        "/" + "root/.cache",
    ],
)
def test_an_index_or_a_machine_path_is_found_out(line):
    assert text_offences("x", b"fine\n" + line.encode())
    assert text_offences("x", b"work/x ../home/ada ~/root/x https://example.org/home/x") == []


# Who may import whom

LAYERS = (
    {"geometry"},
    {"slam"},
    {"sim"},
    {"datasets", "metrics"},
    {"plotting"},
    {"widgets"},
)
LAYER = {part: number for number, parts in enumerate(LAYERS) for part in parts}
WORLD = {"sim", "datasets", "metrics", "plotting", "widgets"}  # sim and all that stands on it


def module_files() -> dict[str, Path]:
    """Dotted name under nao_course ("sim.field", "" for the package itself) -> file."""
    package = PROJECT / "nao_course"
    names = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).with_suffix("").parts
        names[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return names


def module_sources() -> dict[str, str]:
    return {name: path.read_text(encoding="utf-8") for name, path in module_files().items()}


def part_of(module: str) -> str:
    return module.split(".")[0]


def imported_parts(module: str, source: str, *, is_package: bool = False) -> set[str]:
    """The parts of nao_course (sim, plotting, ...) that a module imports anywhere, its own left out."""
    here = ["nao_course", *filter(None, module.split("."))]
    package = here if is_package else here[:-1]
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            start = ".".join([*base, *filter(None, [node.module])])
            names |= {f"{start}.{alias.name}" for alias in node.names}
    inside = [name.split(".") for name in names]
    return {parts[1] for parts in inside if parts[0] == "nao_course" and len(parts) > 1} - {part_of(module)}


def layer_offences(module: str, imports: Iterable[str]) -> list[str]:
    part, offences = part_of(module), []
    for other in imports:
        upwards = part in LAYER and other in LAYER and LAYER[other] >= LAYER[part]
        into_instructor = other == "instructor" and part != "cli"
        into_cli = other == "cli" and part != "__main__"
        exercises_see_the_world = part == "exercises" and other in WORLD
        if upwards or into_instructor or into_cli or exercises_see_the_world:
            offences.append(f"nao_course.{module} imports {other}")
    return offences


def test_modules_import_only_what_stands_below_them():
    offences = [
        offence
        for module, path in module_files().items()
        for offence in layer_offences(
            module,
            imported_parts(module, path.read_text(encoding="utf-8"), is_package=path.name == "__init__.py"),
        )
    ]
    assert offences == []


@pytest.mark.parametrize(
    ("module", "line"),
    [
        ("geometry", "from nao_course.slam import Motion"),
        ("slam", "import nao_course.sim.field"),
        ("sim.nao", "from ..plotting import field_map"),
        ("sim.nao", "from nao_course import datasets"),
        ("metrics", "def f():\n    from nao_course.datasets import read_g2o"),
        ("plotting", "from .widgets import panel"),
        ("exercises.check", "from nao_course.sim import Field"),
        ("student", "from nao_course.instructor.sandbox.confinement import level"),
        ("widgets.panel", "from nao_course import cli"),
    ],
)
def test_an_import_upwards_is_found_out(module, line):
    assert layer_offences(module, imported_parts(module, line))


@pytest.mark.parametrize(
    ("module", "line"),
    [
        (
            "sim.nao",
            "from .field import Field\nfrom ..geometry import Pose\nfrom nao_course.slam import Motion",
        ),
        ("sim.field", "from nao_course.exercises.codec import register"),
        ("widgets.panel", "from nao_course import plotting, metrics"),
        ("exercises.check", "from nao_course.geometry import wrap_angle\nimport numpy"),
        ("cli", "from nao_course import instructor"),
        ("instructor.sandbox.worker", "from nao_course.instructor import sandbox"),
    ],
)
def test_an_import_downwards_is_fine(module, line):
    assert layer_offences(module, imported_parts(module, line)) == []


# The library holds the world, not the answers

EXERCISES = {
    *(
        "rgb_to_hsl",
        "average_lightness",
        "white_threshold",
        "calibrate_hue",
        "hue_mask",
        "color_labels",
    ),  # 01
    *("post_candidates", "cluster_points", "find_goalposts"),  # 02
    *("erase_background", "line_picture", "hough_segments", "segment_intersection", "remove_doubles"),  # 03
    *("find_corners", "find_corners_better"),
    *("paper_distance", "paper_bearing", "pixel_to_ground", "ground_to_measurement", "range_sigma"),  # 04
    *("measurement_covariance", "estimate_pitch"),
    *("predict_pose", "expected_measurement", "motion_jacobians", "predict_covariance"),  # 05
    *("landmark_position", "landmark_jacobians"),
    *("measurement_jacobian_pose", "measurement_jacobian_landmark"),
    *("fuse", "covariance_ellipse", "innovation", "kalman_update", "localize", "nees", "nis"),  # 06
    *("warp2pi", "init_landmarks", "predict", "update_landmarks", "update", "add_landmark"),  # 07
    "evaluate_landmarks",
    *("add_initial_position", "add_relative_motion", "add_relative_measurement", "solve"),  # 08
    *("marginalize", "solve_sparse"),
    *("pose_residual", "pose_residual_jacobians", "landmark_residual", "landmark_residual_jacobians"),  # 09
    *("linearize", "gauss_newton", "marginal_covariances"),
    *("detection_cost", "grid_search", "bootstrap_interval"),  # 10
    *("measurements_from_pixels", "measure", "associate", "EkfSlam", "GraphSlam"),  # 11
}
# What the world and the judging need, the library may hold: wrapping, composing, range and bearing, scoring.
NEEDED_BY_THE_WORLD = {
    *("warp2pi", "predict_pose", "expected_measurement", "ground_to_measurement"),
    *("nees", "nis", "evaluate_landmarks", "detection_cost"),
}


Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def public_definitions(inside: ast.AST) -> Iterator[Definition]:
    """Functions and classes of a module or class that have no underscore first, under `if` and `try` too."""
    waiting = [inside]
    while waiting:
        for node in ast.iter_child_nodes(waiting.pop()):
            if isinstance(node, Definition):
                if not node.name.startswith("_"):
                    yield node
            else:
                waiting.append(node)


def answers_in(source: str) -> list[str]:
    defined = {node.name for node in public_definitions(ast.parse(source))}
    return sorted(defined & (EXERCISES - NEEDED_BY_THE_WORLD))


def without_docstring(source: str) -> list[str]:
    public = [(node.name, node) for node in public_definitions(ast.parse(source))]
    for name, node in public:
        if isinstance(node, ast.ClassDef):
            public += [(f"{name}.{inner.name}", inner) for inner in public_definitions(node)]
    return sorted(
        name for name, node in public if not ast.get_docstring(node) and not is_told_elsewhere(node)
    )


def is_told_elsewhere(node: Definition) -> bool:
    """Whether it is a property's setter or an overload, whose docstring stands at the first definition."""
    names = {ast.unparse(decorator).split(".")[-1] for decorator in node.decorator_list}
    return bool(names & {"setter", "deleter", "overload"})


def test_the_library_defines_nothing_that_is_an_exercise():
    found = {name: answers_in(source) for name, source in module_sources().items()}
    assert {name: answers for name, answers in found.items() if answers} == {}


def test_an_answer_in_the_library_is_found_out():
    broken = "if True:\n    def kalman_update(x): ...\nclass EkfSlam: ..."
    fine = "class Panel:\n    def update(self): ...\ndef _fuse(): ...\ndef nees(): ..."
    assert answers_in(broken) == ["EkfSlam", "kalman_update"]
    assert answers_in(fine) == []


def test_every_public_function_class_and_method_says_what_it_is_for():
    found = {name: without_docstring(source) for name, source in module_sources().items()}
    assert {name: missing for name, missing in found.items() if missing} == {}


def test_a_missing_docstring_is_found_out():
    methods = "    def b(self): ...\n    def _c(self): ...\n"
    source = f'class A:\n    """Yes."""\n{methods}async def d(): ...\n'
    assert without_docstring(source) == ["A.b", "d"]
    assert without_docstring('class A:\n    """Yes."""\n    @b.setter\n    def b(self, b): ...') == []


# Student notebooks


def notebook_offences(notebook: dict[str, object]) -> list[str]:
    cells = notebook["cells"]
    assert isinstance(cells, list)
    ids = [cell.get("id") or "" for cell in cells]
    offences = [f"cell {number} has no id" for number, name in enumerate(ids) if not name]
    offences += [f"id {name} stands twice" for name in sorted({each for each in ids if ids.count(each) > 1})]
    offences += [f"cell {cell.get('id')} keeps outputs" for cell in cells if cell.get("outputs")]
    offences += [f"cell {cell.get('id')} keeps its count" for cell in cells if cell.get("execution_count")]
    return offences


def test_student_notebooks_are_blank_and_their_cells_can_be_told_apart():
    for path in sorted((PROJECT / "notebooks").glob("*.ipynb")):
        assert notebook_offences(json.loads(path.read_text(encoding="utf-8"))) == [], path.name


def test_a_run_notebook_or_one_with_doubled_ids_is_found_out():
    blank = {"id": "a", "cell_type": "code", "outputs": [], "execution_count": None}
    assert notebook_offences({"cells": [blank, {"id": "b", "cell_type": "markdown"}]}) == []
    for broken in ({"id": None}, {"outputs": [{}]}, {"execution_count": 1}):
        assert len(notebook_offences({"cells": [blank | broken]})) == 1
    assert len(notebook_offences({"cells": [blank, blank]})) == 1


# What is shipped


@pytest.mark.slow
def test_the_wheel_and_the_source_archive_hold_the_library_and_no_solutions(tmp_path):
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-d", str(tmp_path)],
        cwd=PROJECT,
        check=True,
        capture_output=True,
    )
    (wheel,), (archive,) = tmp_path.glob("*.whl"), tmp_path.glob("*.tar.gz")
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.split("/")[0] for name in names}
    assert "nao_course/geometry.py" in names
    assert {top for top in tops if not top.endswith(".dist-info")} == {"nao_course"}
    listed = subprocess.run(
        [sys.executable, "-m", "tarfile", "-l", str(archive)], check=True, capture_output=True, text=True
    ).stdout.split()
    assert "solutions" not in {part for name in listed for part in name.split("/")}
    assert any(name.endswith("nao_course/geometry.py") for name in listed)
