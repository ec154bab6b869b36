"""A notebook's own checks, `nao-course check` and the grader agree on each odd notebook, or they say why not."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest

from nao_course.exercises.checking import lessons
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.grader import grade
from nao_course.instructor.collecting.submissions import Submission
from nao_course.instructor.gradebook.scores import score
from nao_course.instructor.reports.feedback import said_of
from tests.real_life.notebooks import FAILING, INTERACTIVE, corpus, exercises_of, solved
from tests.real_life.verdicts import both, processes

SECRET = b"a secret of sixteen bytes, or more"
QUICK = ["01_hsl_filtering", "04_distance"]
SLOWEST = "11_slam_on_the_field"  # to judge one notebook takes 45 seconds
WITH_FUNCTIONS = [lesson for lesson in lessons() if exercises_of(lesson)]


def test_there_are_many_kinds_of_odd_notebooks():
    made = corpus(QUICK)
    assert len(made) >= 150 and len({odd.name for odd, _, _ in made}) == len(made)


# Lessons, and which share of the kinds is tried in them: all kinds in two lessons, and some in each of the others.
TRIED = [
    (QUICK, 8),
    pytest.param(QUICK, 1, marks=pytest.mark.slow),
    *(
        pytest.param([each], 72, marks=pytest.mark.slow)
        for each in WITH_FUNCTIONS
        if each not in (*QUICK, SLOWEST)
    ),
]


@pytest.mark.parametrize(("chosen", "share"), TRIED)
def test_the_three_verdicts_agree_or_the_difference_is_stated(chosen, share, tmp_path, warm_server):
    made = corpus(chosen)[WITH_FUNCTIONS.index(chosen[0]) % share :: share]
    paths = []
    for number, (odd, lesson, exercise) in enumerate(made):
        notebook = solved(lesson, exercise)
        odd.change(notebook)
        paths.append(notebook.write(tmp_path / str(number)))
    course = load_course()
    assignments = {lesson: prepare(course, lesson, SECRET) for lesson in chosen}

    def graded(path):
        helpers = tuple((helper.name, helper) for helper in sorted(path.parent.glob("*.py")))
        submission = Submission("ada", path.stem, path, helpers, file=path.name)
        return grade(submission, assignments[path.stem], warm_server, "full")

    with processes(2) as pool, ThreadPoolExecutor(2) as threads:
        others = list(pool.map(both, paths, [exercise for _, _, exercise in made]))
        results = list(threads.map(graded, paths))
    wrong = []
    for (odd, lesson, exercise), (jupyter, terminal, said), result in zip(made, others, results, strict=True):
        mine = next(each for each in result.exercises if each.name == exercise)
        right = mine.state == "right"
        page = " ".join(each.text for each in said_of(score(result), mine)) + " ".join(result.left_out)
        known = odd.name.removesuffix(" inside")
        if known in INTERACTIVE and right is not INTERACTIVE[known][1]:
            wrong.append(f"{odd.name}, {lesson}, {exercise}: the grader says {mine.state}")
        if odd.name.removeprefix("fails: ") in FAILING and right:
            wrong.append(f"{odd.name}, {lesson}, {exercise}: the grader accepts it")
        if not jupyter == terminal == right and not all(
            map(partial(states, exercise), (page, " ".join(result.notes)))
        ):
            verdicts = f"Jupyter {jupyter}, terminal {terminal} ({said}), grader {mine.state}"
            wrong.append(f"{odd.name}, {lesson}, {exercise}: {verdicts}, page: {page}, notes: {result.notes}")
    assert not wrong, "\n".join(wrong)


def states(exercise, text):
    """Return whether a text names a cell or the exercise, so that a person finds the cause of a difference."""
    return "cell" in text.lower() or exercise in text
