"""The stage of lesson 11: the student's class drives, and if `measure` is missing the simulator measures."""

import numpy as np
from scipy.linalg import block_diag

from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.geometry import Pose
from nao_course.lessons.slam_on_the_field.stage import STAGE, Board
from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import Estimate, Measurement, SlamAlgorithm
from nao_course.student.stages import readiness
from nao_course.widgets.control_panel import Pipeline


class Commanded(SlamAlgorithm):
    """Follows its commands exactly and counts its measurements."""

    def __init__(self, start, odometry):
        self.pose, self.seen = start, 0

    def move(self, motion):
        self.pose = self.pose @ motion.as_pose()

    def observe(self, measurements):
        self.seen += len(measurements)
        Commanded.last = measurements

    def estimate(self):
        return Estimate(self.pose, np.diag([0.01, 0.01, 0.01]), np.empty((0, 2)), np.empty((0, 2, 2)))


def looked(functions):
    nao = SimulatedNao(pose=Pose(0.6, 0.5, -0.25), rng=3)
    pipeline = Pipeline([STAGE], functions, nao)
    pipeline.process(nao.take_picture())
    nao.walk(0.2)
    return pipeline.process(nao.take_picture()), nao


def test_the_students_class_follows_and_the_board_says_error_and_nees_and_what_measure_lacks():
    seen, nao = looked({"EkfSlam": Commanded, "measure": lambda *_: [Measurement(0.1, 1.5, "post")]})
    assert not seen.complaints
    text = seen.overlays["estimate"].text
    assert "1 measurement by your measure" in text and "NEES" in text and "states 14 cm" in text
    assert np.allclose(seen.estimate.pose.as_array(), (Truth(nao).odometry_start @ nao.odometry).as_array())

    def measure(picture, view):
        raise EarlierNotUsable("find_goalposts of your lesson 02 is not usable yet.")

    seen, _ = looked({"EkfSlam": Commanded, "measure": measure})
    assert not seen.complaints
    assert "by sense(), for find_goalposts of your lesson 02 is" in seen.overlays["estimate"].text


def test_measure_gets_the_view_with_the_tilt_of_the_field_lines_and_the_filter_their_direction():
    views = []

    def measure(picture, view):
        views.append(view)
        return [Measurement(0.1, 1.5, "post")]

    nao = SimulatedNao(pose=Pose(0.6, 0.5, -0.25), rng=6)  # its body is tilted by 1.5 degrees
    picture = nao.take_picture()
    Pipeline([STAGE], {"EkfSlam": Commanded, "measure": measure}, nao).process(picture)
    true = Truth(nao).picture.view.rotation
    assumed, level = (np.linalg.norm(view.rotation - true) for view in (picture.view, views[0]))
    assert level < assumed / 3
    assert Commanded.last.direction_sigma < np.radians(2)


def test_without_measure_the_simulator_measures_with_its_noise_and_one_that_returns_no_list_is_said():
    seen, _ = looked({"EkfSlam": Commanded})
    assert "by sense()" in seen.overlays["estimate"].text
    _, nao = looked({"EkfSlam": Commanded})
    own = [nao.sensor_noise.covariance(each) for each in Commanded.last]
    assert len(own) > 1 and np.array_equal(Commanded.last.covariance, block_diag(*own))
    seen, _ = looked({"EkfSlam": Commanded, "measure": lambda picture, view: None})
    assert "got NoneType" in seen.complaints[0]


def test_what_is_missing_is_named_and_an_overconfident_board_says_so(tmp_path):
    found = readiness([STAGE], {}, tmp_path)
    assert not found.stages and "11_slam_on_the_field.ipynb" in found.missing["estimate"]
    nao = SimulatedNao(rng=1)
    off = Truth(nao).pose @ Pose(0.5, 0.0, 0.0)
    sure = Estimate(off, 1e-4 * np.eye(3), np.empty((0, 2)), np.empty((0, 2, 2)))
    text = Board().after(sure, Truth(nao))
    assert "off 50 cm" in text and float(text.split("NEES ")[1].split(",")[0]) > 1000
