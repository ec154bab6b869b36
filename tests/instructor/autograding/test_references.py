"""An earlier exercise that is missing or wrong costs its own points, and the page says what was run instead."""

import json
from contextlib import ExitStack
from dataclasses import replace
from itertools import count
from types import SimpleNamespace

import pytest

from nao_course.exercises import earlier as earlier_module
from nao_course.exercises.earlier import Calls
from nao_course.exercises.running import Outcome
from nao_course.instructor.autograding import grader as grader_module
from nao_course.instructor.autograding import references as references_module
from nao_course.instructor.autograding import tries as tries_module
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.grader import Stopped, grade
from nao_course.instructor.autograding.references import STOOD_IN, References, recorded
from nao_course.instructor.collecting.files import submission_hash
from nao_course.instructor.collecting.submissions import Submission, with_earlier
from nao_course.instructor.sandbox.protocol import Allowance
from tests.sandboxed import quickly
from tests.toy import pair

AMPLE = 60.0  # seconds for a call that has to succeed, however busy the machine


@pytest.fixture(scope="module")
def assignment(tmp_path_factory):
    course = pair.make_course(tmp_path_factory.mktemp("course"))
    return replace(prepare(course, "81", pair.SECRET), seconds=AMPLE)


@pytest.fixture
def marked(warm_server, assignment, tmp_path):
    """Grade a notebook of the second lesson, beside one of the first or none."""

    def grade_it(functions=None, first=None, *, seconds=AMPLE, handed_in=True, given=assignment, **more):
        folder = tmp_path / "ada"
        made = Submission("ada", pair.SECOND, pair.write(folder / "2.ipynb", pair.SECOND, functions, **more))
        if handed_in:
            content = first if isinstance(first, bytes) else None
            earlier = pair.write(folder / f"{pair.FIRST}.ipynb", pair.FIRST, None if content else first)
            if content:
                earlier.write_bytes(content)
            made = replace(made, earlier=(Submission("ada", pair.FIRST, earlier),))
        return grade(made, replace(given, seconds=seconds), warm_server)

    return grade_it


def earned(result):
    return {each.name: each.earned for each in result.exercises}


def of(result, name):
    return next(each for each in result.exercises if each.name == name)


ALL = {name: float(points) for name, points in pair.POINTS.items()}
STOOD_IN_FOR = ALL | {"walk": 2.0}
WALKER = pair.RIGHT[pair.SECOND]["Walker"]


def test_earlier_work_that_was_handed_in_is_used_with_the_set_up_cell_of_the_release(marked, monkeypatch):
    result = marked()
    assert earned(result) == ALL
    assert not any(each.with_reference or each.notes for each in result.exercises) and result.notes == ()
    edited = "from nao_course.student import earlier\ndouble = earlier('80:Counter')"
    monkeypatch.setitem(pair.SETUP, pair.SECOND, edited)
    assert earned(marked())["quadruple"] == 1


@pytest.mark.parametrize("first", [None, b"{"], ids=["missing", "no notebook"])
def test_without_earlier_work_it_is_judged_with_the_references_and_says_so(marked, first):
    result = marked(first=first, handed_in=first is not None)
    assert earned(result) == STOOD_IN_FOR
    quadruple, tally = of(result, "quadruple"), of(result, "tally")
    assert quadruple.with_reference and tally.with_reference
    assert "Run again with the reference's double of lesson 80 instead of yours: it is" in quadruple.notes[0]
    assert ("Of lesson 80 there is no notebook of yours" in quadruple.notes[0]) == (first is None)
    assert "all 2 public checks pass" in quadruple.public[0]  # as the check says that is run in the notebook
    assert quadruple.public[-1] == STOOD_IN


def test_wrong_earlier_work_costs_nothing_here_and_a_wrong_function_of_their_own_does(marked):
    result = marked(first={"double": "def double(x):\n    return x"})
    assert earned(result) == STOOD_IN_FOR
    quadruple = of(result, "quadruple")
    assert "lesson 80 came from the 80_first.ipynb that you handed in." in quadruple.notes[0]
    assert "all 2 public checks pass" in quadruple.public[0] and quadruple.public[-1] == STOOD_IN
    own = of(marked({"quadruple": "def quadruple(x):\n    return double(x)"}), "quadruple").public
    assert "all 2" not in own[0] and STOOD_IN not in own
    wrong = marked({"tally": "def tally(x):\n    return Counter().total()"}, first={"Counter": "pass"})
    assert earned(wrong) == ALL | {"tally": 0.0}
    said = "reference's Counter of lesson 80 instead of yours: it is not right either"
    assert said in of(wrong, "tally").notes[0]


def test_a_wrong_class_of_the_lesson_is_replaced_where_another_exercise_uses_it(marked):
    wrong = WALKER.replace("+=", "-=")
    heir = "class Heir(Walker):\n    pass\n" + pair.RIGHT[pair.SECOND]["walk"].replace("Walker(", "Heir(")
    result = marked({"Walker": wrong})
    said = "Run again with the reference's Walker and quadruple instead of yours"
    assert said in of(result, "walk").notes[0]
    for each in (result, marked({"Walker": wrong, "walk": heir}), marked({"Walker": "pass"})):
        assert earned(each) == STOOD_IN_FOR | {"Walker": 0.0}
    both = marked({"Walker": "pass", "quadruple": "def quadruple(x):\n    return x"})
    assert earned(both) == STOOD_IN_FOR | {"Walker": 0.0, "quadruple": 0.0}


def test_what_an_answer_or_the_reference_uses_undeclared_stands_in_as_well(marked, tmp_path, monkeypatch):
    helper = "def twice(x):\n    return double(x)\n"
    undeclared = {"alone": "def alone(x):\n    return twice(x) - x + 1"}
    alone = of(marked(undeclared, handed_in=False, before=helper), "alone")
    assert alone.earned == ALL["alone"]
    assert "reference's double of lesson 80 instead of yours: it is right" in alone.notes[0]
    walker = WALKER.replace("self.at = start", "self.at = double(start) / 2")
    assert earned(marked({"Walker": walker}, handed_in=False)) == STOOD_IN_FOR
    monkeypatch.setitem(pair.RIGHT[pair.SECOND], "Walker", walker)
    given = prepare(pair.make_course(tmp_path / "course"), "81", pair.SECRET)
    result = marked({"Walker": "pass"}, handed_in=False, given=given)
    assert earned(result) == STOOD_IN_FOR | {"Walker": 0.0}


def test_who_reads_the_references_class_or_patches_the_driver_gains_nothing(marked):
    steals = pair.RIGHT[pair.SECOND]["alone"].replace("return x + 1", "return KEPT.at + 1")
    keeps = "KEPT = None\ndef walk(x):\n    global KEPT\n    KEPT = Walker(x)\n    KEPT.move(1.0)\n"
    keeps += "    return KEPT.estimate() + quadruple(x)"
    result = marked({"Walker": "pass", "walk": keeps, "alone": steals})
    assert earned(result) == ALL | {"Walker": 0.0, "walk": 2.0, "alone": 0.0}
    told = json.dumps([[each.text, each.line, each.public, each.notes] for each in result.exercises])
    assert "self.at" not in told
    patch = (
        "from nao_course.exercises import running, earlier as other\n"
        "running._DRIVERS['methods'] = lambda made_by, given, turns: [(name, 0.0) for name, _ in turns]\n"
        "other.assigned_use = None\n"
        "def earlier(use): return lambda *_: 0.0"
    )
    result = marked({"Walker": "class Walker: pass"}, before=patch)
    assert earned(result)["Walker"] == 0.0 and earned(result)["alone"] == 16


HOSTILE = {
    "endless": "while_ = 1\nif True:\n    while True: pass",
    "killing": "import os\nx = os._exit(3)",
    "huge": "x = bytearray(2**40)",
    "reading": "x = open('/etc/shadow').read()",
    "patching": "import nao_course.exercises.earlier as e, nao_course.exercises.running as r\n"
    "e.EarlierFunction.__call__ = lambda *_: 1.0\nr._DRIVERS['methods'] = lambda *_: []",
}


@pytest.mark.parametrize("kind", quickly(HOSTILE, "killing", "patching"))
def test_a_hostile_earlier_notebook_costs_only_what_uses_it(marked, kind):
    result = marked(first={"double": HOSTILE[kind]}, seconds=2.0 if kind == "endless" else AMPLE)
    assert earned(result)["alone"] == 16 and result.status == "graded"
    assert earned(result)["quadruple"] == (0.0 if kind == "patching" else 1.0)


@pytest.mark.parametrize("warm", [True, False])
def test_helper_files_of_two_lessons_may_have_one_name(assignment, warm_server, tmp_path, warm):
    made = {}
    for lesson, helper, functions in (
        (pair.FIRST, "def help(x): return 2 * x", {"double": "from mine import help as double"}),
        (pair.SECOND, "def help(x): return x + 1", {"alone": "from mine import help as alone"}),
    ):
        path = pair.write(tmp_path / lesson / f"{lesson}.ipynb", lesson, functions)
        path.with_name("mine.py").write_text(helper)
        made[lesson] = Submission("ada", lesson, path, (("mine.py", path.with_name("mine.py")),))
    submission = replace(made[pair.SECOND], earlier=(made[pair.FIRST],))
    result = grade(submission, assignment, warm_server if warm else None)
    assert earned(result) == ALL, [(each.name, each.text, each.line) for each in result.exercises]


@pytest.fixture
def references(assignment):
    with ExitStack() as stack:
        yield lambda given=assignment, seconds=5.0, spent=None: References(
            given, None, stack, seconds, spent or Allowance()
        )


def test_what_is_lent_has_its_own_earlier_lessons_and_says_nothing_but_its_answer(references, assignment):
    made = references()
    outcome = Outcome("raised", text="ValueError", line="line 3: the solution's", output="its print")
    made.workers["80"] = SimpleNamespace(call=lambda *_: outcome)
    assert made.function("80:double")((1.0,), {}) == Outcome("raised", text="ValueError")
    first = assignment.earlier[0]
    earlier = (first, replace(first, lesson=pair.SECOND))
    made = references(replace(assignment, lesson="82_third", earlier=earlier))
    found = {number: [each.lesson for each in made.worker(number).earlier] for number in ("80", "81", "")}
    assert found == {"80": [], "81": [pair.FIRST], "": [pair.FIRST, pair.SECOND]}


FLOOD = """
def quadruple(x):
    for number in range(2000):
        try:
            double(x + number)
        except Exception:
            pass
    return x
"""


@pytest.mark.slow
def test_a_flood_of_questions_ends_with_the_time_to_answer_them(marked, monkeypatch):
    monkeypatch.setattr(tries_module, "SECONDS_OF_RECORDED", 0.5)
    answered = count()
    real = Calls.answer
    monkeypatch.setattr(Calls, "answer", lambda *words: (next(answered), real(*words))[1])
    # Every answer takes 1 ms by this clock, however fast the machine is.
    clock = count()
    monkeypatch.setattr(references_module, "time", SimpleNamespace(thread_time=lambda: 1e-3 * next(clock)))
    result = marked({"quadruple": FLOOD}, handed_in=False)
    assert 0 < next(answered) <= 501  # the last may begin with less than 1 ms left
    assert of(result, "alone").earned == 16


def test_who_stops_the_grader_does_not_wait_for_a_flood_of_questions(assignment, warm_server, tmp_path):
    asked = count()
    flood = second_of(tmp_path, {"quadruple": FLOOD})
    with pytest.raises(Stopped):
        grade(flood, assignment, warm_server, stopped=lambda: next(asked) > 200)


def test_recorded_answers_are_looked_up_by_a_digest(assignment, monkeypatch):
    exercise = next(task.public for task in assignment.tasks if task.public.name == "quadruple")
    compared = count()
    real = earlier_module._same
    monkeypatch.setattr(earlier_module, "_same", lambda *words: (next(compared), real(*words))[1])
    (answer,) = recorded(exercise, Allowance()).values()
    for _ in range(100):
        assert answer((1.5,), {}).value == 3.0
        assert answer((), {"x": 1.5}).value == 3.0
        assert answer((1.5 + 1e-12,), {}).value == 3.0, "up to rounding"
        assert answer((7.0,), {}).status == "raised"
    assert next(compared) <= 3 * len(exercise.earlier)


@pytest.mark.slow
def test_notebooks_with_large_outputs_are_graded_in_the_space_that_a_worker_has(marked, tmp_path):
    large = json.loads(pair.write(tmp_path / "x.ipynb", pair.FIRST).read_bytes())
    large["cells"][-1]["outputs"] = [{"output_type": "stream", "name": "stdout", "text": "x" * 49 * 2**20}]
    content = json.dumps(large).encode()
    assert earned(marked(first=content)) == ALL


def test_what_is_asked_of_the_reference_has_the_time_of_one_submission(references):
    spent = Allowance()
    made = references(seconds=AMPLE, spent=spent)
    assert made.function("80:double")((1.0,), {}).value == 2.0
    assert 0 < spent.spent < spent.seconds
    spent.spent = spent.seconds
    assert made.function("80:double")((1.0,), {}).status == "timed out"
    assert made.function("quadruple")((1.0,), {}).status == "timed out", "one for all lessons"


@pytest.fixture
def noted(monkeypatch):
    """Return what `References` was given, each time."""
    given = []

    class Noted(References):
        def __init__(self, *args):
            given.append(args)
            super().__init__(*args)

    monkeypatch.setattr(grader_module, "References", Noted)
    return given


def test_all_tries_share_the_time_of_the_reference_and_each_exercise_has_its_own(
    assignment, warm_server, tmp_path, monkeypatch, noted
):
    tries, real = iter([1, 1, 0]), grader_module._grade
    monkeypatch.setattr(grader_module, "_grade", lambda *args: (real(*args)[0], next(tries)))
    tasks = [replace(task, public=replace(task.public, seconds=2 * AMPLE)) for task in assignment.tasks]
    grade(second_of(tmp_path), replace(assignment, tasks=tuple(tasks)), warm_server)
    spent = [args[-1] for args in noted]
    assert len(spent) == 2 * len({id(each) for each in spent})
    assert len({id(each.common) for each in spent}) == 1
    assert {args[-2] for args in noted} == {2 * AMPLE}, "the time of the exercise that calls it"


def second_of(folder, functions=None):
    return Submission("ada", pair.SECOND, pair.write(folder / f"{pair.SECOND}.ipynb", pair.SECOND, functions))


@pytest.mark.slow
def test_what_the_second_run_does_counts_like_the_first(assignment, warm_server, tmp_path, monkeypatch):
    deaths, real = [], grader_module._grade

    def noted(*args):
        result, died = real(*args)
        deaths.append(died)
        return result, died

    monkeypatch.setattr(grader_module, "_grade", noted)
    ends = "import os\ndef walk(x):\n    if Walker:\n        open('/etc/of_the_second_run')"
    functions = {
        "Walker": "Walker = None",
        "walk": ends.replace("open(", "try: open(") + "\n        except OSError: os.kill(os.getpid(), 9)",
    }
    result = grade(second_of(tmp_path, functions), assignment, warm_server)
    assert of(result, "walk").state == "died" and deaths == [deaths[0]] * 2 and deaths[0] > 0
    assert warm_server.forks is False or "of_the_second_run" in " ".join(result.notes)
    deaths.clear()
    monkeypatch.setattr(References, "deaths", 1)  # ended by somebody outside
    grade(second_of(tmp_path), assignment, warm_server)
    assert deaths[0] == 4  # of the four exercises that were run again


def test_a_submission_has_changed_when_its_earlier_work_has(tmp_path):
    second = Submission("ada", pair.SECOND, pair.write(tmp_path / "b.ipynb", pair.SECOND))
    first = Submission("ada", pair.FIRST, pair.write(tmp_path / "a.ipynb", pair.FIRST))
    (both,) = with_earlier([second], {("ada", pair.FIRST): first}, lambda lesson: [pair.FIRST])
    assert both.earlier == (first,) and submission_hash(both) != submission_hash(second)
    before = submission_hash(both)
    pair.write(tmp_path / "a.ipynb", pair.FIRST, {"double": "pass"})
    assert submission_hash(both) != before
    first.path.unlink()
    assert submission_hash(both) == submission_hash(second)
    assert with_earlier([second], {("bob", pair.FIRST): first}, lambda lesson: [pair.FIRST]) == [second]
