"""The same secret draws the same hidden cases, and whatever a score depends on is in an assignment's hash."""

import hashlib
import pickle
import shutil

import numpy as np
import pytest

from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.assignment import prepare
from tests.toy import chain


@pytest.fixture(scope="module")
def assignment(tmp_path_factory):
    return prepare(chain.make_course(tmp_path_factory.mktemp("course")), "90", chain.SECRET)


def test_the_same_secret_draws_the_same_cases_and_another_one_others(tmp_path, assignment):
    course = chain.make_course(tmp_path)
    same, other = (
        prepare(course, "90", chain.SECRET),
        prepare(course, "90", b"another secret of enough bytes"),
    )
    assert same.hash == assignment.hash != other.hash
    for mine, theirs, others in zip(assignment.tasks, same.tasks, other.tasks, strict=True):
        for one, two, three in zip(mine.hidden, theirs.hidden, others.hidden, strict=True):
            assert np.array_equal(one.args[0], two.args[0])
            assert not np.array_equal(one.args[0], three.args[0])
    assert not np.array_equal(same.tasks[0].hidden[0].args[0], same.tasks[1].hidden[0].args[0])


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("solutions/90_chain.ipynb", "return 2 * x", "return x + x"),
        ("solutions/exercises/90_chain.py", '"slip"', '"slop"'),
        ("course.toml", 'version = "1"', 'version = "1"\n[points]\ndouble = 5'),
        ("notebooks/90_chain.ipynb", "import numpy as np", "import numpy as np, math"),
    ],
)
def test_an_assignment_is_another_one_when_what_it_grades_by_changes(tmp_path, assignment, file, old, new):
    chain.make_course(tmp_path)
    text = (tmp_path / file).read_text()
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new))
    assert prepare(load_course(tmp_path), "90", chain.SECRET).hash != assignment.hash


def test_neither_the_secret_nor_a_seed_stands_in_an_assignment(assignment):
    data = pickle.dumps(assignment)
    assert chain.SECRET not in data
    assert hashlib.sha256(chain.SECRET).hexdigest().encode() not in data


def test_a_course_that_is_not_built_is_said(tmp_path):
    course = chain.make_course(tmp_path)
    shutil.rmtree(tmp_path / "notebooks")
    with pytest.raises(FileNotFoundError, match="nao-course build"):
        prepare(course, "90", chain.SECRET)
