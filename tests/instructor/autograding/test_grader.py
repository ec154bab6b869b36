"""A score is what the hidden cases say, and neither it nor its feedback tells what they are."""

import json
import pickle
import re
from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.exercise import ANSWER_HERE
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.plans import load_solution
from nao_course.instructor.autograding import grader as module
from nao_course.instructor.autograding import tries as tries_module
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.failures import CHANGES_INPUT
from nao_course.instructor.autograding.grader import GraderError, Stopped, grade
from nao_course.instructor.collecting.submissions import Submission
from nao_course.instructor.gradebook.records import as_json, from_json
from nao_course.instructor.sandbox.protocol import ServerEnded
from tests.exercises.test_odd_notebooks import MESS, cells_of
from tests.paths import PROJECT
from tests.sandboxed import quickly
from tests.toy import chain

AMPLE = 60.0  # seconds for a call that has to succeed, however busy the machine


@pytest.fixture(scope="module")
def assignment(tmp_path_factory):
    course = chain.make_course(tmp_path_factory.mktemp("course"))
    return prepare(course, "90", chain.SECRET).within(AMPLE)


@pytest.fixture
def marked(warm_server, assignment, tmp_path):
    """Grade a notebook of some functions; return its result."""

    def grade_it(functions=None, *, given=assignment, helpers=None, content=None, seconds=AMPLE, **more):
        path = chain.hand_in(tmp_path, "ada", content or chain.notebook(functions, **more))
        beside = tuple((name, path.with_name(name)) for name in helpers or {})
        for name, source in (helpers or {}).items():
            path.with_name(name).write_text(source)
        submission = Submission("ada", chain.LESSON, path, beside, file="ada/x.ipynb")
        result = grade(submission, given.within(seconds), warm_server, "full")
        assert from_json(json.loads(json.dumps(as_json(result)))) == result
        return result

    return grade_it


@pytest.fixture
def handed_in(tmp_path):
    """Return a submission of a right notebook."""
    path = chain.hand_in(tmp_path, "ada", chain.notebook())
    return Submission("ada", chain.LESSON, path, file="ada/x.ipynb")


def states(result):
    return {each.name: each.state for each in result.exercises}


def of(result, name):
    return next(each for each in result.exercises if each.name == name)


def hidden_numbers(assignment):
    values = [case.args[0] for task in assignment.tasks for case in task.hidden]
    shown = {f"{abs(number):.3f}"[:5] for value in values for number in value.ravel()}
    return shown | {each.replace(".", "") for each in shown if not each.startswith("0")}


def told_to_the_student(result):
    told = [[each.text, each.line, each.public, each.hint, each.notes] for each in result.exercises]
    return json.dumps(told)


def test_the_solution_gets_all_points_and_a_blank_copy_none(marked):
    result = marked()
    assert set(states(result).values()) == {"right"}
    assert (result.earned, result.points) == (7.0, 7.0)
    assert [each.number for each in result.exercises] == ["90.1", "90.2", "90.3", "90.4"]
    assert all(each.passed == each.cases == 3 and each.text == "" for each in result.exercises)
    assert (result.status, result.level, result.file) == ("graded", "full", "ada/x.ipynb")
    assert result.seconds > 0 and result.notes == ()
    result = marked(chain.BLANK)
    assert set(states(result).values()) == {"not attempted"} and result.earned == 0
    assert not any(each.with_reference for each in result.exercises)


@pytest.mark.parametrize("content", [None, b""])
def test_lateness_and_the_time_are_kept_and_cost_nothing(warm_server, assignment, handed_in, content):
    if content is not None:
        handed_in.path.write_bytes(content)
    late = replace(handed_in, late=True, handed_in="2026-11-20 22:10+00:00")
    one, other = (grade(each, assignment, warm_server, "full") for each in (handed_in, late))
    assert other == replace(one, late=True, handed_in="2026-11-20 22:10+00:00")


def counting(name, body):
    """Return the source of a function that counts its calls, by name."""
    return {name: f"def {name}(x):\n    {name}.n = getattr({name}, 'n', 0) + 1\n    return {body}"}


def test_points_are_all_or_nothing_and_a_mistake_is_named_with_its_hint(marked):
    double = of(marked(counting("double", "2 * x + (double.n == 5)")), "double")
    assert (double.state, double.passed, double.earned) == ("wrong", 2, 0)
    result = marked(chain.MISTAKES)
    assert result.earned == 0
    for each in result.exercises:
        assert (each.state, each.mistake) == ("wrong", "slip")
        assert each.hint == f"That is the slip in {each.name}."
        assert each.hint not in each.public and "0 of 2 public checks" in each.public[0]
    double = of(marked({"double": "def double(x):\n    x *= 2\n    return x"}), "double")
    assert (double.state, double.earned, double.text) == ("changes its input", 0, CHANGES_INPUT)


@pytest.mark.parametrize(
    ("wrong_at", "earned", "part"),
    [(6, 0.5, "0.5 of 2 points: first"), (5, 1.5, "1.5 of 2 points: rest"), (0, 2, "")],
)
def test_each_part_whose_hidden_cases_all_pass_earns_its_share(marked, assignment, wrong_at, earned, part):
    source = counting("double", f"2 * x + (double.n == {wrong_at})")
    result = of(marked(source, given=in_parts(assignment, "double", 1, 3)), "double")
    said = part.replace(":", " for the right parts:")
    assert (result.earned, result.notes) == (earned, (f"{said}.",) if said else ())
    assert result.state == ("wrong" if wrong_at else "right")


def test_right_parts_earn_their_share_also_with_the_references_functions(marked, assignment):
    wrong = {"double": chain.MISTAKES["double"]} | counting("both", "plus_one(double(x)) + (both.n == 8)")
    result = of(marked(wrong, given=in_parts(assignment, "both", 1, 3)), "both")
    assert (result.state, result.with_reference, result.earned) == ("wrong", True, 0.375)
    assert result.notes[1:] == ("0.75 of 3 points for the right parts: first.",)
    # `both` needs none of the functions, so that its right part is worth its full share before that run.
    parts = in_parts(assignment, "both")
    both = f"def both(x):\n    return 2 * x + 1 + {last_case(parts, 'both')}"
    result = of(marked({"double": chain.MISTAKES["double"], "both": both}, given=parts), "both")
    assert (result.state, result.with_reference, result.earned) == ("wrong", True, 1.5)
    parts = in_parts(assignment, "total")
    source = f"def total(x):\n    t = float(x.sum()) + {last_case(parts, 'total')}\n    {{}}\n    return t"
    for change, earned in (("pass", 0.5), ("x[:] = 0", 0)):
        assert of(marked({"total": source.format(change)}, given=parts), "total").earned == earned


def in_parts(assignment, name, first=1, rest=1):
    """The assignment in which the first hidden case of an exercise, and the other two, are parts with weights."""
    names = ("first: a case", "rest: another case", "rest: a third case")

    def divided(task):
        hidden = tuple(replace(case, name=each) for case, each in zip(task.hidden, names, strict=True))
        return replace(task, hidden=hidden, parts={"first": first, "rest": rest})

    tasks = [divided(task) if task.public.name == name else task for task in assignment.tasks]
    return replace(assignment, tasks=tuple(tasks))


def last_case(assignment, name):
    """A condition that is true for the last hidden case of an exercise only."""
    (task,) = (task for task in assignment.tasks if task.public.name == name)
    return f"(x.flat[0] == {float(task.hidden[-1].args[0].flat[0])!r})"


def test_an_error_is_not_punished_twice_and_an_own_error_stays_one(marked):
    result = marked({"double": chain.MISTAKES["double"]})
    both = of(result, "both")
    assert (both.state, both.earned, both.with_reference) == ("right", 1.5, True)
    assert "the reference's double and plus_one" in both.notes[0]
    assert result.earned == 1 + 1.5 + 1
    both = of(marked({"double": "pass"}), "both")
    assert (both.state, both.earned) == ("right", 1.5)
    both = of(marked({name: chain.MISTAKES[name] for name in ("double", "both")}), "both")
    assert (both.state, both.earned, both.with_reference) == ("wrong", 0, True)
    both = of(marked({"both": chain.MISTAKES["both"]}), "both")
    assert (both.with_reference, both.earned) == (False, 0)
    spy = "def total(x):\n    return float(x.sum()) if double(1) == 3 else 0.0"
    assert of(marked({"double": chain.MISTAKES["double"], "total": spy}), "total").state == "right"


def test_lists_float32_classes_helper_files_and_other_encodings_are_honest_work(marked):
    result = marked(
        {
            "double": "from mine import twice\ndouble = twice",
            "plus_one": "plus_one = lambda x, by=1: (x + by).astype(np.float32)",
            "total": "class total:\n    def __new__(cls, x): return float(x.sum())",
        },
        helpers={"mine.py": "def twice(x):\n    return (2 * x).tolist()"},
    )
    assert states(result)["double"] == states(result)["total"] == states(result)["plus_one"] == "right"
    plain = marked({"double": "def double(x):\n    raise ValueError('\xe4')"})
    text = chain.notebook({"double": "def double(x):\n    raise ValueError('\xe4')"}).decode()
    text = text.replace("\\u00e4", "\xe4")
    for content in (text.encode() + b"\0" * 512, text.encode("utf-16"), text.encode("cp1252")):
        again = marked(content=content)
        assert again.exercises == plain.exercises and of(again, "double").line


def test_a_written_answer_is_what_the_cell_says_and_failed_statements_are_named(marked):
    result = marked(answer="  Because *it* is so.\n", extra="y = 1 / 0")
    (answer,) = result.written
    assert (answer.name, answer.number, answer.points) == ("why", "90.W1", 2)
    assert answer.text == "Because *it* is so."
    assert result.notes == ("code cell 6, line 1: ZeroDivisionError: division by zero",)
    (blank,) = marked(answer=ANSWER_HERE).written
    (long,) = marked(answer="x" * 10**6).written
    assert blank.text == "" and len(long.text) == module.LONGEST_ANSWER


FAILURES = {
    "import os\ndef double(x):\n    os._exit(3)": "died",
    "def double(x):\n    while True: pass": "timed out",
    "def double(x):\n    raise KeyError(x)": "raised",
    "import sys\ndef double(x):\n    sys.exit(0)": "raised",
    "def double(x):\n    raise KeyboardInterrupt": "raised",
    "def double(x):\n    return lambda: x": "no usable answer",
    "def double(x):\n    return np.array([x, None], dtype=object)": "no usable answer",
    "def double(x):\n    return None": "wrong",
    "def double(x):\n    return np.full(x.shape, np.nan)": "wrong",
    "def double(x):\n    return (2 * x)[:1]": "wrong",
    "def double(x):\n    return {'a': [[[[]]]]}": "wrong",
    "class Liar(np.ndarray):\n    def __eq__(self, o): return True\n    def __sub__(self, o): return 0\n"
    "def double(x):\n    return x.view(Liar)": "wrong",
    "double = 7": "not found",
    "def double():\n    return 1": "raised",
}


ONE_OF_EACH = {state: source for source, state in reversed(FAILURES.items())}.values()


@pytest.mark.slow
@pytest.mark.parametrize("source", quickly(FAILURES, *ONE_OF_EACH), ids=lambda source: source[-40:])
def test_each_failure_is_told_and_costs_only_its_own_exercise(marked, source):
    result = marked({"double": source}, seconds=1.0 if FAILURES[source] == "timed out" else AMPLE)
    double = of(result, "double")
    assert (double.state, double.earned) == (FAILURES[source], 0)
    assert [each.earned for each in result.exercises[1:]] == [1, 1.5, 1]


def test_a_definition_that_fails_is_told_with_its_cell_line_and_error_instead_of_not_found(marked):
    base = "class plus_one(Base): pass"
    total = "@jit\ndef total(x):\n    return 2 * x"
    result = marked(
        {"double": "def double(x):\n  return 2 * (x", "plus_one": base, "both": "b = 1", "total": total}
    )
    double = of(result, "double")
    assert "which defines it, cannot run: SyntaxError in line 2: '(' was never closed. Correct" in double.text
    assert re.match(r"Code cell \d+,", double.text) and double.public == ()
    assert "Code cell 3, which defines it, stops in line 1: NameError" in of(result, "plus_one").text
    assert "Code cell 5, which defines it, stops in line 2: NameError" in of(result, "total").text
    assert states(result) == dict.fromkeys(chain.RIGHT, "raised") | {"both": "not found"}


def test_another_lessons_notebook_is_refused_unless_it_defines_an_exercise(marked):
    stamp = (chain.LESSON.encode(), b"91_other\x1b[1m".replace(b"\x1b", b"\\u001b"))
    theirs = chain.notebook().replace(*stamp)
    assert marked(content=theirs).earned == 7
    refused = marked(content=theirs.replace(b"def ", b"def other_"))
    assert refused.status == "refused" and "lesson '91_other\\x1b[1m'" in refused.reason
    broken = theirs.replace(b"def ", b"def other_").replace(b"def other_double(x):", b"def double(x:")
    assert of(marked(content=broken), "double").state == "raised"
    result = marked(content=chain.notebook({"double": "import os\nx = os._exit(5)", "plus_one": "pass"}))
    found = states(result)
    assert (result.status, found["plus_one"], found["total"]) == ("graded", "not found", "right")


# Each is right in its version of Python; the grader of these tests is older than 3.90.
NEWER = {
    "3.12": 'def double(x):\n    return float(f"{ {"twice": 2}["twice"] }") * x',
    "3.14": "def double(x):\n    try:\n        return 2 * x\n    except ValueError, TypeError:\n        return x",
    "a name": "import math\ndef double(x):\n    return x * math.of_a_newer_python(2)",
    "an import": "from itertools import of_a_newer_python\ndef double(x):\n    return of_a_newer_python(x)",
    "a library": "def double(x):\n    return np.of_a_newer_numpy(x)",
}


def written_in(python, functions):
    notebook = json.loads(chain.notebook(functions))
    notebook["metadata"]["language_info"] = {"name": "python", "version": python}
    return json.dumps(notebook).encode()


@pytest.mark.parametrize("source", NEWER.values(), ids=NEWER.keys())
def test_what_an_older_python_cannot_read_waits_for_a_person(marked, source):
    result = marked(content=written_in("3.90.1", {"double": f"{source}\n# 2"}))
    if of(result, "double").state == "right":
        pytest.skip("this Python knows it")
    assert result.versions == {"python": "3.90.1"}
    assert (of(result, "double").state, of(result, "double").earned) == ("undecided", 0)
    assert "Python 3.90" in of(result, "double").text and "Correct" not in of(result, "double").text
    assert any("needs a decision (double" in note for note in result.notes)
    assert [each.earned for each in result.exercises[1:]] == [1, 1.5, 1]
    older = marked(content=written_in("3.1.1", {"double": source}))
    assert of(older, "double").state in ("raised", "not found") and not older.undecided


def test_a_mistake_in_a_newer_pythons_notebook_is_a_mistake_and_annotations_are_as_it_has_them(marked):
    for source, state in {
        chain.MISTAKES["double"]: "wrong",
        "def double(x):\n    return x.nothing": "raised",
        "doubled = 3": "not found",
        chain.BLANK["double"]: "not attempted",
    }.items():
        assert of(marked(content=written_in("3.90.1", {"double": source})), "double").state == state
    forward = {"double": "def double(x: Later) -> Later:\n    return 2 * x\n\nclass Later: ..."}
    assert of(marked(content=written_in("3.14.0", forward)), "double").state == "right"


def test_the_kind_of_failure_the_line_and_the_name_that_is_used_again_are_told(marked):
    def double(body):
        return of(marked({"double": f"def double(x):\n    {body}"}), "double")

    raised = double("y = x\n    return y / 0 if len(x) < 3 else y.nothing")
    assert raised.text == "It raises AttributeError."
    assert raised.line == "line 3: return y / 0 if len(x) < 3 else y.nothing"
    assert "3 dimensions instead of 2" in double("return 2 * x[:, :, None]").text
    assert "another size along axis 1" in double("return 2 * x[:, :1]").text
    double = of(marked({"double": "def double(x):\n    return np.multiply(x, 2)"}, extra="np = 3"), "double")
    assert "name np" in double.public[-2] and double.public[-1].startswith("Code cell 6 ")


LEAKS = {
    "message": "raise ValueError(str(x.tolist()))",
    "class": "raise type(f'E{x[0, 0]:.3f}', (Exception,), {})()",
    "linecache": "import linecache; t = f'1/0  # {x[0, 0]:.3f}\\n'; "
    "linecache.cache['<f>'] = (len(t), None, [t], '<f>'); exec(compile(t, '<f>', 'exec'))",
    "line number": "n = abs(int(x[0, 0] * 1000)); exec(compile('\\n' * min(n, 10**6) + '1 / 0', '<f>', 'exec'))",
    "shape": "return np.zeros((abs(int(x[0, 0] * 100)), 1), bool)",
    "status": "import os; os._exit(int(abs(x[0, 0])) % 256)",
}


@pytest.mark.parametrize("kind", LEAKS)
def test_no_hidden_input_finds_a_way_out(marked, assignment, kind):
    functions = {name: f"def {name}(x):\n  if len(x) == 4: {LEAKS[kind]}\n  return x" for name in chain.RIGHT}
    result = marked(functions)
    told = told_to_the_student(result)
    assert not [number for number in hidden_numbers(assignment) if number in told]
    assert all(each.text and each.earned == 0 for each in result.exercises)


def test_what_a_student_sees_in_full_was_said_before_any_hidden_input_came(marked, assignment):
    keeps = "seen = []\ndef double(x):\n    seen.append(x.tolist())\n    return 2 * x"
    tells = "def plus_one(x):\n    raise ValueError(repr(seen))"
    result = marked({"double": keeps, "plus_one": tells})
    told = told_to_the_student(result)
    assert "[1.5, -2.0]" in told  # of the public cases, all may be said
    assert not [number for number in hidden_numbers(assignment) if number in told]


def test_a_forged_outcome_is_not_believed(marked, assignment):
    forge = """
from nao_course.instructor.sandbox import worker_process
from nao_course.exercises import running
from nao_course.exercises.running import Outcome
from nao_course.codec import decode
def call(function, frame, driver="", trusted=False):
    (x,), _ = decode(frame)
    if x.shape == (4, 3):
        return Outcome("died", text=f"signal {x[0, 0]:.3f}", line=f"line 1: {x[0, 0]:.3f}")
    return Outcome("value", x)
worker_process.call_as_it_is = running.call_as_it_is = call
"""
    result = marked(chain.RIGHT, extra=forge)
    told = told_to_the_student(result)
    assert not [number for number in hidden_numbers(assignment) if number in told]
    assert result.earned == 0


def test_a_time_out_is_tried_once_more_before_it_counts(marked, assignment, monkeypatch):
    calls = []
    real = module.Worker.call

    def counted(self, name, case, *more):
        if self.notebook != assignment.reference:
            calls.append((name, len(case.args[0])))
        return real(self, name, case, *more)

    monkeypatch.setattr(module.Worker, "call", counted)
    slow = "import time\ndef double(x):\n    if len(x) == 4: time.sleep(1000)\n    return 2 * x"
    assert of(marked({"double": slow}, seconds=0.7), "double").state == "timed out"
    assert calls.count(("double", 4)) == 1


def test_each_call_has_the_seconds_of_its_exercise(warm_server, handed_in, tmp_path, monkeypatch):
    course = chain.make_course(tmp_path / "course")
    declared = course.declaration(chain.LESSON)
    declared.write_text(declared.read_text().replace("x.mean())", "x.mean()), seconds=45"))
    assignment = prepare(course, "90", chain.SECRET)
    given, real = {}, module.Worker.call

    def noted(self, name, case, driver, seconds):
        given.setdefault(name, set()).add(round(seconds, 9))
        return module.Outcome("timed out") if name == "total" else real(self, name, case, driver, seconds)

    monkeypatch.setattr(module.Worker, "call", noted)
    total = of(grade(handed_in, assignment, warm_server), "total")
    assert given == {"double": {10.0}, "plus_one": {10.0}, "both": {10.0}, "total": {45.0}}
    assert "longer than 45 seconds" in total.text
    assert "stopped after 45 seconds" in " ".join(total.public)


def test_all_tries_of_a_submission_have_its_time_together(warm_server, assignment, handed_in, monkeypatch):
    seen, real = [], module._grade
    monkeypatch.setattr(module, "_grade", lambda *words: (seen.append(words[4]), (real(*words)[0], 1))[1])
    grade(handed_in, assignment, warm_server)
    first, second = seen
    assert first is second and first.own[tries_module.LOADING].total > 0


@pytest.mark.slow
def test_what_one_exercise_uses_up_takes_nothing_from_the_others(marked, monkeypatch):
    monkeypatch.setattr(tries_module, "SECONDS_IN_ALL", 15.0)
    result = marked({"double": "import time\ndef double(x):\n    time.sleep(1000)"})
    assert states(result) == dict.fromkeys(chain.RIGHT, "right") | {"double": "timed out"}
    assert of(result, "both").with_reference and not of(result, "total").with_reference
    assert "took too long together" in of(result, "double").text and "longer than" not in str(result)


@pytest.mark.slow
def test_what_could_not_be_run_is_not_called_slow_and_the_reason_is_named(marked, monkeypatch):
    monkeypatch.setattr(tries_module, "SECONDS_IN_ALL", 10.0)
    dies = {name: f"import os\ndef {name}(x):\n    os._exit(3)" for name in ("double", "plus_one")}
    result = marked(content=chain.notebook(dies, extra="import time\nSLEPT = time.sleep(2)"))
    assert states(result) == dict.fromkeys(chain.RIGHT, "not run") | dict.fromkeys(dies, "died")
    reason = "Not run, because loading the notebook used up the time of the submission"
    assert of(result, "total").text.startswith(reason) and f"total: {reason}" in " ".join(result.notes)
    assert "long" not in str(of(result, "total").public)


def test_an_exercise_does_not_pay_for_files_that_another_one_left_open(marked):
    leaks = """
import os
LEFT = []
def double(x):
    try:
        while True:
            LEFT.append(os.open(os.devnull, os.O_RDONLY))
    except OSError:
        return 2 * x
"""
    opens = "def plus_one(x):\n    with open('mine.txt', 'w'):\n        return x + 1"
    found = states(marked({"double": leaks, "plus_one": opens}))
    assert found == dict.fromkeys(chain.RIGHT, "right") | {"both": "raised"}, "it calls both of them"


def test_a_comparison_that_fails_costs_that_exercise_alone(marked, assignment, monkeypatch):
    class Fails(Close):
        def gather(self, case, answers):
            raise OverflowError(list(answers))

    double, *others = assignment.tasks
    double = replace(double, public=replace(double.public, comparison=Fails()))
    result = marked(given=replace(assignment, tasks=(double, *others)))
    assert states(result) == dict.fromkeys(chain.RIGHT, "right") | {"double": "no usable answer"}

    def compare(self, expected, got):
        raise MemoryError

    monkeypatch.setattr(Close, "compare", compare)
    result = marked()
    assert set(states(result).values()) == {"no usable answer"}
    assert result.exercises[0].public == ("90.1 double: its answer could not be read.",)


DIES = "import os\nn = []\ndef double(x):\n    n.append(x.shape)\n    {}\n    return 2 * x"


@pytest.mark.parametrize(("number", "tries"), [(0, 1), (11, 1), (9, 2), (15, 2)])
def test_only_who_may_have_been_ended_by_somebody_else_gets_a_second_try(marked, monkeypatch, number, tries):
    drawn, real = [], module._grade
    monkeypatch.setattr(module, "_grade", lambda *words: (drawn.append(words[1]), real(*words))[1])
    how = f"os.kill(os.getpid(), {number})" if number else "os._exit(3)"
    result = marked({"double": DIES.format(how)})
    assert of(result, "double").state == "died" and len(drawn) == tries
    if tries == 2:
        first, second = ([case.args[0] for task in each.tasks for case in task.hidden] for each in drawn)
        assert [len(each) for each in first] == [len(each) for each in second]
        assert not any(np.array_equal(a, b) for a in first for b in second if np.size(a) > 1)
        assert drawn[0].hash == drawn[1].hash


@pytest.mark.parametrize("says", ["nothing", "it was ended by signal 9 (Killed)", "it ends Python itself; x"])
def test_a_second_try_tells_of_public_cases_what_the_first_did(marked, monkeypatch, says):
    """By then it may have found a way to remember hidden inputs, and its page shows what a public case raises."""
    real, tries = module._grade, []

    def noted(submission, assignment, *words):
        result, _ = real(submission, assignment, *words)
        tries.append(1)
        lines = (f"90.1 double: 0 of 2 public checks pass. One raises ValueError: {says}: try {len(tries)}",)
        told = [replace(each, public=lines) if each.name == "double" else each for each in result.exercises]
        return replace(result, exercises=tuple(told)), len(tries) == 1

    monkeypatch.setattr(module, "_grade", noted)
    result = marked({"double": "def double(x):\n    raise ValueError"})
    assert len(tries) == 2 and ": try 1" in told_to_the_student(result)
    assert ": try 2" not in told_to_the_student(result)


def test_an_error_of_the_graders_own_is_no_score(warm_server, assignment, handed_in, monkeypatch):
    reasons = dict.fromkeys((b"{", b"[" * 100_000, b"PK\x03\x04"), "not a notebook")
    for content, reason in ({b"": "empty"} | reasons).items():
        handed_in.path.write_bytes(content)
        result = grade(replace(handed_in, notes=("a note",)), assignment, warm_server)
        assert (result.status, result.earned, result.points) == ("refused", 0, 7) and reason in result.reason
        assert [each.state for each in result.exercises] == ["not found"] * 4
        assert result.written[0].text == "" and result.notes == ("a note",) and result.submission
    monkeypatch.setattr(module, "_written", lambda *_: 1 / 0)
    with pytest.raises(GraderError, match="ada, 90_chain: the grader failed .ZeroDivisionError"):
        grade(handed_in, assignment, warm_server)


@pytest.mark.slow
def test_a_lost_server_has_the_submission_graded_again_by_one_of_its_own(
    warm_server, assignment, handed_in, monkeypatch
):
    real, died, used = module._grade, [1, 1], []

    def dies(*words):
        used.append(words[2])
        if len(used) <= len(died):
            raise ServerEnded("gone")
        return real(*words)

    monkeypatch.setattr(module, "_grade", dies)
    assert grade(handed_in, assignment, warm_server).earned == 7
    assert used[0] is warm_server and used[1] is used[2] is not warm_server
    assert used[1].process is None and warm_server.process
    died, used[:] = [1, 1, 1], []
    result = grade(handed_in, assignment, warm_server)
    assert (result.status, result.earned, result.reason) == ("refused", 0, tries_module.SERVER_ENDED)
    assert len(used) == 3


def test_grading_can_be_given_up_and_an_assignment_can_be_sent(warm_server, assignment, handed_in):
    with pytest.raises(Stopped):
        grade(handed_in, assignment, warm_server, stopped=lambda: True)
    assert grade(handed_in, pickle.loads(pickle.dumps(assignment))).earned == 7


@pytest.fixture(scope="module")
def lesson_01():
    return prepare(load_course(PROJECT), "01", chain.SECRET)


LESSON = "01_hsl_filtering"
PLAN = load_course(PROJECT).plan(LESSON)


def with_mistakes(number):
    """Modules with the solution of lesson 01, in each of which another exercise has a mistake; by exercise."""
    solution = load_solution(PROJECT / "solutions" / f"{LESSON}.ipynb").text.cells
    cells = [source for role, source in solution if role == "solution"]
    for exercise in PLAN.exercises:
        name, change = exercise.name, exercise.mistakes[number % len(exercise.mistakes)].function
        changed = [change.applied_to(each, name) if f"def {name}(" in each else each for each in cells]
        yield name, "\n\n".join(["import cv2\nimport numpy as np", *changed])


def with_cells(folder, cells, files=()):
    path = folder / f"{LESSON}.ipynb"
    path.write_text(json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": cells}))
    return Submission("ada", LESSON, path, tuple(files))


def imported(tmp_path, modules):
    """A submission whose notebook imports each exercise from a module beside it."""
    files, cells = [], []
    for name, source in modules:
        files.append((f"my_{name}.py", tmp_path / f"my_{name}.py"))
        files[-1][1].write_text(source)
        cells.append(chain.cell("code", f"from my_{name} import {name}"))
    return with_cells(tmp_path, cells, files)


MISTAKES = max(len(each.mistakes) for each in PLAN.exercises)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(MISTAKES))
def test_each_mistake_of_lesson_01_loses_its_points_and_gets_its_hint(
    warm_server, lesson_01, tmp_path, number
):
    result = grade(imported(tmp_path, with_mistakes(number)), lesson_01, warm_server)
    for exercise, got in zip(PLAN.exercises, result.exercises, strict=True):
        mistake = exercise.mistakes[number % len(exercise.mistakes)]
        assert (got.name, got.earned, got.mistake) == (exercise.name, 0, mistake.name)
        assert got.hint == mistake.message


@pytest.mark.slow
def test_lesson_01_as_solved_gets_all_and_as_released_none(warm_server, lesson_01):
    solved, blank = (
        grade(Submission("a", LESSON, PROJECT / folder / f"{LESSON}.ipynb"), lesson_01, warm_server)
        for folder in ("solutions", "notebooks")
    )
    assert solved.earned == solved.points == blank.points > 0
    assert blank.earned == 0
    assert {each.state for each in blank.exercises} == {"not attempted"}
    assert all(each.text == "" for each in blank.written) and len(blank.written) == len(lesson_01.written)


@pytest.mark.slow
@pytest.mark.parametrize("mess", MESS)
def test_the_same_work_has_the_same_points_in_a_mess(warm_server, lesson_01, tmp_path, mess, rng):
    own, blank = (deepcopy(cells_of(folder, LESSON)) for folder in ("solutions", "notebooks"))
    plain = grade(with_cells(tmp_path, own), lesson_01, warm_server)
    odd = grade(with_cells(tmp_path, MESS[mess](own, blank, rng)), lesson_01, warm_server)
    assert odd.earned == plain.earned == odd.points
    assert [each.text for each in odd.written] == [each.text for each in plain.written] != [""]


def test_what_is_unusual_is_said_to_student_and_assistant(warm_server, lesson_01, tmp_path):
    cells = [cell for cell in deepcopy(cells_of("solutions", LESSON)) if "explain" not in cell["id"]]
    retyped, doubled = (
        next(cell for cell in cells if cell["id"] == f"lesson01-{name}")
        for name in ("hue_mask", "white_threshold")
    )
    retyped["cell_type"] = "raw"
    cells += [{**doubled, "id": "copy"}, {"cell_type": "markdown", "source": "my notes"}]
    result = grade(with_cells(tmp_path, cells), lesson_01, warm_server)
    hue_mask, white = of(result, "hue_mask"), of(result, "white_threshold")
    assert hue_mask.state == "not found" and "Raw cell" in hue_mask.text
    assert white.state == "right" and "code cells" in white.notes[0]
    assert result.written[0].text == "" and "none at this question" in result.written[0].note
    for name in ("hue_mask", "white_threshold", "explain_stray_pixel"):
        assert f"{name}: " in "\n".join(result.notes)
