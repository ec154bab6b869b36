"""Each number that a student predicts is drawn on the axis that shows it, in the figure that follows."""

import ast
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from nao_course.exercises.asking import Prediction
from nao_course.instructor.authoring import lesson_text
from nao_course.lessons.ekf_derivations.figures import draw_curves
from nao_course.lessons.ekf_derivations.lap import LapPanel
from nao_course.lessons.experiments.landscape import draw_optimism, optimism
from nao_course.lessons.goalposts.figures import draw_heights, draw_recall
from nao_course.lessons.graph_slam.map_errors import ANGLES, draw_turning
from nao_course.lessons.graph_slam.map_errors import HEADINGS as KNOWN
from nao_course.lessons.hough_corners.results import draw_goal_line, draw_matches
from nao_course.lessons.hsl_filtering.figures import draw_stray_pixel
from nao_course.lessons.hsl_filtering.light import draw_light_limits
from nao_course.lessons.localization.figures import draw_cloud
from nao_course.lessons.meet_the_nao.drift import draw_drift, draw_growth
from nao_course.lessons.pose_graphs.guesses import HEADINGS, POSITIONS, draw_arrivals
from nao_course.metrics import PointMatch
from nao_course.plotting import Drawing, with_guess
from nao_course.slam import Motion
from tests.lessons.every import solved, text
from tests.lessons.experiments.own import table

LABELS = np.zeros((4, 4), dtype=np.uint8)
MATCHES = {"nothing": [PointMatch(np.zeros(2, dtype=bool), 0)] * 4}
RISING = np.array([[0.0, 0.1, 0.2], [0.1, 0.2, 0.3]])


def empty(*labels):
    """Return a drawing with one axes for each label of a y axis, in the place of a figure that takes long."""
    figure = Figure()
    for ax, label in zip(np.ravel(figure.subplots(1, len(labels))), labels, strict=True):
        ax.set(ylabel=label, ylim=(0, 200))
    return Drawing(figure, "")


# By lesson and prediction: the figure, a prediction, and a word of the label of its axis.
ARRIVALS = {"positions": np.ones(len(POSITIONS)), "headings": np.linspace(1, 0, len(HEADINGS))}
TURNING = dict.fromkeys(KNOWN, np.linspace(0, 1, len(ANGLES)))
CURVES = np.radians([5, 50]), {"mean": RISING, "shape": RISING}, {}
FIGURES = {
    ("00_meet_the_nao", "square_guess"): (lambda: draw_drift(np.zeros((3, 2, 3))), 0.3, "x (m)"),
    ("00_meet_the_nao", "straight_guess"): (
        lambda: draw_growth({"a": [Motion(1, 0)] * 9}, 1),
        0.2,
        "drift (m)",
    ),
    ("01_hsl_filtering", "dark"): (lambda: draw_light_limits([0.4, 1.6], [0, 1], [0, 1]), 0.7, "factor"),
    ("01_hsl_filtering", "stray"): (lambda: draw_stray_pixel(LABELS, LABELS, (1, 1), [0.2], 0.2), 30, "(%)"),
    ("02_goalposts", "height_guess"): (lambda: draw_heights([2], [9], ([1, 6], [99, 9]), {}), 5, "distance"),
    ("02_goalposts", "false_guess"): (lambda: draw_recall({}), 40, ""),
    ("03_hough_corners", "run_guess"): (lambda: draw_goal_line([2, 6], {7: [1, 0]}), 3, "distance"),
    ("03_hough_corners", "cost_guess"): (lambda: draw_matches(MATCHES), 2, "mean cost"),
    ("04_distance", "error_guess"): (lambda: empty("error of the distance (m)"), 0.5, "of the distance"),
    ("05_ekf_derivations", "break_guess"): (lambda: draw_curves(*CURVES), 18, "degrees"),
    ("08_graph_slam", "turn_guess"): (lambda: draw_turning(TURNING), 9, "degrees"),
    ("09_pose_graphs", "heading_guess"): (lambda: draw_arrivals(ARRIVALS), 40, "heading (degrees)"),
    ("12_beyond", "ancestors_guess"): (lambda: empty("particles", ""), 50, "particles"),
    ("12_beyond", "blind_guess"): (lambda: empty("median (cm)", ""), 0.2, "cm"),
}
WAITING = {
    "00": ("square_guess", "straight_guess"),
    "01": ("dark", "stray"),
    "02": ("height_guess", "false_guess"),
    "03": ("run_guess", "cost_guess"),
    "04": ("error_guess", "pixel_guess"),
    "05": ("break_guess",),
    "06": ("inside_guess",),
    "07": ("nis_guess", "loop_guess"),
    "08": ("filled_guess", "turn_guess"),
    "09": ("heading_guess",),
    "10": ("promise_guess", "source_guess"),
    "12": ("ancestors_guess", "blind_guess"),
}
PLACES = {"false_guess": 0.6, "blind_guess": 20}  # where a line is not at the number that was predicted


def written(value):
    guess = Prediction("How much?")
    guess.write(value)
    return guess


def call_with(lesson, prediction):
    """Return axis and options of the call in a lesson's text that draws this prediction."""
    for _, cell in lesson_text.code_cells(solved(lesson)):
        for node in ast.walk(ast.parse(lesson_text.python(cell))):
            if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "with_guess":
                _, guess, axis = node.args
                if guess.id == prediction:
                    options = {each.arg: eval(ast.unparse(each.value)) for each in node.keywords}
                    return axis.value, options
    raise AssertionError(f"no figure of {lesson} has {prediction}")


@pytest.mark.parametrize(("lesson", "prediction"), FIGURES)
def test_a_prediction_is_drawn_on_the_axis_of_its_quantity(lesson, prediction):
    draw, value, label = FIGURES[lesson, prediction]
    place = PLACES.get(prediction, value)
    axis, options = call_with(lesson, prediction)
    drawn = with_guess(draw(), written(value), axis, **options)
    ax = drawn.figure.axes[options.get("panel", 0)]
    if axis == "radius":
        assert ax.patches[-1].radius == place
    else:
        line = ax.lines[-1]
        assert (line.get_xdata() if axis == "x" else line.get_ydata())[0] == pytest.approx(place)
        assert label in (ax.get_xlabel() if axis == "x" else ax.get_ylabel())
    assert drawn.alt.endswith(f"marks your prediction, {value:g}.")


@pytest.mark.parametrize("lesson", WAITING)
def test_a_figure_that_shows_the_result_waits_for_the_prediction(lesson):
    assert all(f"{prediction}.unlocks(" in text(lesson) for prediction in WAITING[lesson])


@pytest.mark.parametrize("given", [None, 0.5])
def test_the_lap_has_a_circle_for_a_prediction(given):
    panel = LapPanel(guess=SimpleNamespace(value=given))
    shown = next(panel._show(SimpleNamespace(command=18), {}))
    assert ("marks your prediction" in shown[""].alt) == (given is not None)


def test_the_predicted_ellipse_is_drawn_and_a_predicted_difference_begins_at_the_mean_cost_on_the_first_half():
    def ellipse(covariance, probability):
        return np.sqrt(-2 * np.log(1 - probability)) * np.ones(2), 0.0

    drawn = draw_cloud(np.eye(2), ellipse, (0.4,), guess=written(68))
    assert "68 % that you predicted" in drawn.alt
    for nothing in (None, Prediction("?"), written(100)):
        assert "you predicted" not in draw_cloud(np.eye(2), ellipse, (0.4,), guess=nothing).alt
    costs = table()
    drawn = draw_optimism(costs, written(0.5))
    promised = optimism(costs).promised.mean()
    low, high = drawn.figure.axes[0].get_xlim()
    assert drawn.figure.axes[0].lines[-1].get_xdata()[0] == pytest.approx(np.clip(promised + 0.5, low, high))


@pytest.mark.parametrize(
    ("typed", "remark"), [("1", "Linear."), ("1.05", "Linear."), ("0.5", "Twice."), ("1.5", ""), ("1.94", "")]
)
def test_a_typical_prediction_gets_its_remark_unless_it_is_nearer_to_the_result(typed, remark):
    said = repr(written(typed).beside(1.93, {1.0: "Linear.", 0.5: "Twice.", 1.97: "Never said."}))
    assert said.endswith(f"it is 1.93. {remark}".strip())
