"""Films hold what was recorded within half a millimetre, and a broken file is refused with its place."""

import json
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nao_course import films
from nao_course.films.film import LEVELS, frames_of
from nao_course.films.layers import INDICES, KINDS, WIDTHS
from nao_course.films.scene import UNIT
from nao_course.plotting.ellipses import ellipse_outlines
from nao_course.sim import Field

POSES = [(0.1 * number, 0.0, 0.01 * number) for number in range(4)]
CAPTIONS = ["one", "two", "three", "four"]


def small(*layers, **more):
    return films.Film("Small", layers or [films.path_layer("truth", POSES)], CAPTIONS, **more)


@pytest.mark.parametrize("kind", KINDS)
@settings(deadline=None, max_examples=25)
@given(data=st.data())
def test_a_frame_is_kept_within_half_a_millimetre_and_half_a_milliradian(kind, data):
    shape = (data.draw(st.integers(0, 5)), WIDTHS[kind])
    frames = [data.draw(arrays(float, shape, elements=st.floats(-50, 50))) for _ in CAPTIONS]
    for frame in frames:
        for column in INDICES.get(kind, ()):
            frame[:, column] = np.abs(frame[:, column]).astype(int) % 3
    film = small(films.Layer(kind, frames, "#0b5fa5"))
    read = frames_of(json.loads(film.to_json()), 0)
    assert all(np.abs(a - b).max(initial=0) <= UNIT / 2 + 1e-9 for a, b in zip(frames, read, strict=True))
    for column in INDICES.get(kind, ()):
        assert all(np.array_equal(a[:, column], b[:, column]) for a, b in zip(frames, read, strict=True))


def test_an_ellipse_passes_through_its_outline_and_a_matrix_is_kept_within_half_a_level():
    covariance = np.array([[0.04, 0.012], [0.012, 0.01]])
    layer = films.ellipse_layer("#0b5fa5", [([(1.0, 2.0)], [covariance])])
    x, y, a, b, d = layer.frames[0][0]
    angles = np.linspace(0, 2 * np.pi, 49)
    drawn = np.array([x, y]) + np.column_stack([np.cos(angles), np.sin(angles)]) @ np.array([[a, b], [b, d]])
    assert drawn == pytest.approx(ellipse_outlines([(1.0, 2.0)], [covariance])[0])
    layer = films.ellipse_layer("#0b5fa5", [([(0, 0), (1, 1)], [np.eye(2), -np.eye(2)])])
    assert len(layer.frames[0]) == 1
    grown = [np.array([[1.0]]), *[np.array([[1.0, -0.304], [-0.304, 1.0]])] * 3]
    film = small(matrices=[films.Matrix("Correlations", grown, [1, 1], ["a", "b"])])
    [matrix] = film.data()["matrices"]
    assert matrix["frames"] == [[200, 0, 0], [200, -61, 200], None, None] and LEVELS == 200


def test_a_frame_that_repeats_the_one_before_is_stored_once_but_for_a_standing_path():
    frames = [[(0, 0)], [(0, 0)], [(1, 1)], [(1, 1)]]
    [layer] = small(films.point_layer("#000000", frames)).data()["layers"]
    assert layer["frames"] == [[0, 0], None, [1000, 1000], None]
    assert [each.tolist() for each in frames_of(small(films.point_layer("#000000", frames)).data(), 0)] == [
        [[0, 0]], [[0, 0]], [[1, 1]], [[1, 1]]
    ]  # fmt: skip
    [layer] = small(films.path_layer("truth", [POSES[0]] * 4)).data()["layers"]
    assert layer["frames"] == [[0, 0, 0]] * 4


def test_the_field_is_drawn_where_it_lies_and_a_saved_film_is_read_as_it_was_made(tmp_path):
    data = small(field=Field(2012)).data()
    assert data["bounds"] == [-700, -2700, 3700, 2700]
    assert [3000, -700, 70] in data["field"]["posts"]
    [layer] = small().data()["layers"]
    assert (layer["colour"], layer["dark"]) == ("#1a1a1a", "#f4f4f4")
    film = small(field=Field(2012))
    assert films.read_film(film.save(tmp_path / "film.json")) == film.data()
    assert film.save(tmp_path / "again.json").read_bytes() == (tmp_path / "film.json").read_bytes()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: films.Film("A", [], []), "at least one caption"),
        (lambda: films.Film("A", [], ["x"], pace=5), "pace must be one of"),
        (lambda: small(films.path_layer("truth", POSES[:3])), "truth has 3 frames; expected 4"),
        (lambda: films.Layer("blob", [], "#000000"), "kind must be one of path, "),
        (lambda: films.Layer("points", [[(1, 2, 3)]], "#000000"), r"shape \(N, 2\)"),
        (lambda: films.Layer("points", [[(np.nan, 2)]], "#000000"), "finite"),
        (lambda: films.recorded_film("13_nothing"), "there is no film '13_nothing'; there are"),
    ],
)
def test_what_is_no_film_is_refused_when_it_is_made(wrong, message):
    with pytest.raises(ValueError, match=message):
        wrong()


def broken(change):
    data = small(matrices=[films.Matrix("M", [np.eye(2)] * 4, [2], ["a"])]).data()
    change(data)
    return data


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data.update(format="film 0"), "format must be 'nao-course film 1'"),
        (lambda data: data.pop("captions"), "captions must be a list"),
        (lambda data: data.update(captions=[]), "captions must be texts, at least one"),
        (lambda data: data.update(bounds=[0, 0, 0, 1]), "bounds must be four whole numbers"),
        (lambda data: data["layers"].append({"kind": "blob"}), "layer 1 has the unknown kind 'blob'"),
        (lambda data: data["layers"][0]["frames"].pop(), r"layer 0 \(path\): it must have 1 or 4 frames"),
        (lambda data: data["layers"][0]["frames"][2].pop(), "frame 2 has 2 numbers, .* 3 for each entry"),
        (lambda data: data["layers"][0]["frames"].__setitem__(1, [0.5]), "frame 1 must be a list of whole"),
        (lambda data: data["matrices"][0].pop("size"), "matrix 0 has no size"),
        (lambda data: data["matrices"][0]["frames"][0].append(1), "matrix 0: frame 0 has 4 numbers"),
    ],
)
def test_a_broken_file_is_refused_with_its_name_and_the_place(change, message, tmp_path):
    path = tmp_path / "my film.json"
    path.write_text(json.dumps(broken(change)), encoding="utf-8")
    with pytest.raises(ValueError, match=f"my film.json is not a film: .*{message}.* Record it again"):
        films.read_film(path)


@pytest.mark.parametrize("text", ["{", "[" * 100_000])
def test_a_file_that_is_no_json_is_refused(text, tmp_path):
    path = tmp_path / "film.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match="film.json is not a film: it is not valid JSON"):
        films.read_film(path)


@pytest.mark.parametrize("caption", ["</script><b>bold", "<!--<script>"])
def test_a_caption_can_neither_end_the_script_of_its_page_nor_keep_it_open(caption):
    data = films.Film("A", [], [caption]).data()
    (text,) = re.findall(r'<script type="application/json">(.*?)</script>', films.film_page(data), re.DOTALL)
    assert "<" not in text and json.loads(text) == data
