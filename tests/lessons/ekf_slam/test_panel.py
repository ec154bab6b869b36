"""The player: run once, then step by step, forwards and backwards, at speed."""

import pytest

from nao_course.lessons.ekf_slam.panel import FilmPanel


@pytest.fixture
def panel(film_functions):
    return FilmPanel(*film_functions)


def press(panel, name):
    panel._widgets[name].click()


def test_the_filter_runs_once_however_often_the_film_is_shown(film_functions):
    init_landmarks, predict, update = film_functions
    calls = []

    def counted(*given):
        calls.append(1)
        return update(*given)

    panel = FilmPanel(init_landmarks, predict, counted)
    for frame in (5, 6, 7, 50, 0):
        panel.set(frame=frame)
    assert len(calls) == 25


def test_buttons_go_on_and_back_and_stop_at_both_ends(panel):
    press(panel, "on")
    press(panel, "on")
    assert panel.values.frame == 2 and "After step 1, updated" in panel.summary()
    press(panel, "back")
    assert panel.values.frame == 1
    panel.set(frame=0)
    press(panel, "back")
    assert panel.values.frame == 0
    panel.set(frame=50)
    press(panel, "on")
    assert panel.values.frame == 50


def test_what_the_code_took_is_said_of_the_whole_log_and_not_as_if_the_panel_followed_it(panel, monkeypatch):
    monkeypatch.setattr("nao_course.widgets.function_panel.SLOW", -1.0)
    panel._update()
    assert "slows the panel down" not in panel._status.value
    fresh = FilmPanel(*panel._functions.values())
    assert (
        "ms for the whole log." in fresh._status.value and "slows the panel down" not in fresh._status.value
    )


def test_an_unfinished_exercise_is_named(film_functions):
    def blank(*given):
        raise NotImplementedError

    init_landmarks, predict, _ = film_functions
    assert "exercises 7.4 and 7.5" in FilmPanel(init_landmarks, predict, blank).summary()
    assert "exercise 7.2" in FilmPanel(blank, blank, blank).summary()


def test_where_no_widget_lives_there_are_a_picture_and_words(panel):
    shown = panel._repr_mimebundle_()
    assert (
        "data:image/jpeg" in shown["text/html"]
        and "correlation between landmarks 0.00" in shown["text/plain"]
    )
