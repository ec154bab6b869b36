"""The control panel: what happens on each command, what it shows, and what it must not show."""

import contextlib
import re
import threading
import time

import numpy as np
import pytest

from nao_course._internal.time_limits import TooSlow
from nao_course.geometry import Pose
from nao_course.sim import Truth
from nao_course.slam import DeadReckoning, Estimate, Measurement, SlamAlgorithm
from nao_course.widgets import ControlPanel
from nao_course.widgets.control_panel.cockpit import STEP
from tests.widgets.robots import Failing, Recorder, clean_nao, press


def test_slam_gets_every_motion_and_the_map_begins_where_the_robot_stands():
    nao, slam = clean_nao(pose=Pose(0.5, -0.5, 0.4)), Recorder()
    panel = ControlPanel(nao, Truth(nao), slam)
    panel.forward(0.3)
    panel.left(0.7)
    panel.back(0.1)
    assert len(slam.motions) == 6 + 9 + 2
    assert np.allclose(slam.estimate().pose.as_array(), nao.odometry.as_array())
    assert np.allclose(panel.cockpit.estimate.pose.as_array(), panel.cockpit.odometry[-1].as_array())
    nao = clean_nao(pose=Pose(0.5, -0.5, 0.4))
    assert np.allclose(ControlPanel(nao, Truth(nao)).cockpit.odometry[0].as_array(), [0.5, -0.5, 0.4])
    assert np.allclose(ControlPanel(nao).cockpit.odometry[0].as_array(), 0)
    assert np.allclose(ControlPanel(nao, start=Pose(1, 1, 0)).cockpit.odometry[0].as_array(), [1, 1, 0])


def test_pictures_are_counted_and_those_taken_are_kept_with_their_truth():
    panel = ControlPanel(clean_nao())
    panel.forward(0.2)
    assert panel.cockpit.frames == 2 + 4 * 2
    panel.size = (640, 480)
    panel.camera = "top"
    picture = panel.take_picture()
    assert picture.pixels.shape == (480, 640, 3)
    assert (picture.camera, panel.picture, panel.pictures) == ("top", picture, (picture,))
    assert panel.cockpit.frames == 11
    nao = clean_nao()
    truth = Truth(nao)
    panel = ControlPanel(nao, truth)
    panel.camera = "bottom"
    panel.forward(0.1)
    labels = panel.cockpit.picture_truth("bottom").labels
    assert truth.picture is panel.cockpit.picture_truth("top")  # the camera that was not chosen came last
    assert labels is not truth.picture.labels
    assert ControlPanel(clean_nao()).cockpit.picture_truth("bottom") is None


def test_the_head_stops_at_its_joints_with_a_message_and_words_and_a_picture_remain_without_a_widget():
    panel = ControlPanel(clean_nao())
    for _ in range(20):
        press(panel, "look-down")
        press(panel, "look-right")
    assert np.allclose(np.degrees(panel.cockpit.nao.head), [-119.5, 29.5])
    assert "limit" in panel.cockpit.message
    press(panel, "look-ahead")
    assert np.allclose(np.degrees(panel.cockpit.nao.head), [0, -31])
    panel = ControlPanel(clean_nao())
    bundle = panel._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in bundle
    assert bundle["text/plain"].startswith("ControlPanel: NAO V4")
    assert '<img alt="Control panel: NAO V4; odometry (0.00, 0.00) m' in bundle["text/html"]


def test_a_hidden_truth_is_neither_in_words_nor_in_the_map_and_a_panel_without_truth_cannot_show_it():
    nao = clean_nao()
    truth = Truth(nao)
    panel = ControlPanel(nao, truth, show_truth=False)
    panel.forward(0.3)
    before = panel._screen._map.contents.paths
    truth.place(Pose(2.0, 1.0, 2.0))
    panel._screen._show_map()
    assert panel._screen._map.contents.paths == before == {"odometry": tuple(panel.cockpit.odometry)}
    assert "truth" not in panel.summary()
    assert "Show the truth" in panel._controls.numbers.value and " cm" not in panel._controls.numbers.value
    assert "truth" not in repr(panel._repr_mimebundle_()["text/html"])
    panel.show_truth = True
    assert panel._screen._map.contents.paths["truth"][-1] == Pose(2.0, 1.0, 2.0)
    assert "truth (2.00, 1.00) m" in panel.summary()
    panel = ControlPanel(clean_nao())
    assert not panel.show_truth
    with pytest.raises(ValueError, match="truth=Truth"):
        panel.show_truth = True


def test_three_dimensions_are_made_when_they_are_chosen_and_show_the_truth_only_with_the_map():
    nao = clean_nao()
    panel = ControlPanel(nao, Truth(nao))
    assert panel._screen._world is None
    press(panel, "world")
    world = panel._screen._world
    assert panel._controls._face.children == (world.widget,)
    panel.forward(0.1)
    assert world.contents.truth == Truth(nao).pose
    assert world.widget.estimate_name == "odometry" and "arrow" not in world.widget.hint
    panel.show_truth = False
    assert world.contents.truth is None and "truth" not in world.contents.paths
    press(panel, "world")
    panel.forward(0.1)
    assert panel._controls._face.children == (panel._screen._map.widget,)
    assert panel._screen._map.contents.paths["odometry"] == tuple(panel.cockpit.odometry)


@pytest.mark.parametrize(
    ("where", "said"),
    [("observe", "ZeroDivisionError in observe(), line"), ("estimate", "TypeError in estimate(): ")],
)
def test_an_exception_in_slam_is_a_message_and_the_panel_lives(where, said):
    nao = clean_nao()
    panel = ControlPanel(nao, slam=Failing(where))
    panel.forward(0.2)
    panel.run_slam()
    panel.forward(0.2)
    panel.run_slam()
    assert said in panel.cockpit.message
    assert isinstance(panel.error, Exception)
    panel.turn_head(0.1)
    assert "Head at" in panel.cockpit.message


def test_a_failing_move_ends_the_drive_and_says_where():
    nao = clean_nao()
    panel = ControlPanel(nao, slam=Failing("move"))
    panel.forward(0.5)
    assert nao.odometry.x == pytest.approx(STEP)
    assert re.search(r"IndexError in move\(\), line \d+: index 9 is out of bounds", panel.cockpit.message)
    assert "&lt;b&gt;" in panel._controls.status.value
    assert "nao-alarm" in panel._controls.status.value
    with pytest.raises(IndexError):
        raise panel.error


def test_the_map_shows_how_far_the_chosen_camera_sees():
    panel, far = ControlPanel(clean_nao()), {}
    for camera in ("top", "bottom"):
        panel.camera = camera
        panel.turn_head(pitch=1.5)
        far[camera] = panel._screen.contents().view[2]
        assert far[camera] == panel.cockpit.pictures[camera].view.visible_ground()[1]
    assert far["bottom"] < far["top"] < np.inf
    panel.turn_head(pitch=-2.0)
    panel.camera = "top"
    assert panel._screen.contents().view[2] == np.inf  # the horizon, or no ground


def test_dead_reckoning_has_one_path_on_the_map_because_its_path_is_the_odometrys():
    numbers = {
        type(slam): len(ControlPanel(clean_nao(), slam=slam)._screen.contents().paths)
        for slam in (DeadReckoning(), Recorder())
    }
    assert numbers == {DeadReckoning: 1, Recorder: 2}


def test_measure_gets_the_picture_and_its_view_and_without_it_the_ideal_detector_measures():
    got = []

    def measure(pixels, view):
        got.append((pixels.shape, view))
        pixels[:] = 0
        return [Measurement(0.1, 2.0)]

    slam = Recorder()
    panel = ControlPanel(clean_nao(), slam=slam, measure=measure)
    panel.size = (640, 480)
    assert panel.run_slam() == (Measurement(0.1, 2.0),)
    assert slam.seen == [(Measurement(0.1, 2.0),)]
    assert got == [((480, 640, 3), panel.cockpit.pictures["bottom"].view)]
    assert panel.cockpit.pictures["bottom"].pixels.any()
    panel = ControlPanel(clean_nao(), slam=(slam := Recorder()))
    seen = panel.run_slam()
    assert len(seen) >= 3
    assert slam.seen == [seen]
    panel.forward(0.05)
    assert panel.cockpit.seen == ()


@pytest.mark.parametrize("returned", [None, [(0.1, 2.0)], Measurement(0.1, 2.0)])
def test_a_measure_that_returns_something_else_is_told_so(returned):
    slam = Recorder()
    panel = ControlPanel(clean_nao(), slam=slam, measure=lambda pixels, view: returned)
    assert panel.run_slam() == ()
    assert "Measurement" in panel.cockpit.message
    assert slam.seen == []


def test_what_the_students_code_prints_is_in_the_panel_and_where_it_belongs(capsys):
    def measure(pixels, view):
        print("three <corners>")
        return []

    panel = ControlPanel(clean_nao(), slam=Recorder(), measure=measure)
    press(panel, "slam")
    assert panel.cockpit.printed == "three <corners>\n"
    assert "three &lt;corners&gt;" in panel._controls.status.value
    assert capsys.readouterr().out == "three <corners>\n"
    panel.forward(0.05)
    assert "corners" not in panel._controls.status.value


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"nao": 3}, "SimulatedNao"),
        ({"slam": DeadReckoning}, r"DeadReckoning\(\.\.\.\)"),
        ({"slam": object()}, "move, observe and estimate"),
        ({"measure": 5}, "measure must be a function"),
        ({"truth": True}, "Truth"),
        ({"source": "lidar"}, "source must be one of"),
    ],
)
def test_a_part_that_cannot_work_is_refused_in_words(parts, said):
    with pytest.raises(ValueError, match=said):
        ControlPanel(**{"nao": clean_nao(), **parts})


class Endless(Recorder):
    """Has a loop without an end until it is mended."""

    mended = False

    def move(self, motion):
        while not self.mended:
            with contextlib.suppress(Exception):  # as a student's `except Exception`
                time.sleep(0)
        super().move(motion)


def test_code_that_never_ends_is_stopped_and_the_panel_lives():
    slam = Endless()
    panel = ControlPanel(clean_nao(), slam=slam, measure=lambda *_: [Measurement(0.1, 2.0)], time_limit=0.2)
    press(panel, "forward")
    assert "move() was not done after 0.2 s and was stopped in line" in panel.cockpit.message
    assert "nao-alarm" in panel._controls.status.value and isinstance(panel.error, TooSlow)
    slam.mended = True
    before = panel.cockpit.nao.odometry.x
    press(panel, "forward")
    assert panel.cockpit.nao.odometry.x == pytest.approx(before + 0.2)
    assert panel.cockpit.message == "Walk 0.20 m ahead: done."
    press(panel, "slam")
    assert (
        "Measured 1 landmark with the bottom camera; the map of Endless contains 0" in panel.cockpit.message
    )
    assert "nao-alarm" not in panel._controls.status.value


def test_strange_estimates_are_drawn_without_complaint_and_the_panel_starts_no_thread():
    class Strange(SlamAlgorithm):
        def move(self, motion):
            """Nothing."""

        def observe(self, measurements):
            """Nothing."""

        def estimate(self):
            landmarks = np.array([[np.nan, 1.0], [1e12, 0.0], [1.0, 1.0]])
            covariances = np.array([np.full((2, 2), np.nan), -np.eye(2), 1e9 * np.eye(2)])
            kinds = ("post", "corner", "corner")
            return Estimate(Pose(), np.full((3, 3), np.inf), landmarks, covariances, kinds)

    panel = ControlPanel(clean_nao(), slam=Strange())
    panel.forward(0.1)
    assert not panel.cockpit.alarm
    assert panel.drawing().image()
    before = threading.active_count()
    panel = ControlPanel(clean_nao())
    panel.forward(0.1)
    assert threading.active_count() == before
