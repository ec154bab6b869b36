"""Both editions as Sphinx makes them: nothing is broken, and the students' hold nothing of a solution."""

import json
from importlib.util import find_spec

import pytest

from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.leaks import find_leaks
from nao_course.instructor.authoring.release import model_answers, secrets
from tests.browser.lab import browser_page
from tests.paths import PROJECT
from website.__main__ import build
from website.checks import offences, read_page
from website.editions import EDITIONS, TELLING

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("sphinx") is None, reason="no Sphinx here: `make site` installs it"),
]
LAPTOP, PHONE = {"width": 1366, "height": 768}, {"width": 390, "height": 844}


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Edition -> the folder of its pages."""
    return {name: build(name, tmp_path_factory.mktemp(name) / "site") for name in EDITIONS}


@pytest.fixture(scope="module")
def course():
    return load_course(PROJECT)


def code_of(folder):
    """What stands as code on the pages, as files that a search for leaks reads."""
    return {
        f"{path.relative_to(folder)} {number}.py": source.encode()
        for path in folder.rglob("*.html")
        for number, source in enumerate(read_page(path).code)
    }


def words_of(folder):
    return "\n".join("".join(read_page(path).words) for path in folder.rglob("*.html"))


def answers_in_words(course):
    """Rubrics, and the answers that an instructor would write, both without what Markdown adds."""
    written = [json.loads(f'"{line}"') for line in model_answers(course)]
    rubrics = [each.rubric for name in course.names() for each in course.plan(name).written]
    return [text for text in (*written, *rubrics) if not {"`", "*", "$"} & {*text}]


@pytest.mark.parametrize("edition", EDITIONS)
def test_no_link_is_broken_every_picture_is_described_and_no_host_is_asked(site, edition, course):
    pages = site[edition]
    assert len(list((pages / "lessons").glob("*.html"))) == len(course.names(course.chosen))
    assert offences(pages) == []


def test_the_pages_are_as_large_as_the_documents_say(site):
    sizes = [
        round(sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6)
        for folder in (site["student"], site["instructor"])
    ]
    row = "| `make site` itself; with solutions | nothing | {} MB; {} MB |".format(*sizes)
    assert row in (PROJECT / "docs" / "setup.md").read_text(encoding="utf-8")


def test_a_propertys_sentence_with_a_colon_stays_a_sentence(site):
    words = "".join(read_page(site["student"] / "reference" / "sim.html").words)
    assert "Circular lines: (N, 5) as x, y and radius" in " ".join(words.split())


def test_the_students_pages_hold_no_solution_no_hidden_case_and_no_answer_in_words(site, course):
    hidden = secrets(course)
    assert find_leaks(code_of(site["student"]), hidden) == []
    assert len(find_leaks(code_of(site["instructor"]), hidden)) > 50
    answers, student, instructor = answers_in_words(course), *map(words_of, site.values())
    assert [each for each in answers if each in student] == []
    assert sum(each in instructor for each in answers) > 5


def test_the_students_pages_show_the_figures_of_the_instructors_and_nothing_else_of_their_outputs(site):
    for path in sorted((site["student"] / "lessons").glob("*.html")):
        student, instructor = (
            read_page(edition / "lessons" / path.name) for edition in (site["student"], site["instructor"])
        )
        assert len(student.pictures) > 3 and student.pictures <= instructor.pictures, path.name


FRAME = "Number(document.querySelector('.nao-film').dataset.frame)"
# From the top of the map to the end of what is seen with it: the bar that plays the film, and a matrix.
HEIGHT = """film => {
    const parts = [...film.querySelectorAll(":is(.nao-map-canvas, .nao-film-controls, figure > canvas)")];
    const seen = parts.map(part => part.getBoundingClientRect()).filter(box => box.height);
    return Math.max(...seen.map(box => box.bottom)) - Math.min(...seen.map(box => box.top));
}"""


@pytest.mark.browser
@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
def test_the_students_films_play_and_fit_the_screen(site, chromium, size):
    complaints, films = [], 0
    with browser_page(chromium) as page:
        page.set_viewport_size(size)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        for path in sorted(site["student"].rglob("*.html")):
            if "nao-film-here" not in path.read_text(encoding="utf-8"):
                continue
            page.goto(path.as_uri())
            for film in page.locator(".nao-film").all():
                films += 1
                if path.name == "index.html":
                    page.wait_for_function(f"() => {FRAME} > {TELLING['start']}", timeout=240_000)
                    film.press("Home")
                    film.locator("select").select_option("3")
                play = film.locator(".nao-film-play")
                if "Play" in play.inner_text():  # the first page's may still play, or have ended
                    play.click()
                shows = "film => Number(film.dataset.frame) >= 1"
                page.wait_for_function(shows, arg=film.element_handle(), timeout=240_000)
                film.press(" ")
                assert film.evaluate("each => each.scrollWidth <= each.clientWidth"), path.name
                assert size == LAPTOP or film.evaluate(HEIGHT) <= PHONE["height"], path.name
    assert films == 7 and complaints == []


@pytest.mark.browser
def test_what_the_search_shows_of_a_page_begins_and_ends_with_a_word_and_has_no_code(site, chromium):
    words = " ".join(f"word{number}" for number in range(200))
    html = f'<article role="main"><div class="cell_input">import hidden</div><p>{words}</p></article>'
    with browser_page(chromium) as page:
        page.goto((site["student"] / "search.html").as_uri())
        piece = page.evaluate(
            "html => Search.makeSearchSummary(html, new Set(['word77']), null).textContent", html
        )
    first, *middle, last = piece.split()
    assert (first, last) == ("…", "…")
    assert "word77" in middle and set(middle) <= {*words.split()}


# What is wider than the screen and cannot be scrolled: the theme cuts it off without a word.
CUT_OFF = """() => [...document.querySelectorAll("article :is(mjx-container, pre, table, img)")]
    .filter((each) => each.getBoundingClientRect().right > innerWidth)
    .filter((each) => {
        for (let box = each; box.tagName !== "ARTICLE"; box = box.parentElement)
            if (["auto", "scroll"].includes(getComputedStyle(box).overflowX)) return false;
        return true;
    })
    .map((each) => each.tagName + " " + each.textContent.slice(0, 60))"""


@pytest.mark.browser
@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
def test_pages_show_formulas_fit_the_screen_and_fetch_only_what_lies_beside_them(site, chromium, size):
    folder, asked, complaints = site["instructor"], [], []
    with browser_page(chromium) as page:
        page.set_viewport_size(size)
        page.set_default_timeout(180_000)
        page.on("request", lambda request: asked.append(request.url))
        page.on("requestfailed", lambda request: complaints.append(request.url))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        for path in sorted(folder.glob("*/*.html")):
            page.goto(path.as_uri())
            if path.parent.name == "lessons":
                page.wait_for_function("() => window.MathJax?.startup?.promise")
                page.evaluate("() => MathJax.startup.promise.then(() => null)")
            wrong = page.locator("mjx-merror").all_inner_texts()
            wide = page.evaluate("() => document.documentElement.scrollWidth - window.innerWidth")
            assert (path.name, wrong, max(wide, 0), page.evaluate(CUT_OFF)) == (path.name, [], 0, [])
    assert complaints == []
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
