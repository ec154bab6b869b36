"""How often the numbers of a personal world accuse a student by chance, and how many copied answers are found.

``python -m benchmarks personal_worlds`` draws classes of answers to the questions of five lessons. Own answers have all
numbers wrong by up to 30 %; copied answers have the numbers of another student's world. Lesson 10 is left out, because
its thirty pictures for each student take too long.
"""

import numpy as np

from benchmarks import ROOT, Result, Table
from nao_course._internal.personal_world import EXAMPLE, PersonalWorld
from nao_course.exercises.earlier import resolved_by
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.plans import load_solution, solutions_beside
from nao_course.instructor.commands.personal_numbers import numbers_of
from nao_course.instructor.reports.answer_numbers import compare_numbers, numbers_in

CLASSES = (20, 40, 150)
THREE = ((2, 2, 2), (3, 3, 3))
DECIMALS = {  # of the numbers; the tables show (3, 2) in lesson 07, and three of each number in the others
    "01_hsl_filtering": THREE,
    "04_distance": ((2, 2), (3, 3)),
    "06_localization": THREE,
    "07_ekf_slam": ((2, 2), (3, 2), (4, 3)),
    "12_beyond": THREE,
}
ANSWERS = 1000  # of each kind


def numbers_of_worlds(lesson: str, many: int) -> dict[str, dict[str, float]]:
    """Return the numbers of the first personal worlds of a lesson, and of the example."""
    course = load_course(ROOT)
    notebook = course.solutions / f"{lesson}.ipynb"
    (question,) = (each for each in course.plan(lesson).written if each.numbers is not None)
    assert question.numbers is not None
    with resolved_by(solutions_beside(notebook)):
        solution = load_solution(notebook)
        names = {EXAMPLE: "", **{f"student{number}": f"student{number}" for number in range(many)}}
        return {
            shown: dict(numbers_of(PersonalWorld(name), question.numbers, solution))
            for shown, name in names.items()
        }


def measure(
    worlds: dict[str, dict[str, float]], decimals: tuple[int, ...], chance: np.random.Generator
) -> dict[str, float]:
    """Return the shares of own answers that agree with a world or are named, and of copies that are named."""
    students = [name for name in worlds if name != EXAMPLE]
    agreeing, accused, found = 0, 0, 0

    def answer(values: np.ndarray) -> str:
        return " and ".join(f"{value:.{places}f}" for value, places in zip(values, decimals, strict=True))

    for _ in range(ANSWERS):
        student, other = chance.choice(students, 2, replace=False)
        own, copied = (np.array(list(worlds[name].values())) for name in (student, other))
        wrong = answer(own * chance.uniform(0.7, 1.3, len(own)))
        written = numbers_in(wrong)
        agreeing += any(
            all(any(each.is_rounded(value) for each in written) for value in numbers.values())
            for name, numbers in worlds.items()
            if name != student
        )
        accused += len(list(compare_numbers(wrong, student, worlds))) > 1
        found += any(other in line for line in list(compare_numbers(answer(copied), student, worlds))[1:])
    return {"agree": agreeing / ANSWERS, "accused": accused / ANSWERS, "copies found": found / ANSWERS}


def main() -> Result:
    """Measure classes of three sizes in each lesson, with two or three precisions."""
    chance = np.random.default_rng(0)
    values, rows = {}, []
    for lesson, precisions in DECIMALS.items():
        worlds = numbers_of_worlds(lesson, max(CLASSES))
        for size in CLASSES:
            some = dict(list(worlds.items())[: size + 1])
            for decimals in precisions:
                shares = measure(some, decimals, chance)
                kind = ", ".join(map(str, decimals))
                values[f"{lesson}, {size} students, {kind} decimals"] = shares
                rows.append((lesson, size, kind, *(f"{100 * share:.1f} %" for share in shares.values())))
    table = Table(
        "Answers to the questions about personal worlds",
        (
            "lesson",
            "students",
            "decimals",
            "wrong answers that agree with a world",
            "of these named",
            "copies named",
        ),
        tuple(rows),
    )
    return Result("personal_worlds", values, (table,))
