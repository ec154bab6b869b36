"""The simulated robot: what it does, what it believes, and what it must not know."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim import (
    Field,
    OdometryNoise,
    Reality,
    SensorNoise,
    SimulatedNao,
    TorsoTilt,
    Truth,
    repeat_drive,
)
from nao_course.sim import nao as module
from nao_course.sim.render import render
from nao_course.slam import Motion

EXACT = {
    "odometry_noise": OdometryNoise(0, 0, 0, 0),
    "tilt": TorsoTilt(0, 0),
    "sensor_noise": SensorNoise(0, 0),
    "reality": Reality.clean(),
}


def test_without_noise_odometry_is_the_truth_and_sense_gives_bearing_and_range_from_right_to_left():
    nao = SimulatedNao(pose=Pose(0.2, -0.5, 0.4), **EXACT)
    truth = Truth(nao)
    for command, value in [("walk", 0.6), ("turn", 0.9), ("walk", 0.4), ("turn", -2.0), ("walk", -0.3)]:
        getattr(nao, command)(value)
    believed = truth.odometry_start @ nao.odometry
    assert np.allclose(believed.as_array(), truth.pose.as_array())
    assert len(truth.path) == 6
    nao = SimulatedNao(pose=Pose(0.4, 0.3, -0.1), **EXACT)
    measured = nao.sense(max_range=10)
    field, pose = nao.field, Truth(nao).pose
    points = np.array([(m.x, m.y) for m in field.landmarks if m.kind != "cross"])
    kinds = ["post" if m.kind == "post" else "corner" for m in field.landmarks if m.kind != "cross"]
    local = pose.to_local(points)
    assert len(measured) >= 5
    for each in measured:
        seen = each.range * np.array([np.cos(each.bearing), np.sin(each.bearing)])
        errors = np.hypot(*(local - seen).T)
        assert errors.min() < 1e-9
        assert kinds[errors.argmin()] == each.kind
    bearings = [m.bearing for m in SimulatedNao(pose=Pose(0.8, 0, 0)).sense()]
    assert bearings == sorted(bearings)


@pytest.mark.parametrize("motion", [Motion(0.8, 0.5), Motion(0.0, 1.2), Motion(-0.5, 0.0)])
def test_odometry_scatters_in_the_robot_frame_as_its_covariance_says(motion):
    heading = 0.7
    noise = OdometryNoise()
    ends = []
    for seed in range(1500):
        nao = SimulatedNao(pose=Pose(1, 0, heading), rng=seed, odometry_noise=noise)
        nao.move(motion)
        ends.append((Pose(1, 0, heading).inverse() @ Truth(nao).pose).as_array())
    errors = np.array(ends) - (motion.distance, 0, motion.turn)
    expected = np.sqrt(np.diag(noise.covariance(motion)))
    assert np.allclose(errors.std(axis=0), expected, rtol=0.08, atol=1e-12)
    assert np.abs(errors.mean(axis=0)).max() < 0.01


def test_the_covariance_of_a_motion_grows_with_the_way_and_what_a_post_hides_is_not_measured():
    noise = OdometryNoise(along=0.06, across=0.04, turn=0.08, turn_per_turn=0.12)
    assert np.allclose(noise.covariance(Motion(2.0, 0.0)), np.diag([0.06**2, 0.04**2, 0.08**2]) * 2)
    assert np.allclose(noise.covariance(Motion(0.0, -0.5)), np.diag([0, 0, 0.12**2]) * 0.5)
    draws = np.array([[0.0, -1e3], [0.0, -1.0]])
    ranges = SensorNoise(0.0, 0.1).disturbed(np.array([[0.0, 2.0], [0.0, 2.0]]), draws)[:, 1]
    assert ranges == pytest.approx([0.2, 1.8])  # m: an error never removes more than nine tenths of the range
    post, corner = np.array([3.0, 0.7]), np.array([3.0, 1.1])
    eye = post + (post - corner) / np.linalg.norm(post - corner)
    nao = SimulatedNao(pose=Pose(eye[0], eye[1], np.pi / 2), **EXACT)
    nao.look(0.0, np.radians(-31))
    ahead = [round(m.range, 2) for m in nao.sense() if abs(m.bearing) < 0.005]
    assert 1.0 in ahead and 1.4 not in ahead  # the post itself, and the corner behind it


@pytest.mark.parametrize("x", [0.5, 1.0, 2.0])
def test_measurements_scatter_about_the_truth_as_their_covariance_says(x):
    noise = SensorNoise(bearing=0.03, range_fraction=0.08)
    robot = Pose(x, 0.6, 0.0)
    exact = SimulatedNao(pose=robot, **EXACT).sense(max_range=10)
    nearest, second = sorted(exact, key=lambda each: each.range)[:2]
    only = (nearest.range + second.range) / 2
    nao = SimulatedNao(pose=robot, rng=3, **(EXACT | {"sensor_noise": noise}))
    seen = np.array([[(m.bearing, m.range) for m in nao.sense(max_range=only)] for _ in range(2000)])[:, 0]
    wanted = noise.covariance(nearest)
    assert np.allclose(np.diag(wanted), [0.03**2, (0.08 * nearest.range) ** 2])  # rad^2, m^2
    assert np.diag(np.cov(seen.T)) == pytest.approx(np.diag(wanted), rel=0.12)
    assert abs(np.corrcoef(seen.T)[0, 1]) < 0.1 and wanted[0, 1] == wanted[1, 0] == 0
    errors = seen.mean(axis=0) - (nearest.bearing, nearest.range)
    assert (np.abs(errors) < 4 * np.sqrt(np.diag(wanted) / len(seen))).all()


@pytest.mark.parametrize(("distance", "turn"), [(1.0, 0.0), (-4.0, 0.0), (0.0, 1.0), (2.0, -0.5)])
def test_a_walk_scatters_by_the_stated_metres_and_radians_after_one_metre_and_one_radian(distance, turn):
    noise = OdometryNoise(along=0.06, across=0.04, turn=0.08, turn_per_turn=0.12)
    ends = repeat_drive([Motion(distance, turn)], 4000, np.random.default_rng(8), noise)[:, 1]
    way, turned = abs(distance), abs(turn)
    wanted = [0.06 * way**0.5, 0.04 * way**0.5, (0.08**2 * way + 0.12**2 * turned) ** 0.5]  # m, m, rad
    assert ends.std(axis=0) == pytest.approx(wanted, rel=0.05)
    assert np.sqrt(np.diag(noise.covariance(Motion(distance, turn)))) == pytest.approx(wanted)
    steps = [Motion(distance / 10, turn / 10)] * 10
    many = repeat_drive(steps, 4000, np.random.default_rng(8), OdometryNoise(0.06, 0.04, 0.0, 0.0))[:, -1]
    if not turn:
        assert many[:, :2].std(axis=0) == pytest.approx(wanted[:2], rel=0.08)


def test_twenty_robots_drive_as_one_does(rng):
    commands = [Motion(0.5), Motion(0, 0.6), Motion(0.5)]
    ends = []
    for seed in range(1500):
        nao = SimulatedNao(pose=Pose(0, 0, 0), rng=seed)
        for motion in commands:
            nao.move(motion)
        ends.append(Truth(nao).pose.as_array())
    together = repeat_drive(commands, 4000, rng)[:, -1]
    assert np.allclose(np.std(ends, axis=0), together.std(axis=0), rtol=0.1)
    assert np.allclose(np.mean(ends, axis=0), together.mean(axis=0), atol=0.02)


def test_the_robot_does_not_know_how_its_body_tilts_by_the_stated_deviation():
    nao = SimulatedNao(rng=3)
    pictures = [nao.take_picture() for _ in range(2)]
    assert pictures[0].view == pictures[1].view
    assert pictures[0].view.roll == 0
    true_view = Truth(nao).picture.view
    assert true_view.roll != 0
    assert true_view.pitch != pictures[1].view.pitch
    nao = SimulatedNao(rng=0, tilt=TorsoTilt(0.02, 0.01))
    views = [nao._true_view("bottom", (320, 240)) for _ in range(3000)]
    assert np.std([v.pitch for v in views]) == pytest.approx(0.02, rel=0.05)
    # The head looks down, so only the cosine of its pitch turns a lean into roll.
    assert np.std([v.roll for v in views]) == pytest.approx(0.01 * np.cos(nao.view().pitch), rel=0.1)


def test_nothing_public_about_the_robot_or_its_pictures_reveals_the_truth():
    nao = SimulatedNao(pose=Pose(1.234, 0.567, 0.891), rng=4)
    nao.walk(0.3)
    picture = nao.take_picture()
    hidden = (Truth(nao).pose, Truth(nao).picture, *Truth(nao).path)
    for thing in (nao, picture, picture.view):
        public = {name: getattr(thing, name) for name in dir(thing) if not name.startswith("_")}
        assert not any(value is secret for value in public.values() for secret in hidden)
        assert "1.2" not in repr(thing) and "0.56" not in repr(thing)
        assert not {"pose", "truth", "labels", "landmarks", "path"} & set(public)


def test_the_same_seed_gives_the_same_day_and_what_is_measured_aside_does_not_change_the_drive():
    def day(seed):
        nao = SimulatedNao(rng=seed)
        nao.walk(0.5)
        nao.turn(0.3)
        return nao.take_picture().pixels.tobytes(), nao.sense(), Truth(nao).pose

    assert day(7) == day(7) == day(np.random.default_rng(7))
    assert day(7) != day(8)
    quiet, watched = SimulatedNao(rng=5), SimulatedNao(rng=5)
    with watched.aside(np.random.default_rng(1)):
        watched.take_picture("top")
        aside = watched.sense()
    assert aside != quiet.sense() and watched.sense() == SimulatedNao(rng=5).sense()
    assert watched.walk(1.0) == quiet.walk(1.0) and Truth(watched).pose == Truth(quiet).pose


def test_the_robot_stops_at_the_edge_of_the_carpet_and_a_moved_field_takes_it_along():
    nao = SimulatedNao(**EXACT)
    nao.walk(9.0)
    assert Truth(nao).pose.x == pytest.approx(3.7)
    assert nao.odometry.x == 9.0
    field = Field(pose=Pose(10, 5, 1.0))
    nao = SimulatedNao(field, **EXACT)
    assert Truth(nao).pose == field.pose
    assert nao.take_picture().pixels.tobytes() == SimulatedNao(**EXACT).take_picture().pixels.tobytes()


@pytest.mark.slow
def test_a_picture_taken_while_walking_is_smeared_by_a_sway_about_all_three_axes(monkeypatch):
    def sharpness(walking, motion=1.0):
        nao = SimulatedNao(**(EXACT | {"reality": replace(Reality.clean(), motion=motion)}))
        pictures = [nao.take_picture(walking=walking).pixels.astype(float) for _ in range(5)]
        return np.mean([np.abs(np.diff(p, axis=0)).max(axis=0).mean() for p in pictures])

    assert sharpness(True) < 0.95 * sharpness(False)
    assert sharpness(True, motion=0.0) == sharpness(False)
    sways = []
    monkeypatch.setattr(module, "render", lambda *given: (sways.append(given[-1]), None)[1] or render(*given))
    nao = SimulatedNao(rng=1)
    for _ in range(200):
        nao.take_picture(size=(16, 12), walking=True)
    scale = nao.reality.motion
    assert np.std(sways, axis=0) == pytest.approx(scale * np.array([0.010, 0.015, 0.012]), rel=0.2)


@pytest.mark.parametrize(
    ("do", "says"),
    [
        (lambda nao: SimulatedNao(pose=Pose(np.nan, 0, 0)), "Pose: x .m. must be a finite number, got nan"),
        (lambda nao: SimulatedNao(pose=(0, 0, 0)), r"pose must be a Pose\(x, y, theta\)"),
        (lambda nao: SimulatedNao(pose=Pose(30, 0, 0)), "on the carpet"),
        (lambda nao: SimulatedNao(rng="seven"), "rng must be"),
        (lambda nao: Truth(nao).place(Pose(30, 0, 0)), "on the carpet"),
        (lambda nao: nao.take_picture(size=(0, 0)), r"size must be \(width, height\)"),
        (lambda nao: nao.take_picture("left"), r"camera must be one of \['bottom', 'top'\], got 'left'"),
        (lambda nao: nao.look(np.inf, 0), "head yaw"),
        (lambda nao: nao.sense(max_range=0), "max_range must be positive"),
        (lambda nao: nao.look(0, 1.0), r"head pitch must be within .* got 1.000"),
        (lambda nao: nao.walk(np.nan), r"distance \(m\) must be a finite number"),
        (lambda nao: nao.walk(50), "within -10..10 m"),
        (lambda nao: nao.turn(90), r"turn\(np.radians\(90\)\)"),
        (lambda nao: TorsoTilt(pitch=-1), "TorsoTilt: pitch must be 0 .none. or more"),
        (lambda nao: OdometryNoise(along=np.nan), "OdometryNoise: along must be a finite number"),
    ],
)
def test_what_cannot_be_done_is_refused_with_what_was_expected(do, says):
    nao = SimulatedNao()
    with pytest.raises(ValueError, match=says):
        do(nao)
    assert nao.odometry == Pose() and nao.head == SimulatedNao().head
