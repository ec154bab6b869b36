"""The challenge of lesson 01: what is scored, and where points are lost."""

from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.challenges import CaseResult, EntryReport, Run
from nao_course.lessons.hsl_filtering import harder_rooms
from nao_course.lessons.hsl_filtering.challenge import CHALLENGE, ENOUGH, ROOMS, f1, judge, on_the_field

TRUTH = np.array([[0, 0, 2, 0], [1, 0, 2, 3], [3, 1, 2, 1], [1, 1, 1, 1]], dtype=np.uint8)
SCENE = SimpleNamespace(
    pixels=np.zeros((4, 4, 3), dtype=np.uint8), truth=SimpleNamespace(labels=TRUTH, pose=None, view=None)
)


def judged(changed):
    """Return the score of the true labels with some of them changed."""
    labels = TRUTH.copy()
    for place, label in changed.items():
        labels[place] = label
    return judge(labels, SCENE)


def test_the_truth_scores_one_nothing_scores_nothing_and_f1_is_the_mean_of_precision_and_recall(rng):
    for same in (TRUTH, TRUTH.tolist(), TRUTH.astype(float)):
        assert judge(same, SCENE).score == 1.0
    assert judge(np.zeros_like(TRUTH), SCENE).score == 0.0
    assert judge(np.full_like(TRUTH, 3), SCENE).columns["yellow"] == 0.0
    called, there = rng.random((2, 30, 40)) < [[[0.4]], [[0.2]]]
    precision, recall = (called & there).sum() / called.sum(), (called & there).sum() / there.sum()
    assert f1(called, there) == pytest.approx(2 * precision * recall / (precision + recall))


def test_white_behind_the_field_costs_nothing_and_an_array_of_the_students_own_kind_never_meets_the_truth():
    assert on_the_field(TRUTH).astype(int).ravel().tolist() == list(map(int, "0000100111011111"))
    behind, on, yellow = judged({(0, 0): 3}), judged({(3, 3): 3}), judged({(0, 0): 2}).columns
    assert behind.score == 1.0 > on.score and behind.columns["white behind"] == pytest.approx(100 / 7)
    assert on.columns["false white"] == pytest.approx(100 / 9) and yellow["yellow"] == pytest.approx(6 / 7)
    assert yellow["false yellow"] == pytest.approx(100 / 16)
    met = []

    class Spy(np.ndarray):
        def __array_ufunc__(self, ufunc, method, *inputs, **named):
            met.extend(inputs)
            return super().__array_ufunc__(ufunc, method, *inputs, **named)

    assert judge(TRUTH.view(Spy), SCENE).score == 1.0 and met == []


def test_thirty_scenes_half_of_them_dark_are_the_same_each_time_and_give_only_their_picture():
    names = [str(seed) for seed in CHALLENGE.seeds]
    assert len(set(names)) == 30 and [names[i] for i in (0, 20, -1)] == ["dark 1", "harsh 6", "harsh 15"]
    rooms = [room for rooms in ROOMS.values() for room in rooms]
    assert len(set(rooms)) == len(rooms) and not set(rooms) & set(range(900, 918))  # those that were tuned on
    place = CHALLENGE.seeds[4]  # the first picture from there shows no goal
    first, second = CHALLENGE.make(place), CHALLENGE.make(place)
    assert (first.pixels == second.pixels).all()
    assert min((first.truth.labels == label).sum() for label in (2, 3)) >= ENOUGH
    (given,) = CHALLENGE.given(first)
    assert given is first.pixels


def test_the_figure_shows_what_each_colour_cost_and_the_harder_rooms_are_those_with_the_lower_mean():
    results = []
    for place, labels in ((0, TRUTH), (20, np.where(TRUTH == 3, 1, TRUTH))):
        seed, scored = CHALLENGE.seeds[place], judge(labels, SCENE)
        results.append(CaseResult(seed, str(seed), scored.score, scored.columns, scored.kept))
    drawing = CHALLENGE.figure(Run(CHALLENGE, tuple(results)))
    bars, *pictures = drawing.figure.axes
    assert len(pictures) == 3 and pictures[0].get_title(loc="left") == "worst: harsh 6, 0.50"
    heights = np.array([bar.get_height() for bar in bars.patches]).reshape(3, 2)
    assert heights.sum(axis=0) == pytest.approx(1.0) and heights[1].tolist() == [0.0, 0.5]
    assert "harsh 6 with 0.50" in drawing.alt
    scores = {"dark": 0.4, "harsh": 0.6}
    name_of, seeds = CHALLENGE.name_of, CHALLENGE.seeds
    results = tuple(CaseResult(place, name_of(place), scores[place.preset]) for place in seeds)
    assert harder_rooms(EntryReport(Run(CHALLENGE, results))) == "dark"
    with pytest.raises(NotImplementedError):
        harder_rooms(EntryReport(Run(CHALLENGE, results[:3])))
