"""Copies are found however they are disguised; what independent students have in common is not."""

from itertools import pairwise

import pytest
from copydetect.utils import filter_code

from benchmarks.course.similar import CHANGES, Lesson, given, listed
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.similarity import comparing
from nao_course.instructor.similarity.comparing import COMMON, Work, compare
from nao_course.instructor.similarity.known_code import alternatives, given_code, known_code, right_answers
from tests.paths import PROJECT

OWN = '''
def centre(points, weights):
    """Find the weighted centre."""
    total = 0.0
    moment = np.zeros(2)
    for point, weight in zip(points, weights):
        if weight <= 0 or not np.isfinite(point).all():
            continue  # an outlier
        moment = moment + weight * np.asarray(point)
        total += weight
    if total == 0:
        raise ValueError("no point has a weight")
    residuals = np.asarray(points) - moment / total
    radius = np.sqrt((residuals**2).sum(axis=1)).max()
    return moment / total, radius, sorted(range(len(points)), key=lambda i: -weights[i])[:3]
'''
OTHER = """
def centre(points, weights):
    keep = [i for i, w in enumerate(weights) if w > 0]
    chosen, good = points[keep], weights[keep]
    middle = np.average(chosen, axis=0, weights=good)
    order = np.argsort(-weights)
    return middle, np.linalg.norm(points - middle, axis=-1).max(), order[:3].tolist()
"""


def works_of(codes):
    codes = [(code,) if isinstance(code, str) else tuple(code) for code in codes]
    return [Work(f"s{number:02d}", code) for number, code in enumerate(codes)]


def pairs_of(*codes, known=()):
    return [(each.first.student, each.second.student) for each in compare(works_of(codes), known).pairs]


@pytest.fixture(scope="module", params=["02_goalposts", "08_graph_slam"])
def lesson(request):
    course = load_course(PROJECT)
    return Lesson(given(course, request.param), right_answers(course, request.param))


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_changed_copy_is_found(change):
    assert change(OWN) != OWN
    assert pairs_of(OWN, OTHER, change(OWN)) == [("s00", "s02")]


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_changed_copy_of_a_whole_notebook_is_found(lesson, change):
    assert all(listed(shared, share) for shared, share, _ in lesson.copied(change))


def test_independent_right_answers_are_not_found(lesson):
    assert not any(listed(*each) for each in lesson.independent())


def test_the_marked_passages_are_what_both_have():
    renamed = OWN.replace("moment", "m").replace("total", "sum_of_weights")
    (pair,) = compare(
        [Work("ada", ("# mine\n", f"{OTHER}{OWN}")), Work("ben", (f"\nx = 1\n{renamed}", OTHER))], [OTHER]
    ).pairs
    for work, passages in zip((pair.first, pair.second), pair.passages, strict=True):
        marked = "".join(work.code[start:end] for start, end in passages)
        assert "np.isfinite(" in marked and "np.average" not in marked
        assert all(before[1] < after[0] for before, after in pairwise(passages))


def test_what_is_known_released_or_of_the_solution_is_not_found():
    assert pairs_of(OWN, OWN) and not pairs_of(OWN, OWN, known=[OWN])
    assert pairs_of(OWN, OWN, known=[OTHER])
    course, lesson = load_course(PROJECT), "02_goalposts"
    known = known_code(course, lesson)
    solution = [codes[0] for codes in right_answers(course, lesson).values()]
    for code in (given_code(course, lesson), solution):
        assert not pairs_of(code, code, known=known)


def test_copies_in_any_number_are_named_and_two_sources_of_common_code_are_two_lists():
    distinct = [f"{OWN}\ny = {str(number) * 60}" for number in range(COMMON + 1)]
    assert len(pairs_of(*distinct[:COMMON])) == COMMON * (COMMON - 1) / 2
    assert len(pairs_of(*[OWN] * (COMMON + 1))) == COMMON * (COMMON + 1) / 2
    found = compare(works_of([*distinct, OTHER]), known=())
    (common,) = found.common
    assert not found.pairs
    assert [each.student for each in common.works] == [f"s{k:02d}" for k in range(COMMON + 1)]
    marked = "".join(common.works[0].code[start:end] for start, end in common.passages)
    assert "np.isfinite(" in marked and min(common.shares) > 0.8
    codes = [f"{code}\ny = {str(number) * 60}" for code in (OWN, OTHER) for number in range(COMMON + 1)]
    found = compare(works_of([*codes, OWN + OTHER]), known=()).common
    groups = [{each.student for each in common.works} for common in found]
    apart = {"s00", f"s{COMMON + 1:02d}"}
    assert len(groups) >= 2 and not any(apart <= group for group in groups)


@pytest.mark.slow
def test_a_notebook_that_contains_the_others_does_not_make_them_a_group():
    course = load_course(PROJECT)
    lessons = [name for name in course.names() if right_answers(course, name)][1:6]
    honest = [max((codes[0] for codes in right_answers(course, name).values()), key=len) for name in lessons]
    works = [Work(f"s{number}", (code,)) for number, code in enumerate(honest)]
    assert not compare(works, known=()).pairs
    pairs = compare([*works, Work("eve", tuple(honest))], known=()).pairs
    assert len(pairs) == len(honest) and {each.group for each in pairs} == {2}
    assert all(each.shares[1] == 1 > each.shares[0] and each.first.student == "eve" for each in pairs)
    copies = compare([Work(name, (OWN,)) for name in ("ada", "ben", "cyd")], known=()).pairs
    assert {each.group for each in copies} == {3}


def test_the_work_for_a_pair_does_not_grow_with_the_number_of_its_cells(monkeypatch):
    # The engine reads each different cell once, and no cell is compared with another one.
    read = []
    monkeypatch.setattr(comparing, "filter_code", lambda *args: read.append(args) or filter_code(*args))
    cells = tuple(f"y = {'x + ' * 12}{number:05d}" for number in range(400))
    works = [Work(name, (*cells, f"z = {name!r}")) for name in ("ada", "ben", "cyd")]
    pairs = compare(works, known=()).pairs
    assert len(pairs) == 3 and len(read) == len(cells) + len(works)
    for pair in pairs:
        assert all(len(passages) == len(cells) for passages in pair.passages)


def test_a_little_in_common_is_not_found_and_any_text_can_be_compared(monkeypatch):
    short = "x = np.linspace(0, 1, 11, endpoint=False)\n"
    assert not pairs_of(short, short) and not pairs_of(short, short.replace(")", ",)"))
    monkeypatch.setattr(comparing, "LEAST_SHARED", 1)
    assert pairs_of(short, short)
    for code in ("", "\n", "def (", "%matplotlib inline\n!ls", "\x00", "x = '\ud83d'", "\ufeff\r\n"):
        assert pairs_of(code, OWN, code, OWN) == [("s01", "s03")]


def test_code_that_alternatives_share_is_in_none_of_them():
    text = (
        "def _adapt(f):\n    return lambda x: f(x)\n"
        "def _loop(x):\n    return sum(x)\n"
        "class _Total:\n    def __call__(self, x):\n        return _loop(x)\n"
        "MORE = {'a': _adapt(np.sum), 'b': _adapt(math.fsum), 'c': _Total}\n"
        "E = Exercise('total', alternatives=MORE)\nF = Exercise('sum', alternatives=MORE)\n"
    )
    found = alternatives(text)
    assert found["sum"] == found["total"]
    assert found["total"][:2] == ["_adapt(np.sum)", "_adapt(math.fsum)"]
    assert found["total"][2].startswith("def _loop(x):") and "class _Total:" in found["total"][2]


@pytest.mark.slow
def test_every_lessons_alternatives_are_found():
    course = load_course(PROJECT)
    for lesson in course.names():
        answers = right_answers(course, lesson)
        declared = {each.name: len(each.alternatives) for each in course.plan(lesson).exercises}
        assert {name: len(codes) - 1 for name, codes in answers.items()} == declared
        assert all(code.strip() for codes in answers.values() for code in codes)
