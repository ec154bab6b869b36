"""Reading the paper's table: which means are possible, and what was recorded on other pictures."""

import json

import numpy as np
import pytest
from scipy.stats import binom

from nao_course.lessons.experiments import reading
from nao_course.lessons.experiments.paper_table import BETAS, GAPS, LENGTHS, SETTINGS
from nao_course.lessons.experiments.resampling import as_table, optimism, placebo, shares_won
from nao_course.lessons.experiments.scenes import nothing_costs, simulated_scenes
from tests.lessons.every import quotes
from tests.lessons.experiments.own import OWN, TEXT, table
from tests.paths import PROJECT


def measured():
    return json.loads((PROJECT / "benchmarks" / "results" / "experiments.json").read_text(encoding="utf-8"))


def test_the_text_says_which_of_the_papers_means_are_possible_and_with_how_many_hits():
    cannot = reading.impossible_means(OWN["possible_hits"])
    assert len(cannot) == 13 == measured()["impossible"] and (130, 4, 30) in cannot
    assert "14 or more of 27 would pass in 3 of 100 random tables" in TEXT
    assert 0.28 < measured()["by chance possible"] < 0.38
    assert round(100 * binom.sf(13, 27, measured()["by chance possible"])) == 3
    hits = {key: OWN["possible_hits"](mean, 30, 240) for key, mean in reading.PAPER_MEANS.items()}
    many = sorted((int(each.min()), key) for key, each in hits.items() if len(each) and each.min() > 1)
    assert [least for least, _ in many] == [25, 115, 135, 225]
    assert "at least 25, 115, 135 and 225" in TEXT
    others = {least: round(30 * reading.PAPER_MEANS[key] + 1.333 * least) for least, key in many}
    false = [int(np.ceil((others[least] - (240 - least)) / 5)) for least in (115, 135, 225)]
    assert false == [25, 45, 88] and "at least 25, 45 and 88 false reports" in TEXT
    rest = {key for key, each in hits.items() if len(each)} - {key for _, key in many}
    assert rest == set(reading.ninetieths())
    assert len(reading.ninetieths()) == 27 - measured()["impossible with four thirds"] == 10
    assert (120, 5, 40) in reading.ninetieths() and (110, 4, 40) not in reading.ninetieths()
    numbers = np.arange(2000, 10000) / 1000
    chance = np.mean([abs(90 * each - round(90 * each)) <= 0.045 + 1e-9 for each in numbers])
    assert "By chance only 9 % of all numbers" in TEXT and round(100 * chance) == 9
    assert "one of 14000 tables" in TEXT and round(1 / binom.sf(9, 27, chance), -3) == 14000
    alt = reading.draw_possible(OWN["possible_hits"]).alt
    assert "For 13 there is none" in alt and "For the best setting there are 9 from 1 to 25" in alt
    assert "possible with 1, 4, 7 hits and so on, up to 238" in TEXT
    hits = np.arange(241)
    possible = np.abs(90 * 2.122 + 4 * hits - 3 * np.round(30 * 2.122 + 4 * hits / 3)) <= 0.045
    assert hits[possible].tolist() == list(range(1, 241, 3))
    assert "at most 25 hits" in TEXT and "With four thirds for a hit 10 means are possible" in alt


def test_what_is_recorded_beside_the_lesson_is_what_the_benchmark_found_in_the_papers_order():
    assert reading.recorded() == measured()["sets"]
    assert all(len(each["means"]) == len(SETTINGS) for each in reading.recorded().values())
    means = reading.recorded_means("simulator, other rooms")
    assert np.allclose(list(means.values()), reading.recorded()["simulator, other rooms"]["means"])
    alt = reading.draw_sizes().alt
    best = reading.recorded_means("160 x 120, the same pixels")[120, 5, 40]
    assert f"160 x 120, the same pixels: {best:.2f}" in alt and "Nothing costs 2.03" in alt


def test_a_table_without_noise_agrees_with_itself_and_noise_does_not_and_equal_means_are_equal():
    alt = reading.draw_agreement(table()).alt
    assert alt.count("95 % from") == 5 and "The paper's with simulator, other rooms 0.51" in alt
    rng = np.random.default_rng(3)
    means = dict(zip(SETTINGS, np.arange(27.0), strict=True))
    sure = {key: mean + rng.normal(0, 0.1, 30) for key, mean in means.items()}
    middle, low, high = reading.agreement(sure, {"itself": means})["itself"]
    assert low > 0.95 and low - 1e-9 <= middle <= high + 1e-9
    noise = {key: rng.normal(0, 1, 30) for key in SETTINGS}
    middle, low, high = reading.agreement(noise, {})[reading.HALVES]
    assert -0.5 < middle < 0.5 and low < 0 < high
    one = {key: np.array([0.1, 0.2, 0.3]) for key in SETTINGS}
    one[SETTINGS[0]] = np.array([0.3, 0.2, 0.1]) + 1e-12
    one[SETTINGS[1]] = np.array([5.0, 5.0, 5.0])
    other = {key: float(key == SETTINGS[1]) for key in SETTINGS}
    assert reading.agreement(one, {"other": other})["other"][0] > 0.999


def test_what_the_text_says_of_other_pictures_is_what_was_recorded():
    tables = {name: reading.recorded_means(name) for name in reading.AGREEING}
    own = reading.recorded_means("320 x 240, the same pixels")
    rho = [reading.rank_correlation(own, each) for each in tables.values()]
    assert [f"{each:.2f}" for each in rho] == ["0.72", "-0.06", "0.71"]
    assert "(0.72)" in TEXT and "(0.71)" in TEXT and "(-0.06)" in TEXT
    eight = tables["a real NAO, eight places"].values()
    half, twice = (
        [reading.recorded_means(f"{size}, {how}")[120, 5, 40] for how in ("the same pixels", "in proportion")]
        for size in ("160 x 120", "640 x 480")
    )
    costs = (f"{each:.2f}" for each in (*half, *twice, own[120, 5, 40]))
    quotes(TEXT, f"{min(eight):.2f} and {max(eight):.2f}", *costs)


@pytest.mark.slow
def test_the_numbers_of_the_lessons_own_search_are_those_of_its_solution():
    found = OWN["grid_search"](simulated_scenes(), list(BETAS), list(GAPS), list(LENGTHS))
    best = min(found, key=lambda key: found[key].mean())
    low, high = OWN["bootstrap_interval"](found[best], 0.95, np.random.default_rng(0))
    halves = optimism(as_table(found))
    quotes(
        TEXT,
        f"120, 7, 50 costs {found[best].mean():.2f}",
        f"{low:.1f} to {high:.1f}",
        f"costs {found[120, 5, 40].mean():.2f}",
        f"{halves.promised.mean():.2f} on the first half and {halves.kept.mean():.2f} on the second",
    )
    assert sorted(found[130, 7, 30])[-2:] == sorted(found[130, 7, 30][[10, 14]]) == [16, 26]
    assert 0.3 < shares_won(found)[best] < 0.37
    close, far = (found[key] - found[best] for key in ((120, 4, 50), (130, 7, 30)))
    assert (close == 0).sum() == 26 and (close >= 0).all() and "as your best in 26 pictures" in TEXT
    low, high = OWN["bootstrap_interval"](far, 0.95, np.random.default_rng(0))
    quotes(TEXT, f"{far.min():.1f} to {far.max():.0f}", f"{low:.1f} to {high:.1f}")
    equal = placebo(as_table(found))
    low, high = np.quantile(equal, (0.1, 0.9))
    assert f"{equal.mean():.0f} of 26 settings different on average ({low:.0f} to {high:.0f} in most" in TEXT
    rng, inside = np.random.default_rng(0), 0
    for _ in range(400):
        low, high = OWN["bootstrap_interval"](rng.choice(found[130, 7, 30], 30), 0.95, rng)
        inside += low <= found[130, 7, 30].mean() <= high
    assert inside / 400 == pytest.approx(0.87, abs=0.03) and "87 % of samples" in TEXT
    others = {name: reading.recorded_means(name) for name in reading.AGREEING}
    agree = reading.agreement(found, others)
    assert [f"{agree[name][0]:.2f}" for name in reading.AGREEING] == ["0.72", "-0.06", "0.71"]
    quotes(TEXT, f"{agree[reading.HALVES][0]:.2f}")
    costs = np.array([found[key] for key in SETTINGS])
    assert set(np.argsort(costs.mean(axis=0))[-3:] + 1) == {25, 11, 15} and (costs[:, 24] == 4).all()
    above = [int((costs[:, number - 1] > 1).sum()) for number in (11, 15)]
    highest = [costs[:, number - 1].max() for number in (11, 15)]
    quotes(TEXT, f"With {above[0]} of the 27 settings", f"picture 15 does with {above[1]} settings")
    assert f"they cost {highest[0]:.0f} and {highest[1]:.0f}." in TEXT
    long = {key: costs[row, 10] for row, key in enumerate(SETTINGS) if key[2] == 50}
    assert [key for key, cost in long.items() if cost > 1] == [(110, 7, 50)] and "110, 7, 50" in TEXT


@pytest.mark.slow
def test_the_text_names_the_settings_of_the_panel_that_surely_cost_less_than_nothing():
    scenes = simulated_scenes()

    def costs_of(*setting, scenes=scenes):
        costs = OWN["grid_search"](scenes, *([each] for each in setting))[setting] - nothing_costs(scenes)
        return costs.mean(), *OWN["bootstrap_interval"](costs, 0.95, np.random.default_rng(0))

    lengths = [each for each in range(15, 85, 5) if costs_of(120, 5, each)[2] < -0.03]
    gaps = [each for each in range(1, 16) if costs_of(120, each, 40)[2] < -0.03]
    betas = [each for each in range(80, 185, 5) if costs_of(each, 5, 40)[2] < -0.03]
    assert lengths == [45, 60, 65, 70, 75] and "| length | 45, 60, 65, 70, 75 px |" in TEXT
    assert gaps == [2, 8] and "| gap | 2, 8 px (" in TEXT
    assert betas == [140, 145, 155, 165, 180] and "| beta | 140, 145, 155, 165, 180 |" in TEXT
    mean, low, high = costs_of(165, 5, 40)
    assert f"(at 165 the difference is {mean:.2f}, from about {low:.1f} to {high:.1f})" in TEXT
    mean, low, high = costs_of(165, 5, 40, scenes=simulated_scenes(seed=1))
    assert f"the difference of 165, 5, 40 is {mean:.2f}, from about {low:.1f} to {high:.1f}." in TEXT
