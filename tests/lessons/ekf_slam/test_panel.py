"""The film panel: the filter runs once, and the film holds what it computed."""

import numpy as np
import pytest

from nao_course.films.film import frames_of
from nao_course.lessons.ekf_slam.film import UPDATED, correlations, record_film
from nao_course.lessons.ekf_slam.panel import FilmPanel
from tests.lessons.every import blank

HALF = 0.0005 + 1e-9  # m and rad: the largest difference of a number and its rounded millimetres


@pytest.fixture
def panel(film_functions):
    return FilmPanel(*film_functions)


def test_the_filter_runs_once_and_a_function_defined_again_is_used_when_the_film_is_played(film_functions):
    init_landmarks, predict, update = film_functions
    calls = []

    def counted(*given):
        calls.append(1)
        return update(*given)

    panel = FilmPanel(init_landmarks, predict, counted)
    panel._asked(None, {"ask": "newest"}, [])  # Play was pressed, and nothing has changed
    assert len(calls) == 25
    module = {"update": lambda *given: update(*given)}
    exec("def later(*given): return update(*given)", module)
    panel = FilmPanel(init_landmarks, predict, module["later"])
    before = panel.film.to_json()
    module["worse"] = lambda state, covariance, *given: (state, covariance)
    exec("def later(*given): return worse(*given)", module)
    panel._asked(None, {"ask": "newest"}, [])
    assert panel.film.to_json() != before


def test_the_film_holds_the_run_within_its_rounding(panel, film_functions):
    film = record_film(*film_functions)
    data = panel.film.data()
    kinds = [each["kind"] for each in data["layers"]]
    path = frames_of(data, kinds.index("path"))
    states = np.array([film.at(number)[1][:3] for number in range(film.last + 1)])
    assert np.abs(np.vstack(path) - states).max() <= HALF
    landmarks = [
        n for n, each in enumerate(data["layers"]) if kinds[n] == "points" and len(each["frames"]) > 1
    ]
    for number, places in enumerate(frames_of(data, landmarks[0])):
        assert np.abs(places - film.at(number)[1][3:].reshape(-1, 2)).max() <= HALF
    [updated] = [
        n for n in range(len(kinds)) if data["layers"][n]["colour"] == UPDATED and kinds[n] == "ellipses"
    ]
    shown = frames_of(data, updated)
    assert [len(each) for each in shown] == [1 - number % 2 for number in range(film.last + 1)]
    for number in range(0, film.last + 1, 10):
        _, _, a, b, d = shown[number][0]
        root = np.array([[a, b], [b, d]])
        covariance = root @ root / (-2 * np.log(0.05))
        assert covariance == pytest.approx(film.at(number)[2][:2, :2], abs=3e-5)
    [matrix] = data["matrices"]
    last = np.array([each for each in matrix["frames"] if each is not None][-1]) / matrix["levels"]
    assert last == pytest.approx(correlations(film.at(film.last)[2])[np.triu_indices(15)], abs=0.0026)


def test_an_unfinished_exercise_is_named_without_a_film_and_an_error_can_be_raised(film_functions):
    init_landmarks, predict, _ = film_functions
    unfinished = FilmPanel(init_landmarks, predict, blank)
    assert "exercises 7.4 and 7.5" in unfinished.summary() and unfinished.film is None
    assert "exercises 7.4 and 7.5" in unfinished._status.value
    assert "exercise 7.2" in FilmPanel(blank, blank, blank).summary()

    def broken(*given):
        raise KeyError("gain")

    panel = FilmPanel(init_landmarks, predict, broken)
    assert "KeyError in update()" in panel.summary() and isinstance(panel.error, KeyError)


@pytest.mark.slow
def test_where_no_widget_lives_there_are_a_picture_and_words(panel):
    shown = panel._repr_mimebundle_()
    assert "data:image/png" in shown["text/html"]
    assert "correlation between landmarks 0.00" in shown["text/plain"]
