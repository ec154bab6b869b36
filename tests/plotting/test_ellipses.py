"""Ellipses: they hold the part of the probability that they say."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.stats import chi2

from nao_course.plotting import ellipse_outlines, plot_ellipse


@pytest.mark.parametrize("probability", [0.5, 0.95])
def test_an_ellipse_holds_the_part_it_says(probability, rng):
    covariance = np.array([[0.3, 0.1], [0.1, 0.08]])
    outline = ellipse_outlines([1.0, 2.0], covariance[None], probability)[0]
    away = outline - (1.0, 2.0)
    distances = np.einsum("ni,ij,nj->n", away, np.linalg.inv(covariance), away)
    assert np.allclose(distances, chi2.ppf(probability, 2))
    from matplotlib.path import Path

    samples = rng.multivariate_normal([1.0, 2.0], covariance, 20_000)
    assert Path(outline).contains_points(samples).mean() == pytest.approx(probability, abs=0.015)


def test_certainty_in_one_direction_is_a_line_and_in_both_a_point():
    line, point = ellipse_outlines([[0, 0], [1, 1]], [np.diag([0.04, 0.0]), np.zeros((2, 2))])
    assert np.allclose(line[:, 1], 0) and np.ptp(line[:, 0]) > 0.5
    assert np.allclose(point, 1)


@pytest.mark.parametrize("wrong", [[[np.nan, 0], [0, 1]], [[-1, 0], [0, 1]], [[1, 0.5], [0, 1]]])
def test_what_is_no_covariance_has_no_ellipse(wrong):
    assert np.isnan(ellipse_outlines([0, 0], [wrong])).all()
    ax = Figure().add_subplot()
    if np.isnan(wrong).any():
        plot_ellipse([0, 0], wrong, ax)
    else:
        with pytest.raises(ValueError, match="symmetric"):
            plot_ellipse([0, 0], wrong, ax)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_what_is_a_covariance_does_not_depend_on_the_unit(unit):
    sound, none = np.array([[1.0, 0.9], [0.9, 1.0]]), np.array([[1.0, 1.1], [1.1, 1.0]])
    outlines = ellipse_outlines(np.zeros((2, 2)), unit**2 * np.array([sound, none]))
    assert np.isfinite(outlines[0]).all() and np.isnan(outlines[1]).all()
    with pytest.raises(ValueError, match="between 0 and 1"):
        ellipse_outlines([0, 0], [sound], probability=95)
    with pytest.raises(ValueError, match=r"\(2, 2\)"):
        plot_ellipse([0, 0], np.eye(3), Figure().add_subplot())
