"""Maps: everything lies where its values say, and what is broken is said."""

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

from nao_course.geometry import Pose
from nao_course.plotting import STYLES, draw_map, plot_estimate, plot_field, plot_landmarks, plot_path
from nao_course.plotting.style import CARPET, contrast
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement
from tests.plotting.examples import a_map, some_estimate


def test_a_map_names_its_units_and_a_moved_field_lies_where_it_lies_and_verbs_draw_on_their_axis():
    assert [ax.get_xlabel() for ax in a_map().figure.axes] == ["x (m)"]
    ax = Figure().add_subplot()
    plot_field(Field(pose=Pose(10.0, 5.0, np.pi / 2)), ax)
    assert np.allclose(ax.get_xlim(), (10 - 2.7, 10 + 2.7))
    assert np.allclose(ax.get_ylim(), (5 - 0.7, 5 + 3.7))
    ax = Figure().add_subplot()
    plot_path([Pose(), Pose(1, 0, 0)], ax, "odometry")
    plot_estimate(some_estimate(), ax, "graph")
    assert {line.get_color() for line in ax.lines} == {STYLES["odometry"].colour, STYLES["graph"].colour}


def inverted(colour):
    """A colour after custom.css's invert(0.93) hue-rotate(180deg)."""
    turn = np.array([[-0.574, 1.43, 0.144], [0.426, 0.43, 0.144], [0.426, 1.43, -0.856]])
    return to_hex(np.clip(turn @ (0.93 - 0.86 * np.array(to_rgb(colour))), 0, 1))


def test_the_lines_of_a_field_are_readable_on_both_pages_and_what_is_empty_or_broken_is_a_map_all_the_same():
    ax = Figure().add_subplot()
    plot_field(Field(), ax)
    rims = {to_hex(each.get_edgecolor()) for each in ax.patches if each.get_linewidth() == 1.2}
    assert len(rims) == 1
    for shown in (str, inverted):
        assert contrast(shown(*rims), shown(CARPET)) > 3
    empty = Estimate(Pose(), np.zeros((3, 3)), np.empty((0, 2)), np.empty((0, 2, 2)))
    drawing = draw_map(Field(), truth=[], odometry=np.empty((0, 3)), estimate=empty)
    assert "truth: no poses" in drawing.alt
    assert "landmarks: none" in drawing.alt
    none = np.empty((0, 2)), np.empty((0, 2, 2))
    estimate = Estimate(Pose(), np.diag([0.01, 0.04, 0.0]), *none)
    assert "(standard deviations 0.10 and 0.20 m)" in draw_map(Field(), estimate=estimate).alt
    broken = some_estimate()
    broken.landmark_covariances[0] = np.nan
    drawing = draw_map(Field(), estimate=broken)
    assert "Without an ellipse, because the covariance is invalid: 1" in drawing.alt


@pytest.mark.parametrize("turn", [0.0, 0.7, np.pi / 2, -2.0])
def test_turning_the_frame_turns_the_ellipses_that_are_drawn(turn):
    estimate, frame = some_estimate(), Pose(0.5, -1.0, turn)
    ax = Figure().add_subplot()
    plot_estimate(estimate, ax, probability=0.95, frame=frame)
    (shapes,) = ax.collections
    centres = np.vstack([(estimate.pose.x, estimate.pose.y), estimate.landmarks])
    covariances = [estimate.covariance[:2, :2], *estimate.landmark_covariances]
    assert len(shapes.get_paths()) == 3
    for path, centre, covariance in zip(shapes.get_paths(), centres, covariances, strict=True):
        away = frame.to_local(path.vertices) - centre  # back in the estimate's own frame
        distances = np.einsum("ni,ij,nj->n", away, np.linalg.inv(covariance), away)
        assert np.allclose(distances, -2 * np.log(0.05))


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: draw_map(Field(), truth=[[1.0, 2.0, 3.0, 4.0]]), "shape"),
        (lambda: draw_map(Field(), measurements=[Measurement(0.1, 1.0)]), "need a pose"),
        (lambda: draw_map(Field(), estimate=some_estimate(), source="lidar"), "source must be one of"),
        (lambda: draw_map(Field(), estimate="none"), "must be an Estimate"),
        (lambda: plot_landmarks([[0, 0]], [], Figure().add_subplot()), "need 1 kinds"),
        (lambda: plot_landmarks([[0, 0]], ["tree"], Figure().add_subplot()), "tree"),
    ],
)
def test_a_wrong_value_is_refused_in_words(call, said):
    with pytest.raises(ValueError, match=said):
        call()
