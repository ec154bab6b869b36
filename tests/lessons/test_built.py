"""What is built is what is written: students' copies, executed solutions and the data of checks."""

import json
import os
import subprocess
import sys
import zipfile
from copy import deepcopy
from dataclasses import replace

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient

from nao_course.exercises.cells import is_solution
from nao_course.exercises.checking import grade_public, unpack
from nao_course.exercises.definitions import load_definitions
from nao_course.exercises.judging import is_unstable
from nao_course.instructor.authoring import build, execute, lesson_text, release, stamps
from nao_course.instructor.authoring.mistakes import with_functions
from nao_course.instructor.authoring.proofs import MANIFEST, Proofs
from nao_course.instructor.authoring.rounding_errors import same_but_for_rounding
from tests.lessons.every import (
    COURSE,
    FINISHED,
    PROJECT,
    each_lesson,
    earlier_functions_are_the_references,  # noqa: F401 - for every test here
    executed,
    public,
    reference,
    solved,
    student_copy,
)


def is_drawn(cell):
    """Whether a cell shows a picture, whose pixels differ between versions of OpenCV and matplotlib."""
    shown = [output.get("data", {}) for output in cell.get("outputs", ())]
    return any("image/png" in data or "data:image" in str(data.get("text/html", "")) for data in shown)


def run(notebook, folder, *, strict):
    """Execute a notebook as a student (not strict) or a test (strict) does."""
    environment = execute.environment(PROJECT) | {"NAO_COURSE_NOTEBOOKS": str(folder)}
    if not strict:
        del environment["NAO_COURSE_STRICT"]
    client = NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(folder)}})
    execute.run_all_cells(client, environment)


@each_lesson
def test_rubric_8_the_committed_check_data_are_proven(name):
    """A build proves each declaration: mistakes lose points with their own message, alternatives get all."""
    plans = {each: COURSE.plan(each) for each in COURSE.names()}
    declarations = {each: COURSE.declaration(each) for each in plans}
    proofs = Proofs(COURSE.root, declarations, plans, COURSE.solutions)
    data = COURSE.check_data(name).read_bytes()
    assert proofs.is_vouched_for(name, data), "run `nao-course build --no-solutions` and commit the rest"


@pytest.mark.slow
# Proving all of them again would take a quarter of an hour; this lesson takes the least time.
@pytest.mark.parametrize(("name", "prove"), [(name, name[:2] == "00") for name in COURSE.names()])
def test_what_is_committed_is_what_the_texts_say(name, prove):
    for path, content in build.build(COURSE, [name], solutions=False, prove=prove).files.items():
        there = (PROJECT / path).read_bytes()
        assert path == MANIFEST or same_but_for_rounding(path.suffix, there, content), (
            f"{path}: run `make build`"
        )


@pytest.mark.slow
def test_this_course_is_released_and_nothing_in_it_is_a_secret(tmp_path):
    path = release.make_release(replace(COURSE, chosen=FINISHED), tmp_path)
    inside = {name.removeprefix("nao-course/") for name in zipfile.ZipFile(path).namelist()}
    assert {f"release/notebooks/{name}.ipynb" for name in FINISHED} <= inside


PUBLISH = """
import sys
from pathlib import Path
from nao_course.exercises.checking import pack
from nao_course.exercises.earlier import resolved_by
from nao_course.instructor.authoring.plans import publish, solutions_beside
from tests.lessons.every import COURSE, PROJECT, reference

name, out = sys.argv[1:]
with resolved_by(solutions_beside(PROJECT / "solutions" / f"{name}.ipynb")):
    Path(out).write_bytes(pack(publish(name, COURSE.plan(name), reference(name))))
"""
OTHER_KERNELS = {
    "OPENBLAS_CORETYPE": "Nehalem",
    "NPY_DISABLE_CPU_FEATURES": " ".join(np.show_config("dicts")["SIMD Extensions"].get("found", [])),
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", COURSE.names(["08"]))  # one of the two with ill-conditioned cases
def test_check_data_of_another_processor_is_the_same_and_its_mistakes_are_recognised_here(name, tmp_path):
    """OpenBLAS, NumPy and the C library compute with the instructions of an older processor."""
    data = tmp_path / f"{name}.bin"
    environment = os.environ | OTHER_KERNELS | {"PYTHONPATH": str(PROJECT)}
    subprocess.run([sys.executable, "-c", PUBLISH, name, data], env=environment, check=True, cwd=PROJECT)
    ours, theirs = COURSE.check_data(name).read_bytes(), data.read_bytes()
    if ours == theirs:
        pytest.skip("this processor computes with the same rounding errors")
    assert same_but_for_rounding(".bin", ours, theirs)
    plan, lesson = with_functions(COURSE.plan(name), reference(name)), unpack(theirs)
    for exercise, declared in zip(lesson.exercises, plan.exercises, strict=True):
        messages = {mistake.message: mistake for mistake in exercise.mistakes}
        for mistake in declared.mistakes:
            told = set(grade_public(exercise, mistake.function).lines) & messages.keys()
            assert told, f"{exercise.name}: {mistake.name!r} is not recognised"
            if told != {mistake.message}:
                own, other = messages[mistake.message].answers, messages[told.pop()].answers
                assert own.keys() == other.keys(), f"{exercise.name}: {mistake.name!r} is taken for another"
                assert all(map(is_unstable, other.values())), "only rounding errors tell the two apart"


@each_lesson
def test_the_student_copy_and_the_executed_solution_are_those_of_the_text_they_would_be_written_as(name):
    given, written = (
        [(cell.id, cell.source) for cell in notebook.cells if not is_solution(cell)]
        for notebook in (student_copy(name), solved(name))
    )
    assert given == written, "run `make build`"
    stamps.refuse_what_is_not_built(COURSE, [name], executed=True)
    kept = json.dumps(executed(name).cells)
    assert "widget-view" not in kept and '"execution":' not in kept
    assert (PROJECT / "solutions" / f"{name}.ipynb").stat().st_size < execute.LARGEST
    assert lesson_text.write_lesson(deepcopy(executed(name))) == COURSE.text(name).read_text(encoding="utf-8")


@pytest.mark.slow
# Running all of them twice would take a quarter of an hour.
@pytest.mark.parametrize("name", COURSE.names(["05"]))
def test_building_twice_makes_the_same_bytes(name):
    assert build.build(COURSE, [name]).files == build.build(COURSE, [name]).files


@each_lesson
def test_rubric_16_the_student_copy_is_blank(name):
    notebook = student_copy(name)
    nbformat.validate(notebook)
    text = nbformat.writes(notebook)
    assert lesson_text.BEGIN not in text and lesson_text.END not in text, "run `make build`"
    assert not [cell for cell in notebook.cells if cell.get("outputs") or cell.get("execution_count")]
    ids = [cell.id for cell in notebook.cells]
    assert len(set(ids)) == len(ids)
    for _, cell in lesson_text.code_cells(notebook, "exercise"):
        assert "raise NotImplementedError" in cell.source
    assert notebook.metadata.nao_course.lesson == name
    if name in COURSE.names(COURSE.chosen):  # others are not released
        assert notebook.metadata.nao_course.version == COURSE.version, (
            "course.toml has another version: run `make build`"
        )


@pytest.mark.slow
@each_lesson
def test_rubric_16_the_blank_student_copy_runs_to_its_end_and_scores_nothing(name, tmp_path):
    notebook = deepcopy(student_copy(name))
    run(notebook, tmp_path, strict=False)
    outputs = [output for _, cell in lesson_text.code_cells(notebook) for output in cell.outputs]
    assert not [output for output in outputs if output.get("name") == "stderr" or "ename" in output]
    for _, cell in lesson_text.code_cells(notebook, "check"):
        assert "not written yet" in str(cell.outputs), lesson_text.exercise_name(cell)
    blank = load_definitions(PROJECT / "notebooks" / f"{name}.ipynb")
    for exercise in public(name).exercises:
        assert not grade_public(exercise, blank[exercise.name])


def test_rubric_16_built_notebooks_are_clean():
    command = [sys.executable, "-m", "ruff", "check", "--no-cache", "--config", "pyproject.toml"]
    checked = subprocess.run(
        [*command, "notebooks", "solutions"], cwd=PROJECT, capture_output=True, text=True
    )
    assert checked.returncode == 0, checked.stdout


@pytest.mark.slow
@each_lesson
def test_nbval_finds_the_stored_outputs_again(name, tmp_path):
    """Texts are compared, pictures only drawn; a check that does not pass raises."""
    notebook = tmp_path / f"{name}.ipynb"
    kept = deepcopy(executed(name))
    for _, cell in lesson_text.code_cells(kept):
        if is_drawn(cell):
            cell.metadata["tags"] = ["nbval-ignore-output"]
    nbformat.write(kept, notebook)
    options = ["--nbval", "-q", "-p", "no:cacheprovider", "-c", os.devnull, "--rootdir", str(tmp_path)]
    environment = execute.environment(PROJECT) | {"NAO_COURSE_NOTEBOOKS": str(PROJECT / "solutions")}
    command = [sys.executable, "-m", "pytest", *options, str(notebook)]
    ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout[-3000:]
