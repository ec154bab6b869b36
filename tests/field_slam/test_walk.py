"""The real walk as a drive: headings from marked points, odometry that errs as it says, and where it is read from."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from benchmarks import RESULTS
from nao_course.datasets import AnnotatedPoint, RealPicture
from nao_course.field_slam import walk
from nao_course.field_slam.demo import drive as demo
from nao_course.field_slam.known_shapes.calibration import CameraCalibration
from nao_course.geometry import Pose
from tests.paths import PROJECT

MARKS = {"X": (0.0, 0.6), "T": (3.0, 1.1), "L": (2.4, -1.1), "post_foot": (3.0, 0.7)}


def picture(pose=Pose(-1.0, 0.0, 0.0), kinds=(), turned=0.0):
    """A picture of the walk in which points are marked where a robot that is turned sees them."""
    bare = RealPicture("walk_001.png", Path("walk_001.png"), pose, 0.0, -0.55, ())
    view = walk.walk_view(bare)
    points = []
    for kind in kinds:
        u, v = view.project([MARKS[kind]], replace(pose, theta=turned))[0].tolist()
        points.append(AnnotatedPoint(kind, u, v))
    return replace(bare, points=tuple(points))


@pytest.mark.parametrize("degrees", [-4.4, 0.1, 3.0])
def test_marked_points_tell_where_a_robot_looked_although_one_is_wrong(degrees):
    seen = picture(kinds=tuple(MARKS), turned=np.radians(degrees))
    wrong = replace(seen, points=(*seen.points, AnnotatedPoint("X", 10.0, 230.0)))
    for each, within in ((seen, 0.1), (wrong, 0.3)):
        found = walk.marked_heading(each, walk.walk_view(each), each.pose)
        assert np.degrees(found) == pytest.approx(degrees, abs=within)


def test_without_a_marked_point_the_heading_is_as_written_and_the_walk_is_read_from_its_own_folder_or_above(
    tmp_path, monkeypatch
):
    high = replace(picture(), points=(AnnotatedPoint("post_top", 100.0, 20.0),))
    for seen in (picture(), high):
        assert walk.marked_heading(seen, walk.walk_view(seen), Pose(0.0, 0.0, 0.3)) == 0.3
    asked = []
    monkeypatch.setattr(demo, "read_pictures", lambda name, folder: asked.append((name, folder)) or ())
    own = tmp_path / "amsterdam_2013" / "straightwalk"
    own.mkdir(parents=True)
    (own / "annotations.json").write_text("[]", encoding="utf-8")
    for folder in (tmp_path, own):
        demo.route(0, folder)
    assert asked == [("straightwalk", tmp_path.resolve())] * 2


def test_odometry_is_the_true_steps_with_the_errors_it_states_and_a_step_back_is_negative(monkeypatch):
    monkeypatch.setattr(RealPicture, "pixels", np.zeros((240, 320, 3), np.uint8))
    pictures = [replace(picture(Pose(-2.8 + 0.2 * i, 0.0, 0.0)), name=str(i)) for i in range(10)]
    walks = [list(walk.real_walk(pictures, seed)) for seed in range(60)]
    assert walks[0][0].motion is None and walks[0][0].pose.x == pytest.approx(-3.0)
    way = np.array([[sight.motion.distance for sight in each[1:]] for each in walks])
    turn = np.array([[sight.motion.turn for sight in each[1:]] for each in walks])
    steps = np.full(9, 0.2)
    steps[walk.BEFORE_THE_GAP - 1] = 0.4  # the stop without a picture
    assert way.mean(axis=0) == pytest.approx(steps, abs=0.02)
    assert (way - steps)[:, :6].std() == pytest.approx(0.021, rel=0.15)
    assert np.degrees(turn.std()) == pytest.approx(1.0, rel=0.15)
    pictures = [replace(picture(Pose(-0.2 * i, 0.0, 0.0)), name=str(i)) for i in range(5)]
    assert all(-0.3 < sight.motion.distance < -0.1 for sight in [*walk.real_walk(pictures, 1)][1:])


def test_lesson_and_docs_state_what_the_walk_says():
    found = json.loads((RESULTS / "field_walk.json").read_text(encoding="utf-8"))
    of = found["variants"]
    text = (PROJECT / "solutions" / "11_slam_on_the_field.md").read_text(encoding="utf-8")
    off = {name: f"{100 * of[name]['position']:.0f} cm" for name in ("odometry alone", "EKF", "graph")}
    own_pitch = found["own estimate of the offset, degrees"]["walk"]["pitch"]
    shown = {name: f"{100 * position:.0f}" for name, position in found["shown"].items()}
    for words in (
        f"ends {shown['odometry alone']} centimetres off",
        f"end {shown['EKF']} and {shown['graph']} centimetres off",
        f"odometry ends {off['odometry alone']} off (median), the filter {off['EKF']} and the graph {off['graph']}",
        f"the filter's error is {100 * of['EKF']['across rms']:.0f} cm",
        f"Along the path it is {100 * of['EKF']['along rms']:.0f} cm, hardly better than odometry's "
        f"{100 * of['odometry alone']['along rms']:.0f} cm",
        f"The last six pictures show none, so the heading ends {of['EKF']['heading rms']:.1f}° off",
        f"its camera's offset on the way ({own_pitch:.1f}° in pitch)",
    ):
        assert words in text, words
    assert found["pictures with a measurement"] == 30 - 6
    docs = (PROJECT / "docs" / "real_data.md").read_text(encoding="utf-8")
    keys = ("position", "position 95 %", "position worst", "along rms", "across rms")
    degrees = ("heading rms", "heading rms after the last measurement")
    for name, row in of.items():
        values = [*(f"{row[key]:.2f}" for key in keys), *(f"{row[key]:.1f}" for key in degrees)]
        line = f"| {name} | {' | '.join(values)} |"
        assert line in docs, line
    for name, row in found["bound"].items():
        *metres, heading = row.values()
        assert f"| {name} | {' | '.join(f'{value:.3f}' for value in metres)} | {heading:.1f} |" in docs, name
    (median, most, *_, heading), (*_, edge) = (row.values() for row in [*found["bound"].values()][:2])
    results = (PROJECT / "docs" / "results.md").read_text(encoding="utf-8")
    assert f"{100 * median:.1f} cm, {100 * most:.1f} cm and {heading:.1f}°" in results
    assert f"the bound of the heading is {edge:.1f}°" in results
    assert f"a standard deviation of {found['standard deviation of these headings, degrees']:.1f}°" in docs
    waiting = found["first half, range of the EKF's median error over assumed views"]
    ends = [waiting[f"first pictures {when}"] for when in ("at once", "wait")]
    at_once, waited = (f"{100 * low:.0f} to {100 * high:.0f} cm" for low, high in ends)
    assert f"15 pictures is then {at_once}. If the first pictures wait, it is {waited}." in docs
    for name, own in found["own estimate of the offset, degrees"].items():
        pitch, roll = (f"{own[axis]:.1f} ± {own[f'{axis} sigma']:.1f}" for axis in ("pitch", "roll"))
        assert f"| {name} | {pitch} | {roll} |" in docs, name
    nees = [f"{of[name]['NEES median']:.1f}" for name in ("EKF", "graph")]
    assert f"NEES is {nees[0]} (EKF) and {nees[1]} (graph)" in docs


@pytest.mark.slow
def test_the_camera_looks_as_low_as_the_walks_first_picture_says(data_dir, monkeypatch):
    from benchmarks.field import field_walk
    from nao_course.datasets import read_pictures

    offset = field_walk.marked_offset(read_pictures("straightwalk", data_dir))
    assert np.degrees(walk.PITCH_OFFSET) == pytest.approx(offset, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("assumed", [(0.0, 0.0), (4.0, 0.0), (-1.0, 3.0), (10.0, -3.0)])
def test_real_pictures_calibrate_the_camera_from_any_assumed_view(assumed, data_dir):
    """The walk's first half; the expected offset follows from marked points."""
    from nao_course.datasets import read_pictures

    pitch, roll = np.radians(assumed)
    functions = demo.demo_functions((), PROJECT / "solutions")
    own = CameraCalibration()
    frames = (
        replace(frame, view=replace(frame.view, pitch=frame.view.pitch + pitch, roll=frame.view.roll + roll))
        for frame in walk.real_walk(read_pictures("straightwalk", data_dir)[:15], 0)
    )
    assert len(list(demo.see_all(functions, frames, own))) == 15
    error = own.mean - (walk.PITCH_OFFSET - pitch, -roll)
    assert error @ np.linalg.solve(own.covariance, error) < chi2.ppf(0.99, 2)
