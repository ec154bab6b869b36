"""The student's vision while the robot drives: what a stage shows, and that nothing it does stops the drive."""

import asyncio
import re

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, Picture, SimulatedNao, Truth
from nao_course.slam import Estimate, Motion
from nao_course.widgets.control_panel import ControlPanel, Overlay, Pipeline, Stage
from nao_course.widgets.control_panel import pipeline as module
from tests.paths import PROJECT
from tests.widgets.robots import all_widgets, clean_nao, decoded, press, until_it_stands


def brightest(picture):
    return np.argwhere(picture.mean(axis=2) > 240)[:3, ::-1]


def paint(student, nao):
    """A stage that paints what is bright in pink, and hands on where that is."""

    def look(frame):
        pixels = student.brightest(frame.picture.pixels)
        painted = np.full(frame.picture.pixels.shape, (255, 0, 200), np.uint8)
        return Overlay(pixels, painted, pixels=pixels, text=f"{len(pixels)} bright")

    return look


def ahead(student, nao):
    """A stage that puts two points on the map: what a later lesson makes of the pixels of an earlier one."""

    def look(frame):
        points = student.to_ground(frame.results["bright"], frame.picture.view)
        return Overlay(points=points, text=f"{len(points)} on the ground")

    return look


BRIGHT = Stage("bright", "90_toy", ("brightest",), paint)
GROUND = Stage("points", "91_toy", ("to_ground",), ahead, after=("bright",))


def to_ground(pixels, view):
    return [(1.0, 0.0), (1.0, 0.5)]


def make(stages=(BRIGHT, GROUND), *, pose=None, nao=None, missing=None, time_limit=60.0, **functions):
    functions = {"brightest": brightest, "to_ground": to_ground, **functions}
    nao = nao or clean_nao(pose=pose or Pose(0.6, 0.5, -0.25))
    return ControlPanel(nao, Truth(nao), pipeline=Pipeline(stages, functions, nao, missing, time_limit))


def image(panel, name):
    return next(each for each in all_widgets(panel.widget) if f"nao-image-{name}" in each._dom_classes)


def status(panel):
    return panel._controls.status.value


def pinkness(pixels):
    """How much redder and bluer than green a picture is on the whole."""
    red, green, blue = pixels.reshape(-1, 3).mean(axis=0)
    return (red + blue) / 2 - green


def test_what_a_stage_paints_lies_over_the_chosen_cameras_picture_or_beside_it_in_the_other_cameras_place():
    panel = make()
    assert panel.view == "over"
    assert pinkness(decoded(image(panel, "bottom"))) > 60 > 20 > pinkness(decoded(image(panel, "top")))
    panel.camera = "top"
    assert pinkness(decoded(image(panel, "top"))) > 60 > 20 > pinkness(decoded(image(panel, "bottom")))
    panel = make()
    panel.view = "beside"
    assert pinkness(decoded(image(panel, "top"))) > 100 > 20 > pinkness(decoded(image(panel, "bottom")))
    assert "<b>Your view</b>" in panel._controls.captions["top"].value
    panel = make()
    panel.view = "picture"
    bare = decoded(image(panel, "bottom")).astype(int)
    panel.view = "beside"
    assert np.abs(decoded(image(panel, "bottom")) - bare).max() > 80
    assert "your marks" in image(panel, "bottom").alt


def drive(views):
    """A short drive with a filter that counts its updates, and the views that were chosen after each step."""

    def counting(student, nao):
        updates = []

        def look(frame):
            with nao.aside(np.random.default_rng(1)):
                updates.append(nao.sense(frame.picture.camera))
            pose = Pose(len(updates), 0.0, 0.0)
            nothing = (np.empty((0, 2)), np.empty((0, 2, 2)))
            return Overlay(estimate=Estimate(pose, np.eye(3) / len(updates), *nothing))

        return look

    stage = Stage("filter", "92_toy", (), counting, estimates=True)
    panel = make((BRIGHT, stage), nao=SimulatedNao(pose=Pose(0.6, 0.5, -0.25), rng=41))
    for _ in range(3):
        panel.forward(0.05)
        for view in views:
            panel.view = view
    panel.camera = "top"
    panel.view = "over"
    return panel


@pytest.mark.parametrize("views", [("beside", "picture", "over"), ("picture",), ("beside",)])
def test_a_view_changes_neither_the_estimate_nor_where_the_robot_drives(views):
    changed, left_alone = drive(views), drive(())
    assert len(left_alone._own.path) == 5  # the first picture, three steps, and the other camera
    assert changed._own.path == left_alone._own.path
    assert changed.cockpit.truth.pose == left_alone.cockpit.truth.pose
    for camera in ("top", "bottom"):
        pictures = (each.cockpit.pictures[camera].pixels for each in (changed, left_alone))
        assert np.array_equal(*pictures)
    changed.camera = "bottom"  # its picture has been processed already
    assert changed._own.path == left_alone._own.path


def test_the_button_goes_round_the_views_and_says_which_it_is():
    panel = make()
    seen = []
    for _ in range(3):
        press(panel, "view")
        seen.append((panel.view, panel._controls.view.description))
    assert seen == [(view, module.VIEWS[view]) for view in ("beside", "picture", "over")]
    shown = [str(getattr(each, "value", "")) for each in all_widgets(panel.widget)]
    (keys,) = [each for each in shown if "nao-keys" in each[:99]]
    assert "arrowup" in keys and "V changes the view" in keys


def test_each_step_is_looked_at_once_and_points_of_a_later_stage_stand_on_the_map_before_the_robot():
    looked = []
    panel = make(brightest=lambda picture: looked.append(picture) or brightest(picture))
    looked.clear()
    panel.forward(0.15)
    assert len(looked) == 3
    assert np.array_equal(looked[-1], panel.cockpit.pictures["bottom"].pixels)
    panel = make(pose=Pose(0.5, 0.0, np.pi / 2))
    bare = make((), pose=Pose(0.5, 0.0, np.pi / 2))
    assert np.allclose(panel._screen.contents().points, [(1.0, 0.0), (1.0, 0.5)])
    assert panel._screen._map._sent["points"] == [500, 1000, 0, 1000]  # mm on the map
    assert bare._screen._map._sent.get("points", []) == []


def test_the_text_and_the_still_picture_say_what_was_seen():
    panel = make(missing={"corners": "find_corners of lesson 03 is not written yet"})
    panel.forward(0.05)
    for line in (
        "your NAO so far: ✔ bright (90), ✔ points (91)",
        "not yet: corners, because find_corners of lesson 03 is not written yet",
        "bright: 3 bright",
        "points: 2 on the ground",
        "status: Walk 0.05 m ahead: done.",
    ):
        assert line in panel.summary().splitlines()
    drawing = panel.drawing()
    assert "bottom camera, your bright" in {ax.get_title(loc="left") for ax in drawing.figure.axes}
    assert "3 bright" in drawing.alt
    assert "corners" in panel.widget.children[2].value  # the line on top


def test_without_stages_there_is_no_button_and_no_view_to_choose():
    panel = make(stages=(), missing={"labels": "it is not there"})
    assert panel._controls.view is None and "nothing yet" in panel.summary()
    with pytest.raises(ValueError, match="make it with my_nao"):
        panel.view = "over"
    with pytest.raises(ValueError, match=r"view must be one of \['picture', 'over', 'beside'\], got 'under'"):
        make().view = "under"


def test_the_stage_of_the_documentation_is_made_of_ten_lines_and_marks_what_is_found():
    page = (PROJECT / "docs" / "write_a_panel.md").read_text(encoding="utf-8")
    (example,) = [each for each in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "STAGE = " in each]
    assert len([line for line in example.splitlines() if line.strip()]) <= 10
    room = {"Overlay": Overlay, "Stage": Stage}
    exec(example, room)
    labels = Stage("labels", "01_hsl_filtering", (), lambda *_: lambda frame: Overlay(result="labels"))
    functions = {"find_goalposts": lambda labels: [(5.0, 6.0), (7.0, 8.0)]}
    seen = pipeline_of(labels, room["STAGE"], **functions).process(PICTURE)
    assert seen.complaints == () and seen.lines() == ["goal posts: 2 found"]
    assert np.array_equal(seen.overlays["goal posts"].pixels, [(5, 6), (7, 8)]) and seen.names == "goal posts"


def test_the_last_stage_that_has_an_estimate_says_where_the_robot_is_and_its_line_is_the_board():
    def estimating(x):
        estimate = Estimate(Pose(x, 0.0, 0.0), np.eye(3), np.empty((0, 2)), np.empty((0, 2, 2)))
        look = lambda *_: lambda frame: Overlay(estimate=estimate)  # noqa: E731
        return Stage(f"at {x}", "01_hsl_filtering", (), look, estimates=True)

    silent = Stage("silent", "01_hsl_filtering", (), lambda *_: lambda frame: Overlay())
    both = pipeline_of(estimating(1.0), estimating(2.0), silent)
    assert both.estimates and both.process(PICTURE).estimate.pose == Pose(2.0, 0.0, 0.0)
    assert not pipeline_of(silent).estimates and pipeline_of(silent).process(PICTURE).estimate is None
    own = Estimate(Pose(), np.eye(3), np.empty((0, 2)), np.empty((0, 2, 2)))
    overlays = {
        "pose": Overlay(text="here", estimate=own),
        "estimate": Overlay(text="off 3 cm", estimate=own),
        "corners": Overlay(text="2 corners"),
    }
    assert module.Seen(overlays).board == "estimate: off 3 cm"
    assert module.Seen({"corners": overlays["corners"]}).board == ""
    overlays["next move"] = Overlay(text="to the frontier", motion=Motion(0.1))
    assert module.Seen(overlays).board == "next move: to the frontier"


def failing(picture):
    raise IndexError("index 9 is out of bounds")


PICTURE = Picture(np.full((240, 320, 3), 250, np.uint8), NAO_V4.view("bottom", 0.0, 0.0), "bottom")


def pipeline_of(*stages, time_limit=60.0, **functions):
    functions = {"brightest": brightest, "to_ground": to_ground, **functions}
    return Pipeline(stages or (BRIGHT, GROUND), functions, None, None, time_limit)


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (failing, "Without bright: IndexError in brightest(), line"),
        (lambda picture: None, "the panel, in the code that uses the result of brightest()"),
        (lambda picture: [(np.nan, 1.0)], "pixels must be finite numbers"),
        (lambda picture: np.zeros((2, 3)), "pixels must have shape (N, 2), got (2, 3)"),
    ],
)
def test_what_a_stage_does_wrong_is_said_and_those_after_it_are_named(function, said):
    seen = pipeline_of(brightest=function).process(PICTURE)
    assert said in seen.complaints[0] and seen.error is not None
    assert seen.complaints[1] == "Without points: it needs bright."
    assert not seen.overlays and np.array_equal(seen.over(PICTURE.pixels), PICTURE.pixels)


def test_a_drive_goes_on_without_what_fails_and_a_painting_of_another_size_is_refused_in_words():
    panel = make(brightest=failing)
    panel.forward(0.1)
    assert "Walk 0.10 m ahead: done." in panel.summary() and "nao-alarm" in status(panel)
    assert "raise panel.error" in status(panel) and isinstance(panel.error, IndexError)
    assert pinkness(decoded(image(panel, "bottom"))) < 20
    overlay = Overlay(painted=np.zeros((2, 2, 3), np.uint8))
    small = Stage("small", "90_toy", (), lambda *_: lambda frame: overlay)
    (said,) = pipeline_of(small).process(PICTURE).complaints
    assert "shape (2, 2) does not fit the picture's, (240, 320)" in said


def test_one_bad_picture_costs_that_picture_only_and_a_calibration_that_fails_is_not_repeated():
    results = iter([IndexError("dark"), None])

    def sometimes(picture):
        if error := next(results):
            raise error
        return brightest(picture)

    pipeline = pipeline_of(brightest=sometimes)
    assert "Without bright" in pipeline.process(PICTURE).complaints[0]
    assert pipeline.process(PICTURE).complaints == ()
    tried = []

    def wire(student, nao):
        tried.append(1)
        raise ValueError("no carpet")

    pipeline = pipeline_of(Stage("bright", "90_toy", (), wire))
    first, second = (pipeline.process(PICTURE).complaints for _ in range(2))
    assert len(tried) == 1 and first == second and "Without bright: ValueError in the bright" in first[0]
    pipeline.retry()
    pipeline.process(PICTURE)
    assert len(tried) == 2


def test_a_function_that_never_ends_is_left_out_until_a_picture_is_taken():
    calls = []

    def endless(picture):
        calls.append(1)
        while len(calls) == 1:
            pass
        return brightest(picture)

    panel = make(brightest=endless, time_limit=1.0)
    assert "Time is up: brightest()" in panel.summary() and "take a picture" in panel.summary()
    panel._own._pipeline.time_limit = 60.0
    panel.forward(0.1)
    assert len(calls) == 1 and "Walk 0.10 m ahead: done." in panel.summary()
    press(panel, "view")
    assert len(calls) == 1
    press(panel, "picture")
    assert len(calls) == 2 and "Without bright" not in panel.summary()


def test_a_stage_cannot_change_the_picture_that_is_shown_and_what_its_code_prints_stands_in_the_panel(capsys):
    def vandal(picture):
        picture[:] = 0
        return []

    assert not pipeline_of(brightest=vandal).process(PICTURE).complaints and PICTURE.pixels.min() == 250
    panel = make(brightest=lambda picture: print("<seen>") or brightest(picture))
    assert "&lt;seen&gt;" in status(panel) and capsys.readouterr().out == ""


def wander(least):
    """A stage that wants to walk on until it has walked so far."""

    def wish(student, nao):
        return lambda frame: Overlay(motion=Motion(0.05) if nao.odometry.x < least - 1e-9 else None)

    return Stage("wish", "92_toy", (), wish, drives=True)


def test_from_code_or_by_a_press_the_robot_goes_where_the_stage_says_until_stop_or_nothing_is_left():
    panel = make((wander(0.2),))
    panel.explore(3)
    assert panel.cockpit.nao.odometry.x == pytest.approx(0.15)
    panel.explore(9)
    assert panel.cockpit.nao.odometry.x == pytest.approx(0.2)
    panel = make((wander(0.2),))
    driven_by_itself(panel, lambda: False)
    assert panel.cockpit.nao.odometry.x == pytest.approx(0.2) and not panel.driving
    panel = make((wander(50.0),))
    driven_by_itself(panel, lambda: panel.cockpit.nao.odometry.x > 0.12)
    assert panel.cockpit.nao.odometry.x < 1.0 and "Stopped." in panel.summary()
    panel.forward(0.05)
    assert not panel.driving


def driven_by_itself(panel, until):
    """Press the button, and wait until the drive has ended or `until` says so."""

    async def scenario():
        press(panel, "itself")
        while panel.driving and not until():
            await asyncio.sleep(0.01)
        panel.stop()
        await until_it_stands(panel)

    asyncio.run(scenario())


def test_when_nothing_is_left_the_panel_says_what_is_complete_and_what_it_took():
    def mapped(student, nao):
        truth = Truth(nao)

        def look(frame):
            estimate = Estimate(truth.pose, np.eye(3), np.empty((0, 2)), np.empty((0, 2, 2)))
            left = nao.odometry.x < 0.2 - 1e-9
            done = "" if left else "The whole field is seen"
            motion = Motion(0.05) if left else None
            return Overlay(motion=motion, finish=done, estimate=estimate, cells=[(1.0, 2.0)])

        return look

    panel = make((Stage("wish", "92_toy", (), mapped, drives=True, estimates=True),))
    assert "nao-finish" not in status(panel)
    assert np.allclose(panel._screen.contents().cells, [(1.0, 2.0)])
    panel.explore(9)
    assert "The whole field is seen: 0.2 m in 4 moves, &lt; 1 cm off; odometry alone is" in status(panel)
    assert "nao-finish" in status(panel)
    panel.show_truth = False
    assert "4 moves." in status(panel) and "off" not in status(panel)


def test_slow_code_is_said_to_be_slow_in_the_panel_and_not_in_what_a_lesson_prints(monkeypatch):
    monkeypatch.setattr(module, "SLOW", 0.0)
    panel = make()
    assert "slows the drive" not in status(panel), "the first picture also calibrates"
    panel.forward(0.05 * module.JUDGED)
    assert "which slows the drive down" in status(panel) and " ms " not in panel.summary()
