"""A function that draws random samples is judged by the law of its answers, which come one by one."""

import numpy as np
import pytest

from nao_course.exercises import judging
from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.sampling import Sampled, each_seed
from nao_course.exercises.running import Outcome, call

VALUES = np.arange(100.0).reshape(10, 10)
LAW = Sampled()


def law(function, n_samples=40, repeats=300):
    case = Case((VALUES, n_samples, repeats))
    return judging.answer(LAW, lambda each: call(function, each, "each_seed"), case).value


def sample(values, n_samples, rng):
    return values.ravel()[rng.integers(0, values.size, n_samples)].mean()


def test_a_random_sample_is_judged_by_its_law_and_is_like_another_of_its_kind():
    for function, said in [
        (lambda v, n, rng: own(v, n, rng), "the same rng gave two different"),
        (lambda v, n, rng: v.mean(), "for every rng"),
        (lambda v, n, rng: sample(v, n, np.random.default_rng(7)), "for every rng"),
        (lambda v, n, rng: rng.choice(v.ravel()), "the scatter of your answers"),
        (lambda v, n, rng: 2 * sample(v, n, rng), "the mean of your answers"),
        (lambda v, n, rng: None, "a return may be missing"),
        (lambda v, n, rng: [sample(v, n, rng)], "a list, not one number"),
        (lambda v, n, rng: True, "your answer is a bool, not one number"),
    ]:
        assert said in LAW.compare(law(sample), law(function)).text
    assert LAW.alike(law(own), law(own))
    assert not LAW.alike(law(own), law(sample))
    nothing = law(lambda *_: None)
    assert LAW.alike(nothing, nothing) and not LAW.alike(nothing, law(sample))


def test_noise_of_the_right_size_around_the_mean_is_not_a_sample_and_another_way_to_draw_it_is():
    def noisy(v, n, rng):
        return v.mean() + rng.normal(0, v.std() / np.sqrt(n))

    assert LAW.compare(law(sample), law(noisy)), "forty values have nearly a normal mean"
    verdict = LAW.compare(
        law(lambda v, n, rng: float(rng.choice([0.0, 250.0], n).mean()), 1),
        law(lambda v, n, rng: rng.normal(125, 125), 1),
    )
    assert verdict.kind == "law" and "not their distribution" in verdict.text
    for right in (
        lambda v, n, rng: rng.choice(v.ravel(), n, replace=False).mean(),
        lambda v, n, rng: rng.permutation(v.ravel())[:n].mean(),
    ):
        assert LAW.compare(law(sample), law(right))


def own(v, n, rng):
    return np.random.default_rng().choice(v.ravel(), n).mean()


def test_each_call_has_the_generator_of_its_seed_and_inputs_of_its_own_and_the_first_come_again():
    (asked,) = LAW.calls(Case((VALUES, 40, 30)))
    drawn = each_seed(lambda values, n_samples, rng: rng.random(), *asked.args)
    assert len(drawn) == 38 and list(drawn[30:]) == list(drawn[:8])
    assert len(set(drawn)) == 30
    assert len(LAW.calls(Case((VALUES, 1, 3)))[0].args[-1]) == 6

    def greedy(values, n_samples, rng):
        values += 1
        return float(values[0, 0])

    given = VALUES.copy()
    assert list(each_seed(greedy, given, 40, [1, 2, 3])) == [1.0, 1.0, 1.0]
    assert (given == VALUES + 1).all()  # by the last call, so that a change of the arguments is noticed
    case = Case((VALUES, 300), kwargs={"scale": 2.0})
    assert all(each.kwargs == {"scale": 2.0} for each in LAW.calls(case))
    seeds = [0, 7, 279, 7]
    made = each_seed(lambda values, n_samples, rng: [rng], VALUES, 40, seeds)
    for seed, (rng,) in zip(seeds, made, strict=True):
        usual = np.random.default_rng(seed)
        assert rng.bit_generator.state == usual.bit_generator.state
        for a, b in zip((*rng.spawn(2), *rng.spawn(1)), (*usual.spawn(2), *usual.spawn(1)), strict=True):
            assert (a.random(3) == b.random(3)).all()


FORGED = law(sample)


@pytest.mark.parametrize(
    "hostile",
    [FORGED, FORGED["law"], {"other": ""}, (49.5, 4.5, True), [1.0], "x", None, 1j, True, 10**400, np.nan],
    ids=lambda value: type(value).__name__,
)
def test_no_answer_takes_the_place_of_the_law(hostile):
    right = law(sample)
    answers = [sample(VALUES, 40, np.random.default_rng(seed)) for seed in (*range(300), *range(8))]
    assert LAW.compare(right, LAW.gather(Case(()), [answers]))
    for forged in (hostile, [hostile] * 308, [1.0, hostile] * 154, answers[:-1], [*answers, 1.0], [answers]):
        assert not LAW.compare(right, LAW.gather(Case(()), [forged]))


def test_the_first_call_without_a_value_is_what_came_of_the_case():
    def fails(values, n, rng):
        raise KeyError

    outcome = judging.answer(LAW, lambda each: call(fails, each), Case((VALUES, 1, 300)))
    assert outcome.status == "raised"
    calls = []
    judging.answer(LAW, lambda each: calls.append(each) or Outcome("timed out"), Case((VALUES, 1, 300)))
    assert len(calls) == 1
