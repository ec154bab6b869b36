"""The same secret draws the same hidden cases, and whatever a score depends on is in an assignment's hash."""

import hashlib
import pickle
import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.codec import encode
from nao_course.exercises.checking import pack, unpack
from nao_course.instructor.authoring.course import LessonError, load_course
from nao_course.instructor.authoring.plans import load_solution
from nao_course.instructor.authoring.proofs import MANIFEST, Proofs
from nao_course.instructor.autograding import assignment as module
from nao_course.instructor.autograding.assignment import class_source, lessons_used, library_digest, prepare
from tests.paths import PROJECT
from tests.toy import chain, pair, toy


@pytest.fixture(scope="module")
def assignment(tmp_path_factory):
    return prepare(chain.make_course(tmp_path_factory.mktemp("course")), "90", chain.SECRET)


def test_the_same_secret_draws_the_same_cases_and_it_stands_nowhere(tmp_path, assignment):
    course = chain.make_course(tmp_path)
    same, other = (prepare(course, "90", each) for each in (chain.SECRET, b"another secret of enough bytes"))
    assert same.hash == assignment.hash != other.hash
    for mine, theirs, others in zip(assignment.tasks, same.tasks, other.tasks, strict=True):
        for one, two, three in zip(mine.hidden, theirs.hidden, others.hidden, strict=True):
            assert np.array_equal(one.args[0], two.args[0])
            assert not np.array_equal(one.args[0], three.args[0])
    assert not np.array_equal(same.tasks[0].hidden[0].args[0], same.tasks[1].hidden[0].args[0])
    data = pickle.dumps(assignment)
    assert chain.SECRET not in data and hashlib.sha256(chain.SECRET).hexdigest().encode() not in data


@pytest.mark.parametrize(
    ("lesson", "file", "old", "new"),
    [
        ("90", "solutions/90_chain.ipynb", "return 2 * x", "return x + x"),
        ("90", "solutions/exercises/90_chain.py", '"slip"', '"slop"'),
        ("90", "course.toml", 'version = "1"', 'version = "1"\n[points]\ndouble = 5'),
        ("90", "notebooks/90_chain.ipynb", "import numpy as np", "import numpy as np, math"),
        ("81", f"solutions/{pair.FIRST}.ipynb", "return 2 * x", "return x + x"),
        ("81", f"notebooks/{pair.FIRST}.ipynb", "import numpy as np", "import numpy as np, math"),
    ],
)
def test_an_assignment_is_another_one_when_what_it_grades_by_changes(tmp_path, lesson, file, old, new):
    """Lesson 81 uses functions of an earlier lesson, whose files count too."""
    course = (chain if lesson == "90" else pair).make_course(tmp_path)
    before = prepare(course, lesson, chain.SECRET).hash
    path = course.root / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    assert prepare(load_course(course.root), lesson, chain.SECRET).hash != before


def test_what_an_earlier_lesson_uses_is_used_too_and_a_class_has_the_source_of_a_solutions_cell(tmp_path):
    uses = {"01_a": (), "02_b": ("01:a",), "03_c": ("b", "02:b"), "04_d": ()}
    plans = {name: SimpleNamespace(exercises=[SimpleNamespace(uses=each)]) for name, each in uses.items()}
    course = SimpleNamespace(names=lambda: list(plans), plan=plans.__getitem__)
    assert lessons_used(course, "03_c") == ["01_a", "02_b"] and lessons_used(course, "04_d") == []
    path = toy.write(tmp_path / "x.ipynb", ("student", "class A: pass"), ("solution", "class A:\n    x = 1"))
    assert class_source(path, "A") == "class A:\n    x = 1"
    assert class_source(path, "B") == ""


COUNTS = ("exercises/comparisons/new.py", "geometry.py", "sim/camera.py", "lessons/chain/drivers.py")
OF_OTHERS = ("lessons/other/drivers.py", "plotting/maps.py", "instructor/commands/grading.py", "cli.py")


@pytest.fixture
def library(tmp_path, monkeypatch):
    """A library whose files can be edited."""
    for name in (*COUNTS, *OF_OTHERS):
        (tmp_path / "library" / name).parent.mkdir(parents=True, exist_ok=True)
        if "new" not in name:
            (tmp_path / "library" / name).write_text("x = 1\n")
    monkeypatch.setattr(module, "LIBRARY", tmp_path / "library")
    library_digest.cache_clear()
    yield tmp_path / "library"
    library_digest.cache_clear()


@pytest.mark.parametrize("name", [*COUNTS, *OF_OTHERS])
def test_an_assignment_is_another_one_when_the_library_that_it_grades_with_changes(tmp_path, library, name):
    course = chain.make_course(tmp_path / "course")
    before = prepare(course, "90", chain.SECRET).hash
    for path in library.rglob("*.py"):
        path.write_bytes(b"x = 1\r\n")  # the line ends of Windows are no change
    library_digest.cache_clear()
    assert prepare(course, "90", chain.SECRET).hash == before
    (library / name).write_text("x = 2\n")
    library_digest.cache_clear()
    assert (prepare(course, "90", chain.SECRET).hash != before) == (name in COUNTS)


def test_pairs_of_mistakes_come_from_the_built_check_data(tmp_path, assignment):
    course = load_course(PROJECT)
    built = unpack(course.check_data("00_meet_the_nao").read_bytes())
    (task,) = prepare(course, "00", chain.SECRET).tasks
    assert task.public.pairs and encode(task.public.pairs) == encode(built.exercises[0].pairs)
    assert not any(each.public.pairs for each in assignment.tasks)  # this course has no check data


def test_what_is_proven_is_not_made_again_and_is_the_same(tmp_path, assignment, monkeypatch):
    """Making it runs all mistakes; in lesson 11 that took nine tenths of the wait for the first result."""
    course = chain.make_course(tmp_path)
    name, declaration = chain.LESSON, course.declaration(chain.LESSON)
    plan, made, real = course.plan(name), [], module.publish
    proofs = Proofs(course.root, {name: declaration}, {name: plan}, course.solutions)
    data = pack(real(name, plan, load_solution(course.solutions / f"{name}.ipynb")))
    course.check_data(name).parent.mkdir(parents=True)
    course.check_data(name).write_bytes(data)
    (course.root / MANIFEST).write_bytes(proofs.manifest({name: data}))
    monkeypatch.setattr(
        module, "publish", lambda *given, **named: made.append(given) or real(*given, **named)
    )
    proven = prepare(course, "90", chain.SECRET)
    assert made == [] and proven.hash == assignment.hash
    without_pairs = [encode(replace(each.public, pairs=[])) for each in proven.tasks]
    assert without_pairs == [encode(each.public) for each in assignment.tasks]
    declaration.write_text(declaration.read_text() + "\n# Changed")
    prepare(load_course(course.root), "90", chain.SECRET)
    assert len(made) == 1


def test_missing_notebooks_and_damaged_check_data_are_named_with_what_to_do(tmp_path):
    course = chain.make_course(tmp_path)
    path = course.check_data(chain.LESSON)
    path.parent.mkdir(parents=True)
    for keep in (0, 1000):
        path.write_bytes(load_course(PROJECT).check_data("01_hsl_filtering").read_bytes()[:keep])
        with pytest.raises(LessonError, match=r"90_chain.bin is damaged: run `nao-course build 90`"):
            prepare(course, "90", chain.SECRET)
    shutil.rmtree(tmp_path / "notebooks")
    with pytest.raises(FileNotFoundError, match="nao-course build"):
        prepare(course, "90", chain.SECRET)
