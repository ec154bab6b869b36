"""Figures: true to their values, the same at every run, readable without colours and without eyes."""

import html
import re

import cv2
import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from scipy.stats import chi2

from nao_course import plotting
from nao_course.geometry import Pose, rotation_2d
from nao_course.plotting import (
    STYLES,
    Drawing,
    as_path,
    draw_cameras,
    draw_drift,
    draw_frames,
    draw_labels,
    draw_map,
    draw_picture,
    draw_pictures,
    ellipse_outlines,
    place_estimate,
    plot_ellipse,
    plot_estimate,
    plot_field,
    plot_landmarks,
    plot_path,
    plot_pose,
)
from nao_course.sim import Field, Reality, SimulatedNao, Truth, repeat_drive
from nao_course.slam import Estimate, Measurement, Motion

# Machado, Oliveira and Fernandes 2009: what readers without one kind of cone see, linear RGB.
CONES = {
    "all": np.eye(3),
    "no red": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "no green": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.01182, 0.04294, 0.968881],
    ],
    "no blue": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.3039],
    ],
}


def some_estimate(covariance=0.02):
    turn = rotation_2d(0.4)
    ellipse = turn @ np.diag([4 * covariance, covariance]) @ turn.T
    return Estimate(
        Pose(1.0, 0.4, 0.3),
        np.diag([covariance, covariance / 3, 0.01]),
        np.array([[3.0, 0.7], [2.4, 1.1]]),
        np.array([ellipse, ellipse]),
        ("post", "corner"),
    )


def every_drawing():
    nao = SimulatedNao(rng=2, reality=Reality.clean())
    truth = Truth(nao)
    nao.walk(0.4)
    picture = nao.take_picture()
    commands = [Motion(0.5, 0.3), Motion(0.5, 0.3)]
    paths = repeat_drive(commands, 5, np.random.default_rng(1))
    return {
        "map": draw_map(nao.field, truth.path, nao.odometry, some_estimate(), nao.sense(), 'A "map" & more'),
        "picture": draw_picture(picture, truth.picture.landmarks),
        "pictures": draw_pictures([picture, picture.pixels[:, :, 0]], ["colour", "red"]),
        "labels": draw_labels(truth.picture.labels),
        "drift": draw_drift(paths, Field(), commanded=paths[0]),
        "cameras": draw_cameras(nao),
        "frames": draw_frames(),
    }


@pytest.fixture(scope="module")
def drawings():
    return every_drawing()


def test_every_source_has_its_own_colour_marker_and_line():
    for name in ("colour", "marker", "line"):
        assert len({str(getattr(style, name)) for style in STYLES.values()}) == len(STYLES)


@pytest.mark.parametrize("eyes", CONES)
def test_the_colours_stay_apart_for_every_kind_of_vision(eyes):
    def seen(colour):
        linear = np.array(CONES[eyes]) @ (np.array(to_rgb(colour)) ** 2.2)
        rgb = np.clip(linear, 0, 1) ** (1 / 2.2)
        return cv2.cvtColor(rgb.astype(np.float32)[None, None], cv2.COLOR_RGB2LAB)[0, 0]

    colours = [seen(style.colour) for style in STYLES.values()]
    apart = [np.linalg.norm(a - b) for i, a in enumerate(colours) for b in colours[:i]]
    assert min(apart) > 25  # CIELAB; 2.3 is a just noticeable difference


def test_the_same_drawing_is_the_same_bytes():
    for name, drawing in every_drawing().items():
        again = every_drawing()[name] if name in ("map", "frames") else drawing
        assert drawing.image() == again.image(), name
        assert drawing.image("svg") == again.image("svg"), name


def test_a_readers_own_settings_change_nothing(drawings):
    expected = drawings["map"].image()
    with matplotlib.rc_context(
        {"font.size": 30, "axes.facecolor": "red", "savefig.dpi": 30, "lines.linewidth": 9}
    ):
        assert every_drawing()["map"].image() == expected


def test_nothing_stays_behind_in_pyplot(drawings):
    import matplotlib.pyplot as plt

    assert drawings
    assert plt.get_fignums() == []


def test_a_notebook_gets_a_picture_with_its_words(drawings):
    for drawing in drawings.values():
        shown = drawing._repr_html_()
        alt = re.search(r'alt="([^"]*)"', shown).group(1)
        assert html.unescape(alt) == drawing.alt
        assert len(drawing.alt) > 60
        assert 'src="data:image/' in shown
        assert len(shown) < 250_000
    assert "&quot;map&quot; &amp; more" in drawings["map"]._repr_html_()


def test_axes_of_maps_and_pictures_name_their_units(drawings):
    labels = {name: [ax.get_xlabel() for ax in each.figure.axes] for name, each in drawings.items()}
    assert labels["map"] == ["x (m)"]
    assert labels["picture"] == ["u (px)"]
    assert labels["drift"] == ["x (m)"]


@pytest.mark.parametrize("suffix", ["png", "jpeg", "jpg", "svg"])
def test_a_drawing_can_be_saved(tmp_path, suffix):
    path = draw_map(Field()).save(tmp_path / f"map.{suffix}")
    assert path.stat().st_size > 1000


def test_another_kind_of_file_is_refused(tmp_path):
    with pytest.raises(ValueError, match="png, svg, jpeg"):
        draw_map(Field()).save(tmp_path / "map.bmp")


# --- values ---


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


@pytest.mark.parametrize(
    "wrong", [[[np.nan, 0], [0, 1]], [[-1, 0], [0, 1]], [[1, 2], [2, 1]], [[1, 0.5], [0, 1]]]
)
def test_what_is_no_covariance_has_no_ellipse(wrong):
    assert np.isnan(ellipse_outlines([0, 0], [wrong])).all()
    ax = Figure().add_subplot()
    if np.isnan(wrong).any():
        plot_ellipse([0, 0], wrong, ax)
    else:
        with pytest.raises(ValueError, match="symmetric"):
            plot_ellipse([0, 0], wrong, ax)


def test_an_estimate_moves_with_its_frame():
    estimate, frame = some_estimate(), Pose(0.5, -1.0, np.pi / 2)
    placed = place_estimate(estimate, frame)
    assert np.allclose(frame.to_local(placed.landmarks), estimate.landmarks)
    assert np.allclose(placed.covariance.diagonal()[:2], estimate.covariance.diagonal()[1::-1])
    back = place_estimate(placed, frame.inverse())
    assert np.allclose(back.landmark_covariances, estimate.landmark_covariances)


def test_a_moved_field_is_drawn_where_it_lies():
    ax = Figure().add_subplot()
    plot_field(Field(pose=Pose(10.0, 5.0, np.pi / 2)), ax)
    assert np.allclose(ax.get_xlim(), (10 - 2.7, 10 + 2.7))
    assert np.allclose(ax.get_ylim(), (5 - 0.7, 5 + 3.7))


@pytest.mark.parametrize(
    "poses", [Pose(1, 2, 0.3), [Pose(1, 2, 0.3)], [[1, 2, 0.3]], np.array([[1, 2, 0.3]])]
)
def test_a_path_comes_in_any_shape(poses):
    assert np.allclose(as_path(poses), [[1, 2, 0.3]])


def test_a_path_without_headings_draws_no_robot():
    assert np.isnan(as_path([[1, 2], [3, 4]])[:, 2]).all()
    assert "heading" not in draw_map(Field(), truth=[[1, 2], [3, 4]]).alt


# --- what a student may hand in ---


def test_nothing_to_show_is_a_map_all_the_same():
    empty = Estimate(Pose(), np.zeros((3, 3)), np.empty((0, 2)), np.empty((0, 2, 2)))
    drawing = draw_map(Field(), truth=[], odometry=np.empty((0, 3)), estimate=empty)
    assert "truth: no poses" in drawing.alt
    assert "landmarks: none" in drawing.alt


def test_an_estimate_with_a_broken_covariance_is_drawn_and_says_so():
    broken = some_estimate()
    broken.landmark_covariances[0] = np.nan
    drawing = draw_map(Field(), estimate=broken)
    assert "No ellipse for 1" in drawing.alt


def test_one_robot_and_no_command_are_enough_for_a_drift():
    assert "1 robot" in draw_drift(np.zeros((1, 1, 3))).alt


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: draw_drift(np.zeros((4, 3))), "robots, steps"),
        (lambda: draw_drift(np.zeros((0, 4, 3))), "at least one robot"),
        (lambda: draw_map(Field(), truth=[[1.0, 2.0, 3.0, 4.0]]), "shape"),
        (lambda: draw_map(Field(), truth="here"), "truth must be poses"),
        (lambda: draw_map(Field(), measurements=[Measurement(0.1, 1.0)]), "need a pose"),
        (lambda: draw_map(Field(), estimate=some_estimate(), source="lidar"), "source must be one of"),
        (lambda: draw_map(Field(), estimate="none"), "must be an Estimate"),
        (lambda: draw_picture(np.zeros((4, 4, 4))), "shape"),
        (lambda: draw_picture(np.zeros((4, 4, 3))), "uint8"),
        (lambda: draw_picture(np.zeros((4, 4, 3), np.uint8), landmarks=[[1, 2, 3]]), "landmarks"),
        (lambda: draw_pictures([]), "at least one"),
        (lambda: draw_pictures([np.zeros((4, 4))], ["a", "b"]), "1 pictures need 1 titles"),
        (lambda: draw_pictures([np.zeros((4, 4))], columns=0), "columns"),
        (lambda: draw_labels(np.zeros((4, 4, 3))), "shape"),
        (lambda: draw_labels(np.full((4, 4), 7)), "0 other"),
        (lambda: ellipse_outlines([0, 0], [np.eye(2)], probability=95), "between 0 and 1"),
        (lambda: plot_ellipse([0, 0], np.eye(3), Figure().add_subplot()), r"\(2, 2\)"),
        (lambda: plot_landmarks([[0, 0]], [], Figure().add_subplot()), "need 1 kinds"),
        (lambda: plot_landmarks([[0, 0]], ["tree"], Figure().add_subplot()), "tree"),
        (lambda: plot_pose(Pose(), Figure().add_subplot(), "gps"), "'gps'"),
    ],
)
def test_a_wrong_value_is_refused_in_words(call, said):
    with pytest.raises(ValueError, match=said):
        call()


def test_axis_verbs_draw_on_the_axis_they_get():
    ax = Figure().add_subplot()
    plot_path([Pose(), Pose(1, 0, 0)], ax, "odometry")
    plot_estimate(some_estimate(), ax, "graph")
    assert {line.get_color() for line in ax.lines} == {STYLES["odometry"].colour, STYLES["graph"].colour}


def test_a_drawing_says_what_it_shows():
    drawing = draw_labels([[0, 1], [2, 3]])
    assert isinstance(drawing, Drawing)
    assert "green 25.0%" in repr(drawing)


def test_the_library_holds_no_way_back_from_a_pixel_to_the_ground():
    names = [name for name in dir(plotting) if "ground" in name.lower() or "inverse" in name.lower()]
    assert names == []


def test_a_table_is_text_and_html_with_nothing_unescaped():
    shown = plotting.table(["<b>", "n"], [["a & b", 1.5], ["c", None]])
    assert repr(shown) == "<b>    n\na & b  1.5\nc      None"
    assert (
        "<td" in shown._repr_html_()
        and "<b>" not in shown._repr_html_()
        and "a &amp; b" in shown._repr_html_()
    )
    with pytest.raises(ValueError, match="row 2 has 1 values for 2 columns"):
        plotting.table(["a", "b"], [[1, 2], [3]])


def test_labels_are_painted_in_their_colours():
    painted = plotting.painted([[0, 1], [2, 3]])
    assert painted.dtype == np.uint8 and painted.shape == (2, 2, 3)
    assert np.allclose(
        painted.reshape(4, 3) / 255, [to_rgb(each) for each in plotting.LABEL_COLOURS], atol=1 / 255
    )
    with pytest.raises(ValueError, match="labels must be"):
        plotting.painted([[4]])


def test_hues_are_drawn_on_their_circle_with_intervals_through_zero():
    drawing = plotting.draw_hue_circle({"ball": [350, 5]}, {"ball": (348.0, 12.0)})
    (arc,) = [line for line in drawing.figure.axes[0].lines if len(line.get_xdata()) == 200]
    swept = np.degrees(arc.get_xdata())
    assert np.isclose(swept[0], 348) and np.isclose(swept[-1], 372) and (np.diff(swept) > 0).all()
    assert "limits from 348.0 to 12.0 degrees" in drawing.alt
    for wrong in ({}, {"a": [1]}):
        with pytest.raises(ValueError, match=r"at least one entry|limits are for"):
            plotting.draw_hue_circle(wrong, {"b": (1.0, 2.0)})


def test_a_picture_is_drawn_beside_its_hue_saturation_and_lightness(rng):
    picture = rng.integers(0, 256, (6, 8, 3), dtype=np.uint8)
    drawing = plotting.draw_hsl(picture, np.full((6, 8), 120.0), np.full((6, 8), 0.25), np.full((6, 8), 80.0))
    assert len(drawing.figure.axes) == 4 and "120 degrees, 0.25 and 80" in drawing.alt
    shown = drawing.figure.axes[1].images[0].get_array()
    assert (shown[..., 1] > 200).all() and (shown[..., [0, 2]] == 0).all()
    with pytest.raises(ValueError, match="saturation must have shape"):
        plotting.draw_hsl(picture, np.zeros((6, 8)), np.zeros((6, 7)), np.zeros((6, 8)))
