"""Accidents cost no more than what they hit, and honest work in any shape gets its points."""

import zipfile

import pytest

from tests.attacks import laws
from tests.attacks.accidents import ATTACKS, FILE, NAMES, TEXT, UNKNOWN
from tests.attacks.range import LESSON, POINTS, Attack, honest, points

AMPLE = 20.0  # seconds of a call: what is honest here has the time that it needs, however busy the machine


@pytest.fixture(scope="module")
def options():
    return {"seconds": AMPLE}


@pytest.mark.slow
def test_the_run_ends_well_and_leaves_nothing(graded):
    laws.nothing_is_left(graded, status=1)  # a zip in a zip may be work, and is not opened


@pytest.mark.slow
@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.name)
def test_an_accident_costs_what_is_stated_and_disturbs_nobody(attack, graded, alone, hidden):
    laws.hold(graded, attack, alone, hidden)


def _graded(range_, expected=0):
    """What a run over the range's submissions comes to."""
    before = range_.state()
    status, _, processes, output, *_ = range_.command()
    after = range_.state()
    assert (status, processes) == (expected, []), output
    assert before == after
    return output, *range_.kept()


@pytest.mark.slow
def test_what_is_no_notebook_of_a_lesson_is_named_with_its_reason_and_has_no_row(field):
    range_ = field(seconds=AMPLE)
    for number, (name, (content, _)) in enumerate(UNKNOWN.items()):
        folder = range_.submissions / f"s{number:02}"
        folder.mkdir(parents=True)
        (folder / name).write_bytes(content)
    range_.hand_in("zoe", honest(Attack("x", "honest"), "right"), {})
    output, results, _, _, _ = _graded(range_, expected=1)  # somebody's work may be among them
    assert list(results) == ["zoe"] and points(results["zoe"]) == POINTS
    for number, (name, (_, reason)) in enumerate(UNKNOWN.items()):
        (line,) = [line for line in output.splitlines() if line.strip().startswith(f"s{number:02}/{name}")]
        assert reason in line


@pytest.mark.slow
@pytest.mark.parametrize(
    "form", ["{name}/" + FILE, "{name}_" + FILE, "{name}_12_assignsubmission_file_/" + FILE]
)
def test_students_of_any_name_have_their_own_row_page_and_points(field, form):
    range_ = field(seconds=AMPLE)
    range_.submissions = range_.root / "in.zip"
    # Moodle's folders have no slash in their names: what lies within would look like the folders of several students.
    names = [name for name in NAMES if "/" not in name or "assignsubmission" not in form]
    with zipfile.ZipFile(range_.submissions, "w") as archive:
        for name in names:
            archive.writestr(form.format(name=name), TEXT)
    _, results, pages, students, again = _graded(range_)
    assert len(students) == len(set(students)) == len(names)
    assert again == 0
    assert all(points(result) == POINTS and result.lesson == LESSON for result in results.values())
    assert all(name.isprintable() and len(name) <= 120 for name in students)
    assert len(list((range_.grades / "feedback").rglob("*.html"))) == len(names)
    for page in pages.values():
        parser = laws.Elements()
        parser.feed(page)
        assert "nao_attack" not in parser.seen and "\x1b" not in page
