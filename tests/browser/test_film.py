"""Films in a real browser: lesson 07's panel in a notebook, and the page that needs nothing else."""

import pytest

from nao_course import films
from tests.browser.lab import wait_for
from tests.browser.notebook_page import panel_of, screenshot
from tests.paths import PROJECT

pytestmark = pytest.mark.browser

STUDENT = f"""from nao_course.instructor.authoring.plans import load_solution
from nao_course.lessons.ekf_slam import FilmPanel
from pathlib import Path

own = load_solution(Path({str(PROJECT / "solutions" / "07_ekf_slam.ipynb")!r}))"""
FILM = "FilmPanel(*(own[name] for name in ('init_landmarks', 'predict', 'update')))"


@pytest.fixture
def in_notebook(lab, page):
    return panel_of(lab, page, "film.ipynb", STUDENT, FILM, kind=".nao-film")


@pytest.fixture
def on_a_page(tmp_path, context):
    poses = [(0.1 * number, 0.05 * number, 0.1) for number in range(21)]
    layers = [films.path_layer("ekf", poses)]
    film = films.Film("A drive", layers, [f"Frame {number}." for number in range(21)])
    path = tmp_path / "film.html"
    path.write_text(films.film_page(film.data()), encoding="utf-8")
    errors = []
    page = context.new_page()
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(path.as_uri())
    yield page.locator(".nao-film")
    page.close()
    assert errors == []


def frame(player):
    return int(player.get_attribute("data-frame"))


def painted(player):
    """The map's pixels, as one text."""
    return player.locator(".nao-map-canvas").evaluate("canvas => canvas.toDataURL()")


def plays_steps_and_scrubs(player, last):
    play, words = player.locator(".nao-film-play"), player.locator("[role=status]")
    first = painted(player)
    player.press("ArrowRight")
    player.press("ArrowRight")
    assert frame(player) == 2 and painted(player) != first
    player.press("ArrowLeft")
    player.press("Home")
    assert frame(player) == 0 and painted(player) == first
    said = words.inner_text()
    player.locator("select").select_option("20")
    play.click()
    assert "Pause" in play.inner_text()
    assert wait_for(lambda: frame(player) == last and "Play" in play.inner_text())
    assert words.inner_text() != said
    player.press("b")
    assert wait_for(lambda: frame(player) < last)
    player.press("b")
    stopped = frame(player)
    player.page.wait_for_timeout(400)
    assert frame(player) == stopped
    slider = player.locator("input[type=range]")
    box = slider.bounding_box()
    player.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert abs(frame(player) - last / 2) <= 2
    assert slider.get_attribute("aria-valuetext") == words.inner_text()
    player.locator("select").select_option(index=0)
    player.press("Home")
    for number in range(player.locator("button").count()):
        player.locator("button").nth(number).click()
        before = play.inner_text()
        player.page.keyboard.press("Space")
        assert play.inner_text() != before, "space plays or pauses, whichever button was clicked"
        player.page.keyboard.press("Home")


def test_a_film_plays_in_the_notebook_and_keeps_its_keys(in_notebook):
    cells = in_notebook.page.locator(".jp-Cell").count()
    plays_steps_and_scrubs(in_notebook, 50)
    screenshot(in_notebook.page, "film", in_notebook)
    assert in_notebook.page.locator(".jp-Cell").count() == cells  # "b" adds one outside of the film


def test_a_film_follows_the_theme(in_notebook):
    light = painted(in_notebook)
    in_notebook.page.evaluate(
        "() => window.jupyterapp.commands.execute('apputils:change-theme', {theme: 'JupyterLab Dark'})"
    )
    assert wait_for(lambda: painted(in_notebook) != light)
    screenshot(in_notebook.page, "film_dark", in_notebook)


def test_a_film_takes_a_theme_whose_style_sheet_came_late_when_its_tab_is_seen_again(on_a_page):
    light = painted(on_a_page)
    on_a_page.page.evaluate("document.body.style.color = 'white'")
    on_a_page.page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    assert wait_for(lambda: painted(on_a_page) != light, seconds=20)


def test_a_film_plays_on_a_page_of_its_own(on_a_page):
    plays_steps_and_scrubs(on_a_page, 20)
    screenshot(on_a_page.page, "film_page", on_a_page)


@pytest.mark.parametrize("width", [390, 1280])
def test_nothing_of_a_film_is_wider_than_its_page(on_a_page, width):
    on_a_page.page.set_viewport_size({"width": width, "height": 800})
    on_a_page.page.wait_for_timeout(200)
    assert on_a_page.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    screenshot(on_a_page.page, f"film_page_{width}", on_a_page)
