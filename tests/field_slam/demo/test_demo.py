"""The demo of lesson 11: a drive without a hand in it, on two pictures."""

import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from nao_course.cli import app
from nao_course.field_slam import drives
from nao_course.field_slam.demo import drive, film, report
from nao_course.field_slam.kidnapping.recovery import AREA, LEAST_STOPS
from nao_course.field_slam.walk import WalkFrame
from nao_course.geometry import Pose
from nao_course.instructor.authoring.plans import load_solution
from nao_course.robot import Recorder
from nao_course.sim import NAO_V4, Field, Reality, SimulatedNao, render
from nao_course.slam import DeadReckoning, Motion
from tests.field_slam.test_kidnapping import LOOP, START, pictures
from tests.paths import PROJECT, SOLUTIONS


class Blind(DeadReckoning):
    """A student's class that believes every command."""

    def __init__(self, start, odometry, gate, association):
        super().__init__(start)


FUNCTIONS = {
    "color_labels": lambda picture, green, yellow, threshold: np.zeros(picture.shape[:2], np.uint8),
    "white_threshold": lambda mean: 200.0,
    "find_goalposts": lambda labels: np.zeros((0, 2)),
    "measurements_from_pixels": lambda posts, corners, view: [],
    "EkfSlam": Blind,
}


def frames():
    view, picture = NAO_V4.view("bottom", 0.0, -0.54), np.zeros((240, 320, 3), np.uint8)
    yield WalkFrame(None, picture, view, Pose(1.0, 0.0, 0.0))
    yield WalkFrame(Motion(0.5, 0.2), picture, view, Pose(1.4, 0.0, 0.1))


def test_the_demo_says_how_far_off_it_ends_and_no_picture_is_lost_if_the_camera_is_never_calibrated():
    story = drive.run_demo(FUNCTIONS, frames(), ["ekf"])
    found = report.results(story, Field(2012))
    assert found["ekf"]["position"] == pytest.approx(0.1) == found["odometry"]["position"]
    assert found["ekf"]["heading"] == pytest.approx(np.degrees(0.1))
    assert found["way"] == pytest.approx(0.4)
    json.dumps(found, allow_nan=False)
    assert "0.100 m" in report.in_words(story, Field(2012))[1]
    assert len(report.in_words(story, Field(2012))) == 2 and "kidnapping" not in found
    assert film.CARRIED not in [layer.label for layer in film.film_of(story, Field(2012)).layers]
    blind = [replace(frame, calibrated=False) for frame in frames()]
    assert [each.frame for each in drive.see_all(FUNCTIONS, blind)] == blind
    taken = []
    seen = drive.see_all(FUNCTIONS, (taken.append(frame) or frame for frame in frames()))
    next(seen)
    assert len(taken) == 1


def test_a_recording_of_a_real_robot_is_mapped_without_a_truth_and_its_errors_are_left_out(tmp_path):
    nao = SimulatedNao(rng=1)
    recorder = Recorder(tmp_path / "drive", nao)
    for command in (Motion(0.2), Motion(0.0, 1.5), Motion(0.3), Motion(0.0, -1.5), Motion(0.1)):
        recorder.motion(nao.move(command), nao.odometry)
        if nao.odometry.x and not command.turn and command.distance != 0.3:
            recorder.picture(nao.take_picture("bottom"), nao.head)
    recorder.picture(nao.take_picture("top"), nao.head)
    recorder.close()
    frames, number, field = drive.route(1, recording=tmp_path / "drive")
    first, second = frames
    assert number is None and (first.motion, first.pose) == (None, Pose(0.2, 0.0, 0.0))
    assert second.pose == nao.odometry and second.motion == Motion(0.1) and len(second.earlier) == 3
    assert not (first.known or first.calibrated)
    with pytest.raises(ValueError, match="two different drives"):
        drive.route(1, tmp_path, recording=tmp_path / "drive")
    story = drive.run_demo(FUNCTIONS, [first, second], ["ekf"])
    assert np.allclose(story.odometry[-1].as_array(), nao.odometry.as_array())
    assert np.allclose(story.estimates["ekf"][-1].pose.as_array(), nao.odometry.as_array())
    found = report.results(story, field)
    assert "odometry" not in found and "position" not in found["ekf"] and "nees" not in found["ekf"]
    assert "off" not in "".join(report.in_words(story, field))
    film.write_all(story, field, tmp_path / "out")
    data = json.loads((tmp_path / "out" / "film.json").read_text())
    assert data["captions"] == ["After 1 picture.", "After 2 pictures."]
    assert "true path" not in (tmp_path / "out" / "demo.html").read_text()
    (tmp_path / "drive" / "000001.png").unlink()
    with pytest.raises(ValueError, match="is missing"):
        list(drive.route(1, recording=tmp_path / "drive")[0])
    (tmp_path / "drive" / "events.jsonl").write_text("")
    with pytest.raises(ValueError, match="no picture of the bottom camera"):
        list(drive.route(1, recording=tmp_path / "drive")[0])
    with pytest.raises(ValueError, match="is not a recording"):
        drive.route(1, recording=tmp_path)


def rendered(number, offset):
    """Pictures by a camera that looks lower than assumed, as frames that are not calibrated."""
    rng, assumed = np.random.default_rng(5), NAO_V4.view("bottom", 0.0, -0.54)
    for turn in np.linspace(0.0, 1.2, number):
        pose = Pose(1.0, -0.4, float(turn))
        view = replace(assumed, pitch=assumed.pitch + offset)
        pixels, _ = render(Field(2012), pose, view, Reality.lab(3), rng)
        yield WalkFrame(None, pixels, assumed, pose, calibrated=False)


def test_with_the_joint_update_the_ekf_uses_lines_and_its_map_has_only_corners_and_posts():
    solution = load_solution(SOLUTIONS / "11_slam_on_the_field.ipynb")
    functions = FUNCTIONS | {"EkfSlam": solution["EkfSlam"], "GraphSlam": solution["GraphSlam"]}
    pictures = [replace(frame, calibrated=True) for frame in rendered(3, 0.0)]
    pictures[1] = replace(pictures[1], motion=Motion(0.02, 0.6))
    stories = [drive.run_demo(functions, pictures, ["ekf", "graph"], joint) for joint in (False, True)]
    assert [any(hasattr(seen, "lines") for seen in story.seen) for story in stories] == [False, True]
    covariances = [story.estimates["ekf"][-1].covariance for story in stories]
    assert not np.allclose(*covariances)
    assert set(stories[1].estimates["ekf"][-1].kinds) <= {"corner", "post"}


def test_the_report_says_after_how_many_stops_a_robot_that_was_carried_away_was_back(ekf, monkeypatch):
    view, pixels, pose = NAO_V4.view("bottom", 0.0, -0.54), np.zeros((240, 320, 3), np.uint8), START
    there, taken = Pose(2.3, 1.2, 2.4), [WalkFrame(None, pixels, view, pose)]
    for stop in range(2, 25):
        away = stop == 20
        pose = there if away else pose @ LOOP.as_pose()
        taken.append(WalkFrame(Motion() if away else LOOP, pixels, view, pose, carried=away))
        taken.append(WalkFrame(None, pixels, view, pose))
    monkeypatch.setattr(
        drive,
        "see_all",
        lambda _, frames, *__: (drive.Seen(each, pictures(each.pose), 0.0) for each in frames),
    )
    story = drive.run_demo(FUNCTIONS | {"EkfSlam": ekf}, taken, ["ekf"], area=AREA)
    found = report.results(story, Field(2012))
    before = story.poses[story.carried - 1]
    assert found["kidnapping"] == {
        "stop": 20,
        "distance": pytest.approx(np.hypot(before.x - there.x, before.y - there.y)),
        "noticed_after": 2,
        "back_after": 4,
    }
    assert found["ekf"]["position"] < 0.01 < 0.5 < found["odometry"]["position"]
    assert found["way"] == pytest.approx(22 * LOOP.distance)
    assert report.in_words(story, Field(2012))[2:] == report.kidnapping_in_words(story)
    never, always = [0] * len(taken), [True] * len(taken)
    for known, lost, ending in (
        (never, story.lost, "did not notice."),
        (story.noticed, always, "noticed after 2 stops but is still lost."),
        (story.noticed, [*always, False], "noticed after 2 stops but was never within 5 cm again."),
        (story.noticed, story.lost, "noticed after 2 stops and was within 5 cm again after 4."),
        (always, story.lost, "did not notice."),  # but it raised an alarm before
    ):
        (says,) = report.kidnapping_in_words(replace(story, noticed=known, lost=lost))
        assert says.endswith(ending) and "before stop 20. Its EKF" in says
    drawn = film.draw_story(story, Field(2012))
    (arrow,) = drawn.figure.axes[0].texts
    assert np.allclose([arrow.xyann, arrow.xy], [(before.x, before.y), (there.x, there.y)])
    assert "was carried" in drawn.alt
    layer = film.film_of(story, Field(2012)).layers[-1]
    assert layer.label == film.CARRIED and not any(len(each) for each in layer.frames[: story.carried])
    assert np.allclose(layer.frames[story.carried], [(before.x, before.y, there.x, there.y)])


@pytest.mark.parametrize(
    ("given", "instead"),
    [(["--slam", "graph"], "use it with --slam ekf or both"), (["--joint"], "leave out --joint")],
)
def test_a_kidnapping_needs_an_ekf_that_notices_it_and_a_simulated_robot(given, instead, tmp_path):
    done = CliRunner().invoke(app, ["demo", "--kidnap", *given, "--out", str(tmp_path)])
    assert done.exit_code == 1 and instead in " ".join(done.output.split())
    for real in ({"walk": tmp_path}, {"recording": tmp_path}):
        with pytest.raises(ValueError, match="leave out --walk and --recording"):
            drive.route(1, kidnap=True, **real)


def test_the_first_pictures_wait_until_the_camera_is_calibrated():
    offset, views, taken = np.radians(6.0), [], []
    functions = FUNCTIONS | {"measurements_from_pixels": lambda *seen: views.append(seen[2]) or []}
    frames = list(rendered(8, offset))
    seen = drive.see_all(functions, (taken.append(frame) or frame for frame in frames))
    first = next(seen)
    assert 1 < len(taken) < len(frames) and len(views) == 1
    assert [first.frame, *(each.frame for each in seen)] == frames
    assert np.degrees([view.pitch - frames[0].view.pitch for view in views]) == pytest.approx(6.0, abs=3.0)


def test_a_place_where_nothing_can_be_written_is_refused_and_missing_functions_are_named_at_once(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match="--out .*file: nothing can be written there"):
        report.make_folder(tmp_path / "file")
    assert report.make_folder(tmp_path / "a" / "b").is_dir()
    with pytest.raises(ValueError, match="start the demo again") as told:
        drive.demo_functions(["ekf"], tmp_path)
    for name in ("01_hsl_filtering", "02_goalposts", "11_slam_on_the_field"):
        assert str(told.value).count(f"{name}.ipynb is not in your folder {tmp_path.name}") == 1


@pytest.mark.slow
def test_the_solutions_drive_a_short_way_from_the_command_line(tmp_path, monkeypatch):
    monkeypatch.chdir(PROJECT)
    monkeypatch.setattr(drive, "MOVES", 2)
    done = CliRunner().invoke(app, ["demo", "--slam", "both", "--seed", "3", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "demo.json").read_text())
    assert found["pictures"] == 9 and found["ekf"]["landmarks"] >= 2
    assert max(found[name]["position"] for name in ("ekf", "graph")) < 0.1
    files = {"demo.json", "demo.png", "demo.webp", "film.json", "demo.html"}
    assert {path.name for path in tmp_path.iterdir()} == files


@pytest.mark.slow
def test_a_robot_with_the_solutions_is_carried_away_and_finds_its_pose(tmp_path, monkeypatch):
    monkeypatch.chdir(PROJECT)
    monkeypatch.setattr(drive, "MOVES", 2 * LEAST_STOPS)
    done = CliRunner().invoke(app, ["demo", "--slam", "ekf", "--kidnap", "--out", str(tmp_path)])
    assert done.exit_code == 0 and "within 5 cm again" in " ".join(done.output.split())
    found = json.loads((tmp_path / "demo.json").read_text())
    carried = found["kidnapping"]
    assert carried["stop"] == LEAST_STOPS + 1 and carried["distance"] >= drives.CARRIED
    assert found["ekf"]["position"] < 0.05
    assert film.CARRIED in (tmp_path / "demo.html").read_text()


@pytest.mark.slow
def test_figure_film_and_errors_are_written_with_each_chosen_picture(tmp_path):
    story = drive.run_demo(FUNCTIONS, frames(), ["ekf"])
    path = film.write_film(story, Field(2012), tmp_path / "film.webp", frames=2)
    with Image.open(path) as shown:
        assert shown.n_frames == 2
    for path in film.write_all(story, Field(2012), tmp_path / "new"):
        assert path.stat().st_size > 100
