"""Lesson 04's figures say in words what the lesson's text says of them."""

import re

import numpy as np
import pytest

from nao_course.lessons import distance
from nao_course.lessons.distance.payoff import polar_outlines
from tests.lessons.distance.own import GEOMETRY, OWN, polar
from tests.lessons.every import solved, text


def test_figures_state_the_papers_errors_and_none_of_the_exact_way():
    words = distance.draw_paper_error(OWN["paper_distance"], OWN["paper_bearing"], **GEOMETRY).alt
    assert "+2 cm at 1 m ahead, -1 cm at 2 m ahead, -23 cm at 4 m ahead" in words
    assert "+4 degrees in the lower right corner" in words

    def paper(pixels, view):
        return np.column_stack([OWN["paper_bearing"](pixels, view), OWN["paper_distance"](pixels, view)])

    words = distance.draw_arrows({"exact": polar, "paper": paper}, distance.usual_view()).alt
    assert "exact: 0.00 m in the median, 0.00 m at most" in words
    assert "paper: 0.08 m in the median, 0.33 m at most" in words


def test_errors_by_tilt_their_sampled_shape_and_what_a_pixel_is_worth_are_those_of_the_text():
    words = distance.draw_tilt_band(**GEOMETRY).alt
    found = [float(each) for each in re.findall(r"(\d\.\d\d) m at", words)]
    assert found == pytest.approx([0.04, 0.15, 0.33, 0.58, 0.89], abs=0.011)
    sigma = OWN["range_sigma"]
    words = distance.draw_asymmetry(**GEOMETRY, range_sigma=sigma, tilt_sigma=np.radians(1)).alt
    assert "at 4 m computed 0.592 m" in words and "mean +0.103 m" in words and "-0.89 to +1.54" in words
    sampled = re.search(r"sampled ([\d.]+) m, 95 % from -([\d.]+) to \+([\d.]+) m, mean \+0.103", words)
    deviation, short, long = map(float, sampled.groups())
    assert f"a standard deviation of {deviation:.2f} m instead of 0.59 m" in text("04")
    assert f"between {short:.1f} m too short and {long:.1f} m too long" in text("04")
    words = distance.draw_pixel_worth(**GEOMETRY, range_sigma=sigma).alt
    assert "320 x 240 6.9 cm" in words and "1280 x 960 1.7 cm" in words
    assert "one degree of tilt 34 cm" in words
    covariance = OWN["measurement_covariance"]
    words = distance.draw_shared_tilt(
        **GEOMETRY, measurement_covariance=covariance, pixel_sigma=0.7, tilt_sigma=np.radians(1), pictures=5
    ).alt
    assert "0.98, 0.98, 0.98" in words


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda pixels, view: None, "a return may be missing"),
        (lambda pixels, view: np.zeros((1, 2)), "a row of two for each of"),
        (lambda pixels, view: np.full((len(pixels), 2), np.nan), "gave NaN for each of"),
    ],
)
def test_an_answer_of_another_kind_is_said_with_the_functions_name(answer, said):
    changed = GEOMETRY | {"pixel_to_ground": answer}
    with pytest.raises(ValueError, match=rf"pixel_to_ground .*{said}"):
        distance.draw_tilt_band(**changed)
    with pytest.raises(ValueError, match=rf"pixel_to_ground .*{said}"):
        distance.draw_tilted_lines(answer)
    with pytest.raises(ValueError, match=rf"the arrows .*{said}"):
        distance.draw_arrows({"the arrows": answer}, distance.usual_view())


def test_one_angle_for_each_picture_brings_the_points_of_the_payoff_to_their_landmarks():
    functions = {name: OWN[name] for name in ("measurement_covariance", "estimate_pitch")}
    words = distance.draw_payoff(**GEOMETRY, **functions).alt
    before, after = (float(each) for each in re.findall(r"(\d\.\d\d) m (?:from|off).*? in the median", words))
    assert after < 0.6 * before and before < 0.15
    farthest, corrected = (float(each) for each in re.findall(r"(\d\.\d\d) m at most", words))
    assert corrected < 0.2 * farthest
    (tilt,) = re.findall(r"one angle \((\d\.\d), ", words)
    assert f"the first picture's tilt is {tilt} degrees" in text("04")


def test_an_ellipse_from_the_covariance_holds_its_share_and_outlines_are_round_the_point():
    cells = [cell.source for cell in solved("04_distance").cells if "def landmark_ellipse" in cell.source]
    names = {"np": np}
    exec(cells[0].split("\n\n\nown =")[0], names)
    words = distance.draw_landmark_clouds(
        **GEOMETRY,
        measurement_covariance=OWN["measurement_covariance"],
        landmark_ellipse=names["landmark_ellipse"],
        pixel_sigma=0.7,
        tilt_sigma=np.radians(1.0),
    ).alt
    shares = [int(each) for each in re.findall(r"(\d+)%", words)]
    assert len(shares) == 3 and all(92 <= each <= 98 for each in shares)
    (outline,) = polar_outlines(np.array([[np.pi / 2, 2.0]]), np.diag([1e-4, 1e-2]))
    assert outline.mean(axis=0) == pytest.approx([0, 2], abs=0.05)
    spread = outline.max(axis=0) - outline.min(axis=0)
    assert spread == pytest.approx([2 * 2.448 * 0.01 * 2, 2 * 2.448 * 0.1], rel=0.05)
