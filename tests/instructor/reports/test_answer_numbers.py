"""Numbers in written answers: read as people write them, and no world is named that chance explains."""

import numpy as np
import pytest

from nao_course.instructor.reports.answer_numbers import chance_of_agreement, compare_numbers, numbers_in

NUMBERS = {"ada": (1.0834, 0.0329), "bob": (1.3116, 0.0411), "cyd": (0.91, 0.02), "dan": (2.2, 0.05)}
WORLDS = {name: {"mean": mean, "error": error} for name, (mean, error) in NUMBERS.items()}


def contains(text, value):
    return any(each.is_rounded(value) for each in numbers_in(text))


FOUND = "1.08; 1,083; Mean: 1.0834!; (1.08; from 1.08 to 2; 1.08.; 0-1.08; 1.05 \u2013 1.08; 10.834e-1; +1.08"
OTHERS = "; 1.1; 1.09; 11.08; 108; 1.0836567891; -1.08; \u22121.08; 1.07"


def test_a_rounded_number_is_found_in_an_answer_and_a_dash_is_not_a_sign():
    precise = ("1.0834000000000001", "1.08341\u00b10.01", "mean=1.0833561243")
    assert [text for text in (*FOUND.split("; "), *precise) if not contains(text, 1.0834)] == []
    assert [text for text in (*OTHERS.split("; "), "1." + "0" * 99) if contains(text, 1.0834)] == []
    for minus in "-\u2212\u2013":
        assert contains(f"It is {minus}0.25 m.", -0.25) and not contains(f"It is {minus}0.25 m.", 0.25)
        assert contains(f"0.30{minus}0.45 m", 0.45) and not contains(f"0.30{minus}0.45 m", -0.45)


def test_a_marker_reads_which_of_a_students_numbers_are_in_the_answer():
    (line,) = compare_numbers("It is 1.08 on average.", "ada", WORLDS)
    assert "mean 1.083 (in the answer)" in line and "error 0.033 (not in the answer)" in line
    assert list(compare_numbers("It is 1.08.", "eve", WORLDS)) == []
    both = "In the example 1.3116 and 0.0411, mine are 1.0834129384756123 and 0.03290019847261."
    assert len(list(compare_numbers(both, "ada", WORLDS))) == 1, "the own numbers explain the answer"


def worlds_of(size, seed):
    """Return numbers like the ones in lesson 07, where two decimals of the first number distinguish little."""
    values = np.random.default_rng(seed).normal((0.04, 1.3), (0.009, 0.3), (size, 2))
    return {f"s{k}": {"mean": mean, "error": error} for k, (mean, error) in enumerate(values.tolist())}


@pytest.mark.parametrize("size", [3, 8, 20, 40, 150])
@pytest.mark.parametrize("decimals", [2, 3, 4, 5])
def test_no_world_is_named_that_chance_explains_and_a_precise_copy_is(size, decimals):
    worlds, chance = worlds_of(size, 1), np.random.default_rng(2)
    named = copies = agreeing = 0
    estimates = []
    for _ in range(100):
        student, other = chance.choice(list(worlds), 2, replace=False)
        wrong, copied = (
            " ".join(
                f"{value * factor:.{decimals}f}" for value, factor in zip(of.values(), factors, strict=True)
            )
            for of, factors in ((worlds[student], chance.uniform(0.7, 1.3, 2)), (worlds[other], (1, 1)))
        )
        others = [worlds[name].values() for name in worlds if name != student]
        agreeing += any(all(contains(wrong, value) for value in each) for each in others)
        named += len(list(compare_numbers(wrong, student, worlds))) > 1
        copies += other in " ".join(list(compare_numbers(copied, student, worlds))[1:])
        estimates.append(chance_of_agreement(numbers_in(copied), [other], worlds))
    assert named <= 1
    assert copies == 100 or decimals < 4 or size < 20
    assert copies == 0 or decimals > 2
    assert agreeing / 100 <= 3 * np.mean(estimates) + 0.02  # the chance that is stated is the real one
