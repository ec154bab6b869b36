"""The laws of the repository: what may import what, what may stand in a file, and what the lock files hold.

Each law is a function that lists its offences, so that it can be tried on a broken example too.
"""

import io
import json
import re
import subprocess
import tokenize
import tomllib
from typing import Any

import pytest

from tests.paths import PROJECT

LOCKS = (
    *("requirements.lock", "requirements-dev.lock", "requirements-bench.lock", "requirements-site.lock"),
    "deploy/hub/requirements.lock",
)


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


def pyproject(folder: str = ".") -> dict[str, Any]:
    return tomllib.loads((PROJECT / folder / "pyproject.toml").read_text(encoding="utf-8"))


def declared() -> dict[str, list[str]]:
    """Every table of dependencies of the two distributions, by its name."""
    table = pyproject()
    project, ours = table["project"], {table["project"]["name"], INSTRUCTOR["name"]}
    tables = {
        "core": project["dependencies"],
        **project["optional-dependencies"],
        **table["dependency-groups"],
    }
    tables["instructor"] = INSTRUCTOR["dependencies"]
    return {k: [each for each in lines if requirement_name(each) not in ours] for k, lines in tables.items()}


INSTRUCTOR = pyproject("nao_course/instructor")["project"]


def test_the_two_distributions_ask_for_each_other_in_the_same_version():
    project = pyproject()["project"]
    assert INSTRUCTOR["version"] == project["version"]
    assert INSTRUCTOR["requires-python"] == project["requires-python"]
    assert f"{project['name']}=={project['version']}" in INSTRUCTOR["dependencies"]
    assert project["optional-dependencies"]["instructor"] == [f"{INSTRUCTOR['name']}=={project['version']}"]


@pytest.mark.parametrize("name", LOCKS)
def test_a_lock_holds_exact_versions_with_hashes_and_no_address(name):
    text = (PROJECT / name).read_text(encoding="utf-8")
    assert len(lock_entries(text)) > 50
    assert lock_offences(text) == []
    # Without the extras, older pips ignore the pin and fail as soon as a newer release of the package appears.
    wanted = name in ("requirements.lock", "requirements-dev.lock")
    assert not wanted or any(each.startswith("jsonschema[format-nongpl]==") for each in lock_entries(text))


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
    student, instructor, bench, site, hub = (
        {re.sub(r"\[.*\]| ;.*", "", entry) for entry in lock_entries((PROJECT / name).read_text("utf-8"))}
        for name in LOCKS
    )
    assert student - instructor == set()
    peers = {requirement_name(each) for each in declared()["bench"]}
    assert {requirement_name(each) for each in bench - instructor} == peers
    shared = {requirement_name(each) for each in site} & {requirement_name(each) for each in instructor}
    assert {requirement_name(each) for each in site - instructor} & shared == set()
    assert student - hub == set()


@pytest.mark.parametrize(
    "name", ["web/package-lock.json", "deploy/hub/package-lock.json", "tests/versions/package-lock.json"]
)
def test_a_lock_of_npm_holds_hashes_and_no_address(name):
    text = (PROJECT / name).read_text(encoding="utf-8")
    packages = json.loads(text)["packages"]
    assert "://" not in text
    assert all("integrity" in package for path, package in packages.items() if path)


def test_every_dependency_is_locked_and_has_its_reason_written_down():
    tables = declared()
    small, big, bench, site, hub = (
        locked_names((PROJECT / name).read_text(encoding="utf-8")) for name in LOCKS
    )
    student = {requirement_name(each) for table in ("core", "lab", "build") for each in tables[table]}
    everything = {requirement_name(each) for table in tables.values() for each in table}
    assert student - small == set()
    extras = {requirement_name(each) for table in ("bench", "hub", "site") for each in tables[table]}
    assert everything - big == extras
    assert everything - big - bench - site - hub == set()
    page = (PROJECT / "docs" / "dependencies.md").read_text(encoding="utf-8")
    explained = {name.lower() for name in re.findall(r"^\| `([\w.-]+)", page, re.MULTILINE)}
    assert explained == everything


HOSTS = r"pypi\.(?:org|python\.org)|pythonhosted\.org|registry\.npmjs|anaconda\.org|deb\.debian\.org"
INDEX_HOSTS = re.compile(HOSTS, re.IGNORECASE)
MACHINE_PATHS = re.compile(r"(?<![\w.~/-])/(?:work|root|home)/[\w.]")


def text_offences(name: str, content: bytes) -> list[str]:
    if b"\0" in content:
        return []
    text = content.decode("utf-8", errors="replace")
    return [
        f"{name}:{len(text[: found.end()].splitlines())}: {found.group()}"
        for pattern in (INDEX_HOSTS, MACHINE_PATHS)
        for found in pattern.finditer(text)
    ]


def tracked_files() -> list[str]:
    try:
        command = ["git", "ls-files", "-z"]
        listed = subprocess.run(command, cwd=PROJECT, capture_output=True, check=True, text=True)
    except (OSError, subprocess.CalledProcessError) as problem:
        pytest.skip(f"not a git checkout: {problem}")
    return [name for name in listed.stdout.split("\0") if (PROJECT / name).is_file()]


def test_each_finding_is_named_where_the_course_meets_it():
    pages = "".join(path.read_text(encoding="utf-8") for path in (PROJECT / "docs").glob("*.md"))
    findings = list((PROJECT / "findings").glob("*.sh"))
    assert findings and [path.name for path in findings if f"findings/{path.name}" not in pages] == []


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


AFTER_BRACKETS = re.compile(r"^\s*[])}]+[:,]?\s*#", re.MULTILINE)
FOR_TOOLS = ("# fmt: skip", "# type:", "# noqa")


def stranded_comments(name: str, source: str) -> list[str]:
    """Comments behind the closing bracket of several lines, where nobody sees what they belong to."""
    if not AFTER_BRACKETS.search(source):
        return []  # reading tokens takes time
    return [
        f"{name}:{each.start[0]}: {each.string}"
        for each in tokenize.generate_tokens(io.StringIO(source).readline)
        if each.type == tokenize.COMMENT
        and AFTER_BRACKETS.fullmatch(each.line[: each.start[1] + 1])
        and not each.string.startswith(FOR_TOOLS)
    ]


def test_no_comment_follows_the_closing_bracket_of_several_lines():
    sources = [name for name in tracked_files() if name.endswith(".py")]
    found = [stranded_comments(name, (PROJECT / name).read_text(encoding="utf-8")) for name in sources]
    assert [offence for offences in found for offence in offences] == []


@pytest.mark.parametrize(
    ("source", "offences"),
    [
        ("LENGTHS = (\n    1.0\n)  # m", 1),
        ("f({\n    1.0\n}, [\n    2.0\n]),  # m", 1),
        ("if f(\n    1.0\n):  # m\n    pass", 1),
        ("a = [\n    f(\n        1.0\n    ),  # m\n]", 1),
        ("# m\nLENGTHS = (\n    1.0\n)", 0),
        ("LENGTHS = (1.0)  # m", 0),
        ("f(\n    1\n)  # fmt: skip", 0),
        ('TEXT = """\n)  # m\n"""', 0),
    ],
)
def test_only_a_comment_that_follows_a_closing_bracket_of_several_lines_is_found_out(source, offences):
    assert len(stranded_comments("x", source)) == offences


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
    blank = {"id": "a", "cell_type": "code", "outputs": [], "execution_count": None}
    assert notebook_offences({"cells": [blank, {"id": "b", "cell_type": "markdown"}]}) == []
    for broken in ({"id": None}, {"outputs": [{}]}, {"execution_count": 1}):
        assert len(notebook_offences({"cells": [blank | broken]})) == 1
    assert len(notebook_offences({"cells": [blank, blank]})) == 1
