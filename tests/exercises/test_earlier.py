"""A function of an earlier lesson is the student's own, or it says why not; a check has recorded what it answers."""

import ast
import inspect
from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.exercises import Case, call, checking, earlier, try_out
from nao_course.exercises.checking import grade_public, pack, unpack
from nao_course.exercises.definitions import load_definitions
from nao_course.exercises.earlier import Calls, EarlierCall, EarlierNotUsable, not_usable, stand_in, watching
from nao_course.exercises.library_functions import IN_LIBRARY
from nao_course.instructor.authoring.plans import load_plan, load_solution, publish, solutions_beside
from nao_course.student import notebooks as student
from nao_course.widgets.attempts import attempt
from tests.toy import pair, toy


@pytest.fixture(scope="module")
def lessons(tmp_path_factory):
    """The public data of both lessons, as a student has it."""
    course = pair.make_course(tmp_path_factory.mktemp("course"))
    found = {}
    for name in course.names():
        notebook = course.solutions / f"{name}.ipynb"
        with earlier.resolved_by(solutions_beside(notebook)):
            found[name] = unpack(pack(publish(name, course.plan(name), load_solution(notebook))))
    return found


@pytest.fixture(autouse=True)
def known(lessons, monkeypatch):
    monkeypatch.setattr(student, "read_public", lessons.__getitem__)
    monkeypatch.setattr(student, "lessons", lambda: sorted(lessons))


def of(lessons, name):
    return next(each for each in lessons[pair.SECOND].exercises if each.name == name)


def loaded(folder):
    return load_definitions(folder / f"{pair.SECOND}.ipynb", earlier=student.earlier_in(folder))


def own(folder, second=None, **first):
    """The second lesson's functions, beside some of the first."""
    pair.write(folder / f"{pair.FIRST}.ipynb", pair.FIRST, first)
    pair.write(folder / f"{pair.SECOND}.ipynb", pair.SECOND, second)
    return loaded(folder)


def test_calls_of_the_reference_are_recorded_once_each_as_what_was_asked_for_and_answered_then(lessons):
    calls = [(each.use, each.given["x"], each.answer) for each in of(lessons, "quadruple").earlier]
    assert calls[:2] == [("80:double", 1.5, 3.0), ("80:double", 3.0, 6.0)]
    assert of(lessons, "alone").earlier == []
    walks = [each.given["x"] for each in of(lessons, "walk").earlier]
    assert len(walks) == len(set(walks))

    def fill(values):
        values[:] = 7
        return values

    inner = stand_in("80:fill", lambda: fill)
    outer = stand_in("80:twice", lambda: lambda values: inner(inner(values)))
    with watching(keep=True) as calls:
        inner(np.zeros(2))[:] = 9
        outer(np.zeros(2))
    first, second = calls.made  # what an earlier function calls itself is none
    assert (first.use, second.use) == ("80:fill", "80:twice")
    assert first.given["values"].tolist() == [0, 0] and first.answer.tolist() == [7, 7]


def test_the_students_own_right_function_is_used_and_a_wrong_answer_stays_wrong(tmp_path, lessons):
    found = own(tmp_path, double="def double(x):\n    return x + x")
    report = grade_public(of(lessons, "quadruple"), found["quadruple"])
    assert report and len(report.lines) == 2
    assert found["quadruple"](100.0) == 400.0
    assert "double" not in found  # it is no function of this lesson
    found = own(tmp_path)
    report = grade_public(of(lessons, "quadruple"), lambda x: found["quadruple"](x) + 1)
    assert report.state == "wrong" and "passes its own check" not in repr(report)
    found = own(tmp_path, double="def double(x):\n    return 7.0 if x == 3.0 else 2 * x")
    report = grade_public(of(lessons, "quadruple"), lambda x: found["quadruple"](x) + 1)
    assert report.state == "wrong" and "passes its own check" in repr(report)


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("def double(x):\n    return x", "0 of 2 public checks pass"),
        ("pass", "not found in 80_first.ipynb"),
        ("def double(x):\n    raise NotImplementedError", "not written yet"),
    ],
)
def test_a_check_goes_on_with_recorded_answers_and_says_so(tmp_path, lessons, source, why):
    found = own(tmp_path, double=source)
    report = grade_public(of(lessons, "quadruple"), found["quadruple"])
    assert report.state == "right"
    assert report.lines[-1].startswith("double of your lesson 80 is not usable yet: 80.1 double: ")
    assert why in report.lines[-1] and report.lines[-1].endswith("Recorded answers were used instead.")
    with pytest.raises(EarlierNotUsable, match="double of your lesson 80 is not usable yet"):
        found["quadruple"](1.5)
    shown = try_out(lambda: found["quadruple"](1.5))
    assert str(shown).startswith("double of your lesson 80 is not usable yet")


def test_an_exercise_of_the_same_lesson_that_is_at_fault_is_named_if_it_is_called(tmp_path, lessons):
    wrong = {"quadruple": "def quadruple(x):\n    return 3 * x"}
    mine = own(tmp_path, wrong)
    reason = "It uses quadruple, which does not pass its own check: correct quadruple first."
    said = {report.name: report.lines for report in student.functions(pair.SECOND, tmp_path).reports}
    assert said["walk"][-1] == said["Walker"][-1] == reason and reason not in said["quadruple"]
    check = checking.Checks(lessons[pair.SECOND])
    assert check("walk", mine["walk"]).lines[-1] == check("Walker", mine["Walker"]).lines[-1] == reason
    assert len(check("alone", mine["alone"]).lines) == 2
    calls_none = own(tmp_path, wrong | {"walk": "def walk(x):\n    return -1.0"})
    report = checking.Checks(lessons[pair.SECOND])("walk", calls_none["walk"])
    assert not report and "which does not pass its own check" not in repr(report)


def test_an_input_that_was_not_recorded_or_is_large_is_no_error_of_the_students(tmp_path, lessons):
    def quadruple(x):
        return stand_in("80:double", not_usable("80:double", "why."))(7 * x)

    report = grade_public(of(lessons, "quadruple"), quadruple)
    assert report.state == "not checked" and "your function raises" not in report.lines[0]
    assert "calls double of your lesson 80 with an input for which no answer was recorded." in report.lines[0]
    calls = Calls([EarlierCall(WRAP, ["angle"], {"angle": 0.0}, 0.0)])
    assert calls.in_library(WRAP, (np.zeros(10),), {}) is not None
    assert calls.in_library(WRAP, (np.zeros(100_000),), {}) is None


def test_recorded_calls_are_found_by_name_and_but_for_rounding_and_their_answers_stay(lessons):
    double = stand_in("80:double", not_usable("80:double"))
    recorded = of(lessons, "quadruple").earlier
    with watching(recorded) as calls:
        assert double(1.5) == double(x=1.5) == double(np.float64(1.5 + 1e-13)) == 3.0
        with pytest.raises(EarlierNotUsable, match="for which no answer was recorded"):
            double(1.51)
        with pytest.raises(TypeError, match=r"your code calls double\(x\) without x"):
            double()
        for wrong in (lambda: double(1.5, 2), lambda: double(y=1.5)):
            with pytest.raises(TypeError, match=r"double\(x\) does not take the arguments"):
                wrong()
    assert list(calls.answered) == ["80:double"]
    with pytest.raises(EarlierNotUsable):  # nothing is left of the block
        double(1.5)
    recorded = [EarlierCall("80:ones", ["n"], {"n": 2}, np.ones(2))]
    ones = stand_in("80:ones", not_usable("80:ones"))
    with watching(recorded):
        ones(2)[:] = 7
        assert ones(2).tolist() == [1.0, 1.0]
    double = stand_in("80:double", not_usable("80:double"))
    with watching([EarlierCall("80:halve", ["x"], {"x": 1.5}, 0.75)]), pytest.raises(EarlierNotUsable):
        double(1.5)


DOCUMENTED = '''def double(x, *, times=2):
    """Return a number twice.

    Parameters
    ----------
    x : float
        The number.
    """
    '''


@pytest.mark.parametrize("body", ["return times * x", "return 7"])
def test_what_stands_for_a_function_looks_like_it_also_where_it_is_not_usable(tmp_path, body, capsys):
    pair.write(tmp_path / f"{pair.FIRST}.ipynb", pair.FIRST, {"double": DOCUMENTED + body})
    double = student.earlier("80:double", tmp_path)
    capsys.readouterr()
    help(double)
    shown = capsys.readouterr().out
    assert "double(x, *, times=2)" in shown and "Return a number twice." in shown and "The number." in shown
    assert "This is double of your lesson 80." in shown
    assert str(inspect.signature(double)) == "(x, *, times=2)" and double.__name__ == "double"
    assert body not in inspect.getsource(double)  # nobody reads an answer where a question is looked up


def test_a_class_is_handed_on_itself_unless_it_is_wrong(tmp_path, capsys):
    pair.write(tmp_path / f"{pair.FIRST}.ipynb", pair.FIRST, {"Counter": "class Counter: pass"})
    with pytest.raises(EarlierNotUsable):
        student.earlier("80:Counter", tmp_path)()
    found = own(tmp_path)
    assert isinstance(found.namespace["Counter"], type) and found["tally"](2.0) == 3.0
    counter = stand_in("80:Counter", not_usable("80:Counter", "why."))
    with pytest.raises(EarlierNotUsable, match="Counter of your lesson 80 is not usable yet: why"):

        class Heir(counter):
            pass


UNPACKS = "def double(x):\n    if isinstance(x, list):\n        first, second = x\n    return 2 * x"


def test_an_error_inside_an_earlier_function_is_told_as_such_with_the_line_that_calls_it(tmp_path, lessons):
    source = "def quadruple(x):\n    y = [x, x, x]\n    return double(y)"
    found = own(tmp_path, {"quadruple": source}, double=UNPACKS)
    report = grade_public(of(lessons, "quadruple"), found["quadruple"])
    assert report.lines[0].endswith(
        "your function raises ValueError: too many values to unpack (expected 2) (inside double of your lesson 80)."
    )
    assert report.lines[1] == "line 3: return double(y)"
    assert report.lines[2].startswith("double cannot use the arguments of that line")
    said = str(try_out(lambda: found["quadruple"](1.0)))
    assert "(inside double of your lesson 80). It is called from your line 3: return double(y)." in said
    tried = attempt(lambda: found["quadruple"](1.0), "quadruple()")
    assert tried.message.startswith("ValueError in quadruple(), line 3, inside double of your lesson 80: too")
    found = own(tmp_path, double="def double(x):\n    return x + x").namespace["double"]
    error = call(lambda: found(1, 2), Case(()))
    assert "inside" not in error.text and "takes 1 positional argument" in error.text


def test_the_set_up_cell_binds_what_was_saved_and_names_what_there_is_not(tmp_path, capsys):
    pair.write(tmp_path / f"{pair.FIRST}.ipynb", pair.FIRST, {"double": "pass"})
    double = student.earlier("80:double", tmp_path)
    shown = capsys.readouterr().out
    assert double.__doc__ == "This is double of your lesson 80." and double.__name__ == "double"
    assert shown.count("double of your lesson 80 is not usable yet") == 1
    assert "not found in 80_first.ipynb" in shown
    assert "The checks of this lesson have recorded answers for it." in shown
    with pytest.raises(EarlierNotUsable, match="80 is not usable yet: the set-up cell says why.$"):
        double(1.0)
    pair.write(tmp_path / f"{pair.FIRST}.ipynb", pair.FIRST)
    assert student.earlier("80:double", tmp_path)(2.0) == 4.0 and capsys.readouterr().out == ""
    for use, message in (("79:double", "no lesson '79'"), ("80:halve", "80_first has no exercise 'halve'")):
        with pytest.raises(ValueError, match=message):
            student.earlier(use, tmp_path)


@pytest.mark.parametrize(("used", "name", "many"), [("81:walk", "Counter", 2), ("80:double", "double", 1)])
def test_lessons_that_use_each_other_or_themselves_come_to_an_end(used, name, many, tmp_path, monkeypatch):
    loads, real = [], student.load_definitions
    monkeypatch.setattr(student, "load_definitions", lambda at, **more: loads.append(at) or real(at, **more))
    loop = (("setup", f"mine = earlier('{used}')"), ("solution", f"def {name}(): return mine(1)"))
    toy.write(tmp_path / f"{pair.FIRST}.ipynb", *loop)
    pair.write(tmp_path / f"{pair.SECOND}.ipynb", pair.SECOND)
    found = student.functions(pair.SECOND if many == 2 else pair.FIRST, tmp_path)
    assert ("alone" in found) is (many == 2) and len(loads) == many


def test_only_a_plain_assignment_in_the_released_set_up_cell_counts(tmp_path):
    def use(source):
        return earlier.assigned_use(ast.parse(source).body[0])

    assert use("f = earlier('01:f')") == use("f = student.earlier('01:f')") == ("f", "01:f")
    for given in ("g('01:f')", "earlier(x)", "earlier('a', 1)"):
        assert use(f"f = {given}") is None
    assert use("earlier('01:f')") is use("f, g = earlier('01:f')") is None
    path = toy.write(tmp_path / "81_x.ipynb", ("setup", "f = earlier('80:mine')"), "f")
    assert load_definitions(path, earlier=lambda use: use).namespace["f"] == "80:mine"
    released = load_definitions(path, setup="f = earlier('80:theirs')", earlier=lambda use: use)
    assert released.namespace["f"] == "80:theirs"
    failing = load_definitions(path, earlier=lambda use: 1 / 0)
    assert "ZeroDivisionError" in failing.skipped[0].reason
    assert earlier.split_use("1:f") == earlier.split_use("01_hsl:f") == ("01", "f")


def test_in_a_declaration_an_earlier_function_is_the_references(tmp_path):
    course = pair.make_course(tmp_path)
    declaration = course.solutions / "exercises" / f"{pair.SECOND}.py"
    text = (
        declaration.read_text() + "\nfrom nao_course.student import earlier\ndouble = earlier('80:double')\n"
    )
    declaration.write_text(text + "PLAN = LessonPlan([exercise('f', 1, [], numbers, slip=double)])")
    (exercise,) = load_plan(declaration).exercises
    with earlier.resolved_by(solutions_beside(course.solutions / f"{pair.SECOND}.ipynb")):
        assert exercise.mistakes[0].function(3.0) == 6.0
    with pytest.raises(EarlierNotUsable):
        exercise.mistakes[0].function(3.0)


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("return 7.0 if x == 3.0 else 2 * x", "one, double(3): your answer is 7, which is not right."),
        ("if x == 3.0:\n        raise ValueError('three')\n    return 2 * x", "it raises ValueError: three."),
        ("return '' if x == 3.0 else 2 * x", "your answer is a str, not numbers."),
    ],
)
def test_an_earlier_function_that_fails_only_here_is_named_and_replaced(tmp_path, lessons, body, why):
    found = own(tmp_path, double=f"def double(x):\n    {body}")
    report = grade_public(of(lessons, "quadruple"), found["quadruple"])
    assert report.state == "right" and report.lines[-2].endswith(why)
    assert report.lines[-2].startswith("double of your lesson 80 passes its own check, but not with an input")
    assert report.lines[-1] == "The reference's answers were used in its place."


LESSON_11 = {each.name: each for each in checking.read_public("11_slam_on_the_field").exercises}
WRAP = "07:warp2pi"
JOINT_DISTANCE = ("07:warp2pi", "05:expected_measurement", "05:measurement_jacobian_pose")


def one_number_at_a_time(**given):
    """Return a right `joint_distance` that wraps single numbers, with some functions of the earlier lessons."""
    own = {use.partition(":")[2]: stand_in(use, not_usable(use, "not written.")) for use in JOINT_DISTANCE}
    own |= {name: stand_in(f"07:{name}", lambda own=own: own) for name, own in given.items()}
    by_landmark = "measurement_jacobian_landmark"
    own[by_landmark] = stand_in(f"05:{by_landmark}", not_usable(f"05:{by_landmark}"))

    def joint_distance(state, covariance, indices, measurements, measurement_covariance):
        nu, H, rows = [], np.zeros((0, len(state))), []
        for i, j in enumerate(indices):
            if j >= 0:
                own_place = slice(3 + 2 * j, 5 + 2 * j)
                bearing, r = own["expected_measurement"](state[:3], state[own_place])
                nu += [own["warp2pi"](measurements[i].bearing - bearing), measurements[i].range - r]
                block = np.zeros((2, len(state)))
                block[:, :3] = own["measurement_jacobian_pose"](state[:3], state[own_place])
                block[:, own_place] = own[by_landmark](state[:3], state[own_place])
                H, rows = np.vstack([H, block]), [*rows, 2 * i, 2 * i + 1]
        S = H @ covariance @ H.T + measurement_covariance[np.ix_(rows, rows)]
        return float(np.sqrt(np.array(nu) @ np.linalg.solve(S, nu))) if nu else own["warp2pi"](0.0)

    return joint_distance


def wrapped(angle):
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi


@pytest.mark.parametrize(
    ("wrapping", "is_named"),
    [
        (lambda angle: np.where(np.isclose(wrapped(angle), np.pi), -np.pi, wrapped(angle))[()], False),
        (lambda angle: np.round(wrapped(angle), 2), True),
        (lambda angle: -wrapped(angle), True),
        (None, False),
    ],
    ids=["half a turn to the right", "rounded", "sign", "missing"],
)
def test_a_right_answer_passes_with_a_missing_or_wrong_wrapping_and_a_wrong_one_is_named(wrapping, is_named):
    own = {"warp2pi": wrapping} if wrapping else {}
    report = grade_public(LESSON_11["joint_distance"], one_number_at_a_time(**own))
    assert report.state == "right", report
    assert ("warp2pi of your lesson 07 passes its own check, but not" in repr(report)) is is_named
    assert wrapping or ("warp2pi (07)" in report.lines[-1] and "Recorded answers" in report.lines[-1])


@pytest.mark.slow
def test_the_librarys_functions_have_the_answers_that_the_references_have():
    calls = [each for name in ("associate", "EkfSlam") for each in LESSON_11[name].earlier]
    known = Calls(calls)
    compared = dict.fromkeys(IN_LIBRARY, 0)
    for each in calls:
        if each.use in IN_LIBRARY:
            found = known.in_library(each.use, tuple(each.given.values()), {})
            off = found.answer - each.answer
            # Half a turn to the left or to the right
            if each.use in ("07:warp2pi", "05:expected_measurement"):
                off = np.where(np.abs(off) > 6, np.abs(off) - 2 * np.pi, off)
            np.testing.assert_allclose(off, 0, atol=1e-7)
            compared[each.use] += 1
    assert all(compared.values())


def test_all_that_a_cell_lacks_is_one_list_that_is_folded(tmp_path, monkeypatch):
    shown, shell = [], SimpleNamespace(execution_count=1)
    handle = SimpleNamespace(update=lambda grown: shown.__setitem__(-1, grown))
    monkeypatch.setattr("IPython.display.display", lambda what, **_: shown.append(what) or handle)
    monkeypatch.setattr("IPython.get_ipython", lambda: shell)
    pair.write(tmp_path / f"{pair.FIRST}.ipynb", pair.FIRST, {"double": "pass", "Counter": "pass"})
    student.earlier("80:double", tmp_path)
    assert "<details" not in shown[0]._repr_html_()
    student.earlier("80:Counter", tmp_path)
    (grown,) = shown
    assert "<summary>2 functions of earlier lessons are not usable yet" in grown._repr_html_()
    assert "double of your lesson 80" in repr(grown) and "Counter of your lesson 80" in repr(grown)
    shell.execution_count = 2
    student.earlier("80:double", tmp_path)
    assert len(shown) == 2 and "Counter" not in repr(shown[1])
