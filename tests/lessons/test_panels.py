"""What holds for the panels of all lessons; what a panel shows is tested in its lesson's folder."""

import re

import ipywidgets
import pytest
from matplotlib.text import Text

from nao_course.lessons.beyond import ExplorePanel, MovesPanel, TwoCamerasPanel
from nao_course.lessons.distance import PhoneLab, RayPanel, TiltPanel
from nao_course.lessons.ekf_derivations.lap import LapPanel
from nao_course.lessons.ekf_derivations.panel import LANDMARK, MEASUREMENT, LinearisationPanel
from nao_course.lessons.localization.panels import FusePanel, LabPanel
from nao_course.lessons.meet_the_nao import HeadPanel
from nao_course.lessons.pose_graphs import EdgePanel, RelaxPanel
from nao_course.lessons.slam_on_the_field import ReplayPanel, RoomPanel
from nao_course.widgets import RealityDial
from nao_course.widgets.parts import LabelledImage
from tests.lessons.every import blank, reference
from tests.lessons.experiments.test_panel import panel as setting_panel
from tests.lessons.goalposts.test_panel import panel as post_panel
from tests.lessons.graph_slam.test_panel import panel as graph_panel
from tests.lessons.hough_corners.test_panel import panel as corner_panel
from tests.lessons.hsl_filtering.test_panel import blank_filter_panel
from tests.widgets.robots import all_widgets

CONTROLS = ipywidgets.Button | ipywidgets.Dropdown | ipywidgets.FloatSlider | ipywidgets.IntSlider


def of(panel, lesson, *names, **more):
    """Return a function that makes a panel of the solutions' functions, or of others in their places."""
    return lambda **changed: panel(**{name: reference(lesson)[name] for name in names} | more | changed)


FIVE = ("predict_pose", "predict_covariance")
MORE_OF_5 = ("landmark_position", "landmark_jacobians", "expected_measurement", "measurement_jacobian_pose")
FOUR = ("pixel_to_ground", "ground_to_measurement", "measurement_covariance")
SEVEN = {name: reference("07_ekf_slam")[name] for name in ("predict", "update_landmarks", "add_landmark")}
PANELS = {
    "head": HeadPanel,
    "dial": RealityDial,
    "filter": blank_filter_panel,
    "posts": post_panel,
    "corners": corner_panel,
    "ray": of(RayPanel, "04_distance", "pixel_to_ground"),
    "tilt": of(TiltPanel, "04_distance", *FOUR),
    "phone": of(PhoneLab, "04_distance", "pixel_to_ground", find_landmarks=lambda picture: [(160.0, 120.0)]),
    "lap": of(LapPanel, "05_ekf_derivations", *FIVE),
    "linearisation": of(LinearisationPanel, "05_ekf_derivations", *FIVE, *MORE_OF_5),
    "fuse": of(FusePanel, "06_localization", "fuse"),
    "graph": graph_panel,
    "edges": of(EdgePanel, "09_pose_graphs", "linearize"),
    "relaxing": of(RelaxPanel, "09_pose_graphs", "linearize", "gauss_newton"),
    "settings": setting_panel,
    "replay": of(ReplayPanel, "11_slam_on_the_field", "associate", "joint_distance"),
    "room": of(RoomPanel, "11_slam_on_the_field", "EkfSlam"),
    "exploring": of(ExplorePanel, "12_beyond", "find_frontiers", "travel_steps"),
    "moves": of(MovesPanel, "12_beyond", "choose_move", **SEVEN),
    "cameras": of(
        TwoCamerasPanel,
        "12_beyond",
        "intersect_rays",
        pixel_to_ground=reference("04_distance")["pixel_to_ground"],
    ),
}
# The exercise that a panel names if a function is not written; VALUES have to be set to see some of them
UNFINISHED = {
    "posts": {"candidates": "2.1", "cluster": "2.2"},
    "corners": {"erase_background": "3.2", "find_segments": "3.3", "find_corners": "3.6"},
    "ray": {"pixel_to_ground": "4.4"},
    "tilt": {"pixel_to_ground": "4.4", "ground_to_measurement": "4.1", "measurement_covariance": "4.6"},
    "phone": {"find_landmarks": "lessons 01", "pixel_to_ground": "4.4"},
    "lap": {"predict_pose": "5.1", "predict_covariance": "5.5"},
    "linearisation": {
        "predict_pose": "5.1",
        "predict_covariance": "5.5",
        "landmark_jacobians": "5.6",
        "measurement_jacobian_pose": "5.8",
    },
    "fuse": {"fuse": "6.1"},
    "graph": {"add_initial_position": "8.1", "add_relative_motion": "8.2", "solve": "8.4"},
    "edges": {"linearize": "9.5"},
    "relaxing": {"linearize": "9.5"},
    "settings": {"grid_search": "10.3", "bootstrap_interval": "10.4"},
    "room": {"EkfSlam": "11.5"},
    "exploring": {"find_frontiers": "12.5", "travel_steps": "12.6"},
    "moves": {"choose_move": "12.7"},
}
VALUES = {
    "landmark_jacobians": {"what": LANDMARK},
    "measurement_jacobian_pose": {"what": MEASUREMENT},
    "choose_move": {"move": 2},
}


@pytest.mark.parametrize("name", PANELS)
def test_controls_and_pictures_are_named_and_a_picture_and_words_stay_where_no_widget_lives(name):
    panel = PANELS[name]()
    bundle = panel._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in bundle and panel.summary() in bundle["text/plain"]
    assert re.search(r'<img[^>]* alt="[^"]{10,}"', bundle["text/html"]) and len(bundle["text/html"]) < 10**6
    widgets = list(all_widgets(panel.widget))
    assert all(each.description and each.tooltip for each in widgets if isinstance(each, CONTROLS))
    assert all(each.alt for each in widgets if isinstance(each, LabelledImage))
    assert PANELS[name]().summary() == panel.summary()


@pytest.mark.parametrize("name", ["phone", "edges", "relaxing", "replay"])  # two pictures with letters
def test_the_letters_of_figures_are_9_px_high_on_a_page_of_900_px(name):
    shown = PANELS[name]().shown
    room = 720 - 8 * (len(shown.pictures) - 1)  # px, of the panel's width
    height = min(400, room / sum(each.shape[1] / each.shape[0] for each in shown.pictures.values()))
    for title, drawing in shown.drawings.items():
        letters = [each for each in drawing.figure.findobj(Text) if each.get_visible() and each.get_text()]
        pixels = min(each.get_fontsize() for each in letters) / 72 * drawing.figure.dpi
        assert pixels * height / shown.pictures[title].shape[0] >= 9, title


@pytest.mark.parametrize(
    ("name", "function"),
    [(name, function) for name, functions in UNFINISHED.items() for function in functions],
)
def test_an_unfinished_exercise_is_named_and_a_wrong_answer_stops_nothing(name, function):
    def shown(answer):
        panel = PANELS[name](**{function: answer})
        panel.set(**VALUES.get(function, {}))
        return panel

    assert re.search(rf"Finish (exercises? )?.*{UNFINISHED[name][function]}", shown(blank).summary())
    if (name, function) not in (("graph", "solve"), ("room", "EkfSlam")):
        panel = shown(lambda *given, **named: None)
        assert panel.error is not None and "Finish" not in panel.summary()


def test_the_patients_of_a_blank_notebook_wait_for_its_filter():
    assert "6.6" in LabPanel(blank, *(reference("05_ekf_derivations")[name] for name in FIVE)).summary()


@pytest.mark.parametrize(
    "panel",
    [lambda: setting_panel(scenes=[]), lambda: post_panel(scenes={}), lambda: corner_panel(pictures={})],
)
def test_without_anything_to_choose_there_is_no_panel(panel):
    with pytest.raises(ValueError, match="at least"):
        panel()
