"""The films that the course ships: small, valid, and what the solutions do."""

import json

import pytest

from nao_course import films
from nao_course.films.recorded import FOLDER, LARGEST
from tests.paths import PROJECT

RECORDED = films.recorded_names()


def test_the_lessons_with_a_drive_and_the_demo_have_a_film():
    assert {name[:2] for name in RECORDED} == {"07", "08", "09", "11", "12", "de"}


@pytest.mark.parametrize("name", RECORDED)
def test_a_film_is_valid_and_at_most_400_kb(name):
    data = films.recorded_film(name)
    assert (FOLDER / f"{name}.json").stat().st_size <= LARGEST
    assert len(data["captions"]) > 5 and all(data["captions"])


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in RECORDED if name != "demo"])
def test_a_film_shows_what_the_solution_does_now(name, monkeypatch):
    monkeypatch.chdir(PROJECT)
    from images.films import record

    now, kept = (json.loads(record(name).to_json()), films.recorded_film(name))
    rounded = {"layers", "matrices", "captions", "alt", "bounds"}
    one, other = ({key: film[key] for key in film if key not in rounded} for film in (now, kept))
    assert one == other
    for one, other in zip(now["layers"], kept["layers"], strict=True):
        assert one["kind"] == other["kind"] and one["colour"] == other["colour"]
        for a, b in zip(one["frames"], other["frames"], strict=True):
            assert (a is None) == (b is None)
            # Another processor may round differently
            assert all(abs(x - y) <= 1 for x, y in zip(a or [], b or [], strict=True))
