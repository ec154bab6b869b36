"""A mistake is a change of the solution: it is read, applied and run as written, and refused where it does not fit."""

import pytest

from nao_course.exercises import Case, Definitions, Exercise, LessonPlan
from nao_course.exercises.definitions import NotebookText
from nao_course.instructor.authoring.leaks import fingerprints
from nao_course.instructor.authoring.mistakes import Change, ChangeError, catalogue, with_functions
from nao_course.instructor.authoring.plans import PlanError, publish

SOURCE = '''
def mean(values):
    """Return the mean: total / count."""
    ### BEGIN SOLUTION
    total = sum(values)
    if not values:
        total = 0.0
    return total / count(values)
    ### END SOLUTION
'''


def solution(source: str = SOURCE) -> Definitions:
    namespace = {"count": len, "__name__": "solution"}
    exec(source, namespace)
    text = NotebookText([("solution", source)])
    return Definitions({"mean": namespace["mean"]}, namespace=namespace, text=text)


def changed(*lines: str, source: str = SOURCE):
    text = "slip\n" + "".join(f"    {line}\n" for line in lines) + "    A message.\n"
    reference = solution(source)
    plan = with_functions(LessonPlan([exercise(text)]), reference)
    assert source is not SOURCE or reference["mean"]([2.0, 4.0]) == 3.0, "the solution itself stays as it was"
    return plan.exercises[0].mistakes[0].function


def exercise(text: str) -> Exercise:
    public = [Case(([1.0, 2.0],)), Case(([4.0, 2.0, 0.0],))]
    hidden = lambda rng: [Case(([1.0, float(rng.uniform(2, 3))],))]  # noqa: E731
    return Exercise("mean", 1, lambda: public, hidden, ("Add.", "Divide."), catalogue(text))


def test_fragments_are_replaced_one_after_the_other_in_functions_and_methods_but_not_in_docstrings():
    assert changed("total / count(values) => total / 3")([3.0, 6.0]) == 3.0
    assert changed("total / count => total * count")([2.0, 2.0]) == 8.0
    assert "total" not in Change(("total =>> t",)).applied_to(SOURCE, "mean").split('"""')[2]
    assert changed("sum(values) => max(values)", "max(values) => max(values) - 1")([4.0, 2.0]) == 1.5
    source = "class mean:\n    def get(self):\n        return 1\n"
    assert changed("return 1 => return 2", source=source)().get() == 2


def test_lines_are_inserted_at_the_beginning_of_the_body_or_behind_the_changed_line():
    assert changed("+ values = values[1:]")([5.0, 1.0]) == 1.0
    assert changed("sum(values) => sum(values)", "+ total = -total")([5.0, 1.0]) == -3.0
    assert changed("total = 0.0 => total = 1.0", "+ return total")([]) == 1.0
    nested = ("+ for value in values:", "+     if value < 0:", "+         return None")
    assert changed(*nested)([-1.0]) is None and changed(*nested)([1.0]) == 1.0


def test_a_change_that_does_not_fit_or_a_catalogue_that_lacks_something_is_refused():
    for line, complaint in [
        ("median => mode", "the solution has no 'median'"),
        ("total => sum", "the solution has 'total' 3 times"),
        ("count(values) => count(values", "the changed solution cannot be run: SyntaxError"),
    ]:
        with pytest.raises(PlanError, match="mean: mistake 'slip': ") as caught:
            publish("90_toy", LessonPlan([exercise(f"slip\n    {line}\n    A message.")]), solution())
        assert complaint in str(caught.value)
    for text, complaint in [
        ("    sum => max\nslip", "begins with a mistake's name"),
        ("slip\n    A message.", "'slip' has no change"),
        ("slip\n    sum => max\nother\n    sum => min\n    A message.", "'slip' has no message"),
    ]:
        with pytest.raises(ChangeError, match=complaint):
            catalogue(text)


def test_a_change_needs_the_solutions_text_and_can_be_looked_for_but_not_called_before_it_is_applied():
    plan = LessonPlan([exercise("slip\n    sum => max\n    A message.")])
    with pytest.raises(ChangeError, match="only functions of the solution are given"):
        with_functions(plan, {"mean": solution()["mean"]})
    with pytest.raises(ChangeError, match="apply it"):
        plan.exercises[0].mistakes[0].function([1.0])
    lines = "    + total = sum(values) * 2 + len(values)\n    + return total\n"
    (slip,) = catalogue(f"slip\n{lines}    A message.")
    assert list(fingerprints(slip.function.inserted))


def test_a_message_may_go_over_several_lines_and_is_published_with_the_wrong_answers():
    text = "slip\n    total / count => total * count\n    You multiply.\n    Divide instead."
    (public,) = publish("90_toy", LessonPlan([exercise(text)]), solution()).exercises
    assert public.mistakes[0].message == "You multiply. Divide instead."
    assert public.mistakes[0].answers == {"0": 6.0, "1": 18.0}
