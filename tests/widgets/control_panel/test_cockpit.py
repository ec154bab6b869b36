"""The cockpit: commands without buttons."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim import SensorNoise, TorsoTilt, Truth
from nao_course.slam import DeadReckoning, Motion
from nao_course.widgets.control_panel.cockpit import STEP, TURN_STEP, Cockpit, small_steps
from tests.widgets.robots import Recorder, clean_nao


@pytest.mark.parametrize(
    "motion", [Motion(0.2), Motion(-0.33, 1.0), Motion(0.0, -np.pi), Motion(), Motion(1e-9)]
)
def test_the_pieces_of_a_motion_are_small_and_add_up_to_it(motion):
    parts = list(small_steps(motion))
    assert sum(part.distance for part in parts) == pytest.approx(motion.distance)
    assert sum(part.turn for part in parts) == pytest.approx(motion.turn)
    assert all(abs(part.distance) <= STEP + 1e-9 and abs(part.turn) <= TURN_STEP + 1e-9 for part in parts)


def test_an_algorithm_that_maps_in_the_field_frame_is_drawn_there_and_a_heading_near_zero_is_shown_as_zero():
    nao = clean_nao(pose=Pose(0.5, -0.5, 0.4))
    cockpit = Cockpit(nao, Truth(nao), Recorder(Pose(0.5, -0.5, 0.4)), frame=Pose())
    cockpit.note(cockpit.step(Motion(0.05)))
    assert np.allclose(cockpit.estimate.pose.as_array(), cockpit.odometry[-1].as_array())
    cockpit = Cockpit(clean_nao())
    cockpit.note(cockpit.step(Motion(-1e-6, -1e-6)))
    assert "-0" not in " ".join(cockpit.facts())


def test_the_ideal_detector_measures_what_the_picture_on_the_screen_shows():
    nao = clean_nao(pose=Pose(0.5, -0.5, 0.4), tilt=TorsoTilt(0.3, 0.3), sensor_noise=SensorNoise(0.0, 0.0))
    cockpit, counts = Cockpit(nao, Truth(nao)), set()
    for _ in range(10):
        seen = cockpit.observe("bottom")
        shown = [each for each in cockpit.picture_truth("bottom").landmarks if not each.occluded]
        assert [each.bearing for each in seen] == sorted(
            each.bearing for each in shown if each.landmark.detected_as
        )
        counts.add(len(seen))
    assert len(counts) > 1  # the body tilts differently each time


def test_an_algorithm_is_named_after_its_class_and_dead_reckoning_in_words():
    said = {type(slam): Cockpit(clean_nao(), slam=slam) for slam in (DeadReckoning(), Recorder())}
    assert said[DeadReckoning].names("ekf", False) == {"ekf": "odometry alone"}  # one path, one name
    assert said[Recorder].names("ekf", False) == {"odometry": "odometry", "ekf": "Recorder"}
    said[DeadReckoning].observe()
    assert (
        "DeadReckoning" not in said[DeadReckoning].summary()
        and "of odometry alone" in said[DeadReckoning].message
    )
