"""What holds for every robot: simulated, real (emulated behind the real protocol) and recorded."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.robot import RecordedNao, Robot
from nao_course.sim import SimulatedNao, TorsoTilt
from nao_course.slam import Motion
from tests.robot.emulated import connected


def drive(nao):
    """Drive as the recording does."""
    yield nao.take_picture("bottom")
    yield nao.walk(0.2)
    yield nao.turn(0.5)
    nao.look(0.3, -0.2)
    yield nao.take_picture("top")
    yield nao.move(Motion(-0.1, 0.0))


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drive") / "recording"
    with connected(record=folder) as (_, nao):
        list(drive(nao))
    return folder


@pytest.fixture(params=["simulated", "real", "recorded"])
def nao(request):
    if request.param == "simulated":
        yield SimulatedNao(rng=1, tilt=TorsoTilt(0.0, 0.0))
    elif request.param == "real":
        with connected() as (_, real):
            yield real
    else:
        yield RecordedNao(request.getfixturevalue("recording"))


def test_a_drive_gives_pictures_with_views_motions_as_commanded_and_an_odometry_of_their_sum(nao):
    assert isinstance(nao, Robot)
    assert nao.odometry == Pose() and nao.odometry_path == (Pose(),)
    first, walked, turned, second, back = drive(nao)
    assert (walked, turned, back) == (Motion(0.2, 0.0), Motion(0.0, 0.5), Motion(-0.1, 0.0))
    expected = Pose(0.2, 0.0, 0.5) @ Pose(-0.1, 0.0, 0.0)
    assert np.allclose(nao.odometry.as_array(), expected.as_array(), atol=1e-6)
    assert len(nao.odometry_path) == 4
    assert nao.head == pytest.approx((0.3, -0.2))
    for picture, camera, yaw in ((first, "bottom", 0.0), (second, "top", 0.3)):
        assert picture.camera == camera and picture.pixels.shape == (240, 320, 3)
        assert picture.pixels.std() > 10 and not np.array_equal(
            picture.pixels[..., 0], picture.pixels[..., 2]
        )
        assert picture.view.size == (320, 240)
        assert picture.view.yaw == pytest.approx(yaw, abs=np.radians(3))
        assert 0.4 < picture.view.height < 0.6
    nao.stop()


def test_what_no_robot_has_is_refused(nao):
    with pytest.raises(ValueError, match="camera must be one of"):
        nao.take_picture("left")
    with pytest.raises(ValueError, match="head yaw must be within"):
        nao.look(3.0, 0.0)
    with pytest.raises(ValueError, match="camera must be one of"):
        nao.view("left")
