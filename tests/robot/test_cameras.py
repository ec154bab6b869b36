"""The offsets of a robot's cameras: found by the demo on a recorded drive, kept in a file, and used by `RealNao`."""

from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.field_slam.demo import report
from nao_course.robot import RobotError, read_offsets, write_offsets
from tests.robot.emulated import connected


def test_the_views_of_a_robot_have_the_offsets_of_its_file(tmp_path):
    path = write_offsets(tmp_path / "robot.toml", {"bottom": (0.12, -0.01)})
    write_offsets(path, {"top": (0.05, 0.0)})
    assert read_offsets(path) == {"bottom": (0.12, -0.01), "top": (0.05, 0.0)}
    with connected() as (_, plain), connected(cameras=path) as (_, corrected):
        for camera, offset in read_offsets(path).items():
            before, after = plain.view(camera), corrected.view(camera)
            moved = np.subtract((after.pitch, after.roll), (before.pitch, before.roll))
            assert np.allclose(moved, offset, atol=np.radians(2))  # the sensor's noise


def test_what_the_demo_finds_is_kept_if_the_pictures_show_it(tmp_path):
    path = tmp_path / "cameras.toml"
    calibration = SimpleNamespace(
        mean=np.array([0.12, 0.01]), covariance=np.diag([0.003, 0.003]) ** 2, is_certain=False
    )
    story = SimpleNamespace(calibration=calibration)
    assert "do not show" in report.keep_calibration(story, path) and not path.exists()
    calibration.is_certain = True
    assert "looks 6.9 ± 0.2° lower" in report.keep_calibration(story, path)
    assert read_offsets(path) == {"bottom": (0.12, 0.01)}


@pytest.mark.parametrize(
    "text",
    ["[left]\npitch = 1.0\nroll = 0.0", "[top]\npitch = nan\nroll = 0", "top = 1", "[top]\npitch = 1", "["],
)
def test_another_file_is_refused_by_its_name(tmp_path, text):
    path = tmp_path / "robot.toml"
    path.write_text(text)
    with pytest.raises(RobotError, match=r"robot\.toml must have a table"):
        read_offsets(path)
    with pytest.raises(RobotError, match="must have a table"):
        read_offsets(tmp_path)
