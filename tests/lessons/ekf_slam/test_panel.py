"""The player: run once, then step by step, forwards and backwards, at speed."""

import asyncio

import pytest

from nao_course.lessons.ekf_slam import panel as player
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


def test_it_plays_to_the_end_and_back_to_the_start_and_stops_when_pressed_again(panel, monkeypatch):
    monkeypatch.setattr(player, "SPEEDS", dict.fromkeys(player.SPEEDS, 1e4))

    async def drive():
        panel.set(frame=46)
        press(panel, "forwards")
        assert panel.playing
        await panel._playing
        assert panel.values.frame == 50 and not panel.playing
        panel.set(frame=3)
        press(panel, "backwards")
        await panel._playing
        assert panel.values.frame == 0
        press(panel, "forwards")
        await asyncio.sleep(0)
        press(panel, "forwards")
        assert not panel.playing
        stopped = panel.values.frame
        await asyncio.sleep(0.01)
        assert panel.values.frame == stopped < 50
        press(panel, "forwards")
        press(panel, "backwards")  # it turns round
        assert panel.playing
        await panel._playing
        assert panel.values.frame == 0
        panel.set(frame=50)
        press(panel, "forwards")  # from the end it begins anew
        await asyncio.sleep(0)
        assert panel.values.frame < 50
        panel.stop()

    asyncio.run(drive())


def test_without_a_kernel_to_play_is_to_see_the_end(panel):
    press(panel, "forwards")
    assert panel.values.frame == 50
    press(panel, "backwards")
    assert panel.values.frame == 0


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
