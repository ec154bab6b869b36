"""What was proven is proven again when something that it rests on has changed, and only then."""

import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from nao_course.exercises.checking import unpack
from nao_course.instructor.authoring import proofs
from nao_course.instructor.authoring.plans import CHECKS, PlanError, load_plan, publish
from nao_course.instructor.authoring.proofs import FOLDER, MANIFEST, Proofs
from tests.paths import PROJECT
from tests.toy import toy

NAME = toy.LESSON
LATER, EARLIER = "91_later", "89_earlier"


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A course of three lessons and a library, all of it free to be changed; and who was proven, in order."""
    folder = toy.solutions(tmp_path / "solutions")
    for name in (LATER, EARLIER):
        toy.write(folder / f"{name}.ipynb", *toy.SOLUTION)
    library = tmp_path / "nao_course"
    for file in ("geometry.py", *(f"lessons/{name}/worlds.py" for name in ("toy", "later", "earlier"))):
        (library / file).parent.mkdir(parents=True, exist_ok=True)
        (library / file).write_text("")
    monkeypatch.setattr(proofs, "LIBRARY", library)
    return tmp_path


class Proven(list):
    def __init__(self):
        self.exercises = []


@pytest.fixture
def proven(monkeypatch):
    """Names of the lessons that were proven, one for each time; here they are all right.

    `proven.exercises` are the names of the exercises, one for each time.
    """
    names = Proven()

    def check_plan(name, plan, reference, taken, proven_already):
        names.append(name)
        names.exercises += [each.name for each in plan.exercises if each.name not in proven_already]
        return publish(name, plan, reference).exercises

    monkeypatch.setattr(proofs, "check_plan", check_plan)
    return names


def proofs_of(place, change_plan=lambda plan: plan, **options):
    """As a build begins: everything is read anew."""
    declaration = place / "solutions" / "exercises" / f"{NAME}.py"
    plan = change_plan(load_plan(declaration))
    empty = replace(plan, exercises=(), questions=(), written=())
    plans = {EARLIER: empty, NAME: plan, LATER: empty}
    files = {NAME: declaration, EARLIER: place / "no", LATER: place / "no"}
    return Proofs(place, files, plans, place / "solutions", **options)


def test_what_is_proven_is_proven_once_and_gives_the_same_bytes_also_in_a_fresh_clone(place, proven):
    first, second = (proofs_of(place).check_data(NAME) for _ in range(2))
    assert first == second and unpack(first).name == NAME
    assert commit(place) == first and not (place / FOLDER).exists()
    found = proofs_of(place)
    assert found.check_data(NAME) == first == found.committed(NAME) and found.is_vouched_for(NAME, first)
    assert proven == [NAME]


def append(file, text="\n# a comment\n"):
    return lambda place: (place / file).write_text((place / file).read_text() + text)


def another_solution(name, *cells):
    return lambda place: toy.write(place / "solutions" / f"{name}.ipynb", *toy.SOLUTION, *cells)


INPUTS = [
    *(append(f"nao_course/{at}.py") for at in ("geometry", "lessons/toy/worlds", "lessons/earlier/worlds")),
    append(f"solutions/exercises/{NAME}.py"),
    lambda place: (place / "nao_course" / "new.json").write_text("{}"),
    lambda place: (place / "nao_course" / "geometry.py").unlink(),
    *(another_solution(NAME, cell) for cell in (("solution", "x = 1"), ("setup", "import os"), "x = 1")),
    another_solution(NAME, ("display", "shown = 1")),
    another_solution(EARLIER, "helper = abs"),
]


def test_a_plan_with_the_courses_own_points_is_another(place, proven):
    proofs_of(place).check_data(NAME)
    for change in (
        lambda plan: replace(plan, exercises=[replace(each, points=9) for each in plan.exercises]),
        lambda plan: replace(plan, exercises=plan.exercises[:1]),
    ):
        proofs_of(place, change).check_data(NAME)
    assert proven == [NAME] * 3


@pytest.mark.parametrize(
    "change",
    [
        append("nao_course/lessons/later/worlds.py"),
        lambda place: (place / "nao_course" / "made.bin").write_text("check data of any lesson"),
        another_solution(NAME, ("display", "print(1)"), ("check", "check('clamp', clamp)")),
        another_solution(LATER, "helper = abs"),
    ],
)
def test_what_a_proof_does_not_rest_on_leaves_it_standing(place, proven, change):
    proofs_of(place).check_data(NAME)
    change(place)
    proofs_of(place).check_data(NAME)
    assert proven == [NAME]


def commit(place, **options):
    """Write the manifest and the check data, as a build does, and forget what is not committed."""
    found = proofs_of(place, **options)
    data = found.check_data(NAME)
    for path, content in ((CHECKS / f"{NAME}.bin", data), (MANIFEST, found.manifest({NAME: data}))):
        (place / path).parent.mkdir(parents=True, exist_ok=True)
        (place / path).write_bytes(content)
    shutil.rmtree(place / FOLDER)
    return data


@pytest.mark.parametrize("change", INPUTS)
def test_after_a_change_of_what_a_proof_rests_on_it_is_proven_anew(place, proven, change):
    data = commit(place)
    proofs_of(place).check_data(NAME)
    change(place)
    assert not proofs_of(place).is_vouched_for(NAME, data) and proofs_of(place).committed(NAME) is None
    for _ in range(2):
        proofs_of(place).check_data(NAME)
    assert proven == [NAME, NAME]


def edit(file, old, new):
    def change(place):
        path = place / "solutions" / file
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))

    return change


DECLARATION = f"exercises/{NAME}.py"


@pytest.mark.parametrize(
    ("change", "exercises"),
    [
        (edit(DECLARATION, "Swap min and max.", "Swap them."), ["clamp"]),
        (edit(f"{NAME}.ipynb", "float(positive.mean())", "positive.mean()"), ["mean_of_positive"]),
        (edit(f"{NAME}.ipynb", "import numpy as np", "import numpy"), ["clamp", "mean_of_positive"]),
        (append("nao_course/geometry.py"), ["clamp", "mean_of_positive"]),
        (append(f"solutions/{DECLARATION}"), []),
    ],
)
@pytest.mark.parametrize("committed", [False, True])
def test_an_edited_exercise_is_proven_alone(place, proven, change, exercises, committed):
    (commit if committed else lambda place: proofs_of(place).check_data(NAME))(place)
    assert proven.exercises == ["clamp", "mean_of_positive"]
    change(place)
    again = proofs_of(place).check_data(NAME)
    assert proven.exercises[2:] == exercises
    assert again == proofs_of(place, anew=True).check_data(NAME)


@pytest.mark.parametrize("of", proofs.COMPUTES)
def test_the_manifest_names_the_versions_and_another_version_is_proven_anew(place, proven, monkeypatch, of):
    data = commit(place)
    version = proofs.version
    assert f"{of} {version(of)}" in (place / MANIFEST).read_text()
    for different, proofs_made in ((False, 1), (True, 2)):
        with monkeypatch.context() as patched:
            if different:
                patched.setattr(proofs, "version", lambda name: "another" if name == of else version(name))
            assert proofs_of(place).is_vouched_for(NAME, data)
            assert (proofs_of(place).committed(NAME) is None) == different
            proofs_of(place).check_data(NAME)
        assert proven == [NAME] * proofs_made


@pytest.mark.parametrize(
    ("file", "harm"),
    [
        (CHECKS / f"{NAME}.bin", lambda file: flip(file)),
        (CHECKS / f"{NAME}.bin", lambda file: file.unlink()),
        *((MANIFEST, lambda file, text=text: file.write_bytes(text)) for text in (b"[1]", b"{", b"\xff")),
        (MANIFEST, lambda file: file.write_text(f'{{"{NAME}": 1}}')),
        (MANIFEST, lambda file: file.write_text(file.read_text().replace('"exercises"', '"exercise"'))),
        (MANIFEST, lambda file: file.unlink()),
    ],
)
def test_a_manifest_or_data_that_somebody_else_wrote_prove_nothing(place, proven, file, harm):
    data = commit(place)
    harm(place / file)
    assert proofs_of(place).check_data(NAME) == data
    assert proven == [NAME, NAME]


def test_the_manifest_keeps_other_lessons_and_forgets_those_that_are_gone(place, proven):
    commit(place)
    found = proofs_of(place)
    lines = json.loads(found.manifest({LATER: b"data"}))
    assert lines.keys() == {NAME, LATER}
    (place / MANIFEST).write_text(json.dumps(lines | {"92_gone": lines[NAME]}))
    assert json.loads(proofs_of(place).manifest({})) == lines


LOADED = """
import sys
from nao_course.instructor.authoring.proofs import Proofs
from nao_course.instructor.authoring.plans import load_plan
from tests.paths import SOLUTIONS

declarations = {path.stem: path for path in sorted((SOLUTIONS / "exercises").glob("[0-9]*.py"))}
plans = {name: load_plan(path) for name, path in declarations.items()}
Proofs(SOLUTIONS.parent, declarations, plans, SOLUTIONS)._prove(min(plans), {})
print(*(each.__file__ for each in list(sys.modules.values()) if getattr(each, "__file__", None)), sep="\\n")
"""


@pytest.mark.slow
def test_a_proof_loads_nothing_that_it_does_not_rest_on_and_parts_that_no_proof_loads_exist():
    words = [sys.executable, "-c", LOADED]
    ran = subprocess.run(words, cwd=PROJECT, capture_output=True, text=True, check=True)
    paths = [Path(line) for line in ran.stdout.splitlines()]
    loaded = [each.relative_to(proofs.LIBRARY).as_posix() for each in paths if proofs.LIBRARY in each.parents]
    assert "instructor/authoring/plan_checks.py" in loaded
    assert not [file for file in loaded if file.startswith(proofs.APART)]
    files = [path.relative_to(proofs.LIBRARY).as_posix() for path in proofs.LIBRARY.rglob("*")]
    assert not [each for each in proofs.APART if not any(file.startswith(each) for file in files)]


def test_all_is_proven_anew_where_that_is_wanted_and_where_no_proof_can_be_kept(place, proven):
    for _ in range(2):
        proofs_of(place, anew=True).check_data(NAME)
    assert proven == [NAME, NAME]
    shutil.rmtree((place / FOLDER).parent)
    (place / FOLDER).parent.write_text("a file where the folder would be")
    assert unpack(proofs_of(place).check_data(NAME)).name == NAME


def flip(file):
    content = bytearray(file.read_bytes())
    content[-1] ^= 1
    file.write_bytes(content)


@pytest.mark.parametrize(
    "harm",
    [
        flip,
        lambda file: file.write_bytes(b""),
        lambda file: file.write_bytes((file.parent / LATER).read_bytes()),
        lambda file: file.unlink(),
    ],
)
def test_a_proof_that_is_not_whole_or_of_another_lesson_does_not_count(place, proven, harm):
    data = [proofs_of(place).check_data(name) for name in (NAME, LATER)]
    harm(place / FOLDER / NAME)
    assert proofs_of(place).check_data(NAME) == data[0]
    assert proven == [NAME, LATER, NAME]


def test_what_is_wrong_is_said_each_time(place):
    def broken(plan):
        return replace(plan, exercises=[replace(plan["clamp"], mistakes=plan["clamp"].mistakes[:1] * 2)])

    for _ in range(2):
        with pytest.raises(PlanError, match="clamp: two mistakes are called"):
            proofs_of(place, broken).check_data(NAME)
    assert not (place / FOLDER).exists()
