"""Files of another processor are the same, and whatever an author changes is not."""

import json
import zlib
from base64 import b64encode
from dataclasses import replace
from types import SimpleNamespace

import cv2
import matplotlib.pyplot as plt
import numpy as np
import pytest
import scipy.sparse

from nao_course.exercises import Case, Close
from nao_course.exercises.checking import pack
from nao_course.exercises.earlier import EarlierCall
from nao_course.exercises.exercise import MistakePair, PublicExercise, PublicLesson, PublicMistake
from nao_course.instructor.authoring import rounding_errors
from nao_course.instructor.authoring.perturbation import perturbed
from nao_course.instructor.authoring.rounding_errors import pictures_alike, same_but_for_rounding, texts_alike
from tests.paths import PROJECT

SPARSE = scipy.sparse.csr_array(np.eye(2))
ALIKE = [
    (np.array([1.0, 0.0]), np.array([1.0 + 1e-12, 7e-18])),
    (np.array([1.0, np.nan]), np.array([1.0, np.nan])),
    (np.array([5e-4, 0.0]), np.array([5e-4, 5e-11])),
    ({"a": (1.0, "x")}, {"a": (1.0 + 1e-15, "x")}),
    (SPARSE, scipy.sparse.csr_array((1 + 1e-12) * np.eye(2))),
    (Case((1.0,), "a name"), Case((1.0 + 1e-14,), "a name")),
    (np.random.default_rng(1), np.random.default_rng(1)),
    ({"unstable": 1e16}, {"unstable": {"raises": "LinAlgError"}}),
    ({"unstable": 1.0}, 1.0),
]
DIFFERENT = [
    *((np.array([1.0, 2.0]), np.array([1.0, 2.001])), (np.array([100.0, 1e-5]), np.array([100.0, 1.1e-5]))),
    *((np.array([1e-10, 2e-10]), np.array([1e-10, 3e-10])), (np.zeros(3), np.zeros(4))),
    *((np.zeros(3), np.zeros(3, np.float32)), (np.array([1, 2]), np.array([1, 3]))),
    (np.full((2, 2), 200, np.uint8), np.full((2, 2), 201, np.uint8)),
    ({"a": (1.0, "x")}, {"a": (1.0, "y")}),
    *(({"a": 1}, {"b": 1}), ([1, 2], [1, 2, 3]), (1, 1.0), (1e-6, 1e-7), ({"unstable": 1.0}, 2.0)),
    *((SPARSE, scipy.sparse.csr_array(np.ones((2, 2)))), (Case((1.0,), "a name"), Case((1.0,), "another"))),
    (np.random.default_rng(1), np.random.default_rng(2)),
]


def test_last_digits_of_another_processor_are_no_change_and_all_else_is():
    assert [pair for pair in ALIKE if not rounding_errors.values_alike(*pair)] == []
    assert [pair for pair in DIFFERENT if rounding_errors.values_alike(*pair)] == []
    alike = [("RMSE 0.12345678 m", "RMSE 0.12345679 m"), ("off by 7.1e-17", "off by -2.2e-16")]
    assert [pair for pair in alike if not texts_alike(*pair)] == []
    other = [("0.123 m", "0.124 m"), ("0.12345 m", "0.12346 m"), ("1000001 of", "1000002 of")]
    other += [("1.0 m", "1.0 mm"), ("7,137 of", "7,138 of"), ("1.0", "1"), ("1.0 2.0", "1.0"), ("nan", "0.0")]
    assert [pair for pair in other if texts_alike(*pair)] == []


def lesson(*, calls=(1.0, 2.0), answer=4.0, message="m", **changes):
    case = Case((np.array([0.5, 2.0]),), expected=np.array([0.25, 4.0]))
    law, mistake = Close(rtol=1e-4), PublicMistake(message, {"0": answer})
    exercise = PublicExercise("square", "1.1", 1.0, 1, law, [case], [mistake], ["a", "b"], "")
    earlier = [EarlierCall("00:root", ["x"], {"x": each}, 2 * each) for each in calls]
    return PublicLesson("01_square", [replace(exercise, earlier=earlier, **changes)], [], [])


def same_lesson(**changes):
    return same_but_for_rounding(".bin", pack(lesson()), pack(lesson(**changes)))


def test_check_data_with_other_rounding_errors_is_the_same_and_with_a_changed_declaration_is_not():
    ours, other = pack(lesson()), pack(perturbed(lesson(), np.random.default_rng(3)))
    assert other != ours and same_but_for_rounding(".bin", ours, other)
    for calls in ((1.0, 2.0, 1 + 1e-15), (1.0, 1 - 1e-15, 2.0)):  # recorded twice, for a last digit
        both = [ours, pack(lesson(calls=calls))]
        assert same_but_for_rounding(".bin", *both) and same_but_for_rounding(".bin", *both[::-1])
    changes = [{"comparison": Close(rtol=1e-5)}, {"comparison": Close(rtol=1e-4, atol=1e-7)}]
    changes += [{"points": 2.0}, {"hints": ["a", "c"]}, {"message": "another"}, {"answer": 4.001}]
    changes += [{"answer": {"unstable": 5.0}}, {"answer": {"raises": "ValueError"}}, {"cases": []}]
    changes += [{"calls": calls} for calls in ((1.0,), (1.0, 2.0, 3.0), (2.0, 1.0))]
    assert [each for each in changes if same_lesson(**each)] == []
    for there in [b"", b"no zip", zlib.compress(b"NAO1"), zlib.compress(b"x" * 100)]:
        for suffix in (".bin", ".ipynb", ".png", ".jpeg", ".pdf"):
            assert not same_but_for_rounding(suffix, there, pack(lesson()))
            assert same_but_for_rounding(suffix, there, there)


def notebook(text="0.12345678", source="print(x)", **metadata):
    cell = {"cell_type": "code", "id": "a", "metadata": metadata, "source": source}
    data = {"data": {"text/plain": [text]}, "execution_count": 1}
    cell["outputs"] = [{"output_type": "execute_result", **data}]
    words = {"cell_type": "markdown", "id": "b", "metadata": {}, "source": "about 0.12345678"}
    return {"cells": [cell, words], "metadata": {"version": "1"}, "nbformat": 4}


def same_notebook(other):
    return same_but_for_rounding(".ipynb", json.dumps(notebook()).encode(), json.dumps(other).encode())


def test_of_a_notebook_only_outputs_may_differ():
    def with_output(*outputs):
        made = notebook()
        made["cells"][0]["outputs"] = [made["cells"][0]["outputs"][0] | each for each in outputs]
        return made

    words = notebook()
    words["cells"][1]["source"] = "about 0.12345679"
    assert same_notebook(notebook("0.12345679"))
    others = [notebook("0.1234"), notebook(source="print(x)  # 0.12345679"), notebook(tags=["hide"]), words]
    others += [notebook() | {"metadata": {"version": "2"}}, with_output({"execution_count": 2})]
    others += [with_output({"data": {"text/html": ["0.12345678"]}}), with_output({"output_type": "stream"})]
    assert not [other for other in (*others, with_output({}, {})) if same_notebook(other)]


PIXEL = 1 / 300  # of the height of the axes


def figure(*, up=0.0, right=0.0, title="RMSE 0.123 m", width=1.5, noise=0.0):
    """Draw a curve and a marker as a lesson's figure does: RGB."""
    drawn, axes = plt.subplots(figsize=(8, 4), dpi=100)
    axes.set_position([0.1, 0.1, 0.8, 0.75])
    x = np.linspace(0, 1, 500)
    y = 0.5 + 0.3 * np.sin(9 * x) + up * PIXEL
    axes.plot(x, y * (1 + noise * np.random.default_rng(1).normal(size=x.size)), lw=width)
    axes.plot([0.5 + right / 640], [0.2], "o", ms=5, color="black")
    axes.set(xlim=(0, 1), ylim=(0, 1), title=title)
    drawn.canvas.draw()
    picture = np.asarray(drawn.canvas.buffer_rgba())[..., :3].copy()
    plt.close(drawn)
    return picture


def encoded(picture, suffix=".png"):
    return cv2.imencode(suffix, picture)[1].tobytes()


VISIBLE = [{"up": 1.0}, {"up": 3.0}, {"up": 0.3}, {"right": 1.0}, {"width": 1.7}]
VISIBLE += [{"title": "RMSE 0.128 m"}, {"title": "RMSE 0,123 m"}]


@pytest.mark.parametrize("suffix", [".png", ".jpeg"])
@pytest.mark.parametrize("change", VISIBLE)
def test_a_change_that_somebody_could_see_is_one(change, suffix):
    assert not pictures_alike(encoded(figure(), suffix), encoded(figure(**change), suffix))
    assert not same_but_for_rounding(suffix, encoded(figure(), suffix), encoded(figure(**change), suffix))


def test_a_figure_of_perturbed_numbers_is_the_same():
    picture, other = figure(), figure(noise=1e-6)
    other[100, 100] ^= 90  # a pixel on an edge may be rounded to the other side
    assert not np.array_equal(picture, other)
    assert pictures_alike(encoded(picture), encoded(other))


@pytest.mark.parametrize("suffix", [".png", ".jpeg"])
def test_a_camera_picture_that_is_rendered_with_other_rounding_errors_is_the_same(suffix):
    """A level more or less here and there."""
    picture = cv2.imread(str(min((PROJECT / "solutions" / "images").glob("*_payoff.jpeg"))))
    rng = np.random.default_rng(2)
    flips = (rng.random(picture.shape) < 1e-3) * rng.choice([-1, 1], picture.shape)
    other = np.clip(picture + flips, 0, 255).astype(np.uint8)
    one, two = encoded(picture, suffix), encoded(other, suffix)
    assert one != two and pictures_alike(one, two)
    assert not pictures_alike(one, encoded(picture[1:], suffix))
    assert not pictures_alike(one, encoded(np.roll(picture, 1, axis=0), suffix))


def test_the_pictures_in_a_notebooks_outputs_are_compared_as_pictures():
    def shown(picture, alt="0.5 m"):
        data = b64encode(encoded(picture)).decode()
        return json.dumps(notebook(f'<img alt="{alt}" src="data:image/png;base64,{data}">')).encode()

    picture, nearly = figure(), figure()
    nearly[50:60, 50:60] ^= 1
    ours = shown(picture)
    assert same_but_for_rounding(".ipynb", ours, shown(nearly))
    assert not same_but_for_rounding(".ipynb", ours, shown(nearly, alt="0.6 m"))
    assert not same_but_for_rounding(".ipynb", ours, shown(figure(up=1.0)))


def test_a_pair_of_mistakes_may_be_absent_only_if_rounding_decides_about_one_of_them():
    def exercise(*pairs):
        answers = ({"0": 1.0}, {"0": {"unstable": 2.0}}, {"0": 3.0})
        return SimpleNamespace(
            pairs=[MistakePair(each, [0], {"0": 1.0}) for each in pairs],
            mistakes=[SimpleNamespace(answers=each) for each in answers],
        )

    assert rounding_errors._pairs_alike(exercise((0, 1), (0, 2)), exercise((0, 2)))
    assert rounding_errors._pairs_alike(exercise((0, 2)), exercise((0, 2), (1, 2)))
    assert not rounding_errors._pairs_alike(exercise((0, 2)), exercise())
    assert not rounding_errors._pairs_alike(exercise(), exercise((0, 2)))
