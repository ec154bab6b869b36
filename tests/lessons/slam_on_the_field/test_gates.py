"""Gates: what becomes of a measurement is counted right, and the lesson says what thirty recorded drives say."""

import json
import re

import numpy as np
import pytest

from benchmarks import RESULTS
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.observation import observation
from nao_course.geometry import Pose
from nao_course.lessons.slam_on_the_field import gates
from nao_course.lessons.slam_on_the_field.associating import RUNS
from nao_course.lessons.slam_on_the_field.panel import LANDMARK_SIGMA
from nao_course.lessons.slam_on_the_field.worlds import KINDS, DrawnDrive, association_problem, drawn_drive
from nao_course.slam import DeadReckoning, Measurement
from tests.lessons.every import quotes, text

NUMBERS = [[0, 1], [1, 2, -1]]  # by which a scripted filter names the measurements of two pictures
ORIGINS = ((4, 7), (4, 7, 8))


class Scripted(DeadReckoning):
    """A filter that follows its commands exactly and associates measurements by a script."""

    def __init__(self, start, odometry, gate, association=None):
        super().__init__(start)
        self.pictures = iter(NUMBERS)

    def observe(self, measurements):
        super().observe(measurements)
        self.indices = np.array(next(self.pictures))


def two_pictures():
    seen = [
        observation([Measurement(0.1 * i, 1.0 + i, "corner") for i in range(len(each))]) for each in NUMBERS
    ]
    start = Pose(1.0, 0.0, 0.0)
    return DrawnDrive(start, [(None, each) for each in seen], np.tile(start.as_array(), (2, 1)), ORIGINS)


def test_a_measurement_is_right_wrong_again_or_left_out():
    watched = gates.watch(Scripted, two_pictures(), 3.0)
    # First 4 and 7 come onto the map; then 4 is taken for 7, 7 is put on the map again, and 8 is left out.
    assert dict(watched.fates) == {"right": 2, "wrong": 1, "again": 1, "left out": 1}
    assert gates.shares_of([watched, watched]) == {"right": 0.4, "wrong": 0.2, "again": 0.2, "left out": 0.2}
    assert watched.outcome.off == 0


def test_thirty_drives_are_recorded_for_every_gate_and_joint_compatibility_is_right_more_often():
    rows = gates.recorded()
    assert {(row["way"], row["gate"]) for row in rows} == {
        (way, gate) for way in (gates.NEAREST, gates.JOINTLY) for gate in gates.GATES
    }
    assert {len(row[each]) for row in rows for each in ("off", "nees", "landmarks")} == {30}
    assert all(sum(row["shares"].values()) == pytest.approx(1, abs=1e-3) for row in rows)
    drawn = gates.draw_associations()
    assert "30 drives" in drawn.alt and "Gate 3, joint compatibility" in drawn.alt
    drives = json.loads((RESULTS / "association.json").read_text(encoding="utf-8"))["drives"]
    tight, wide = (drives[f"nearest neighbour, gate {gate}"] for gate in (1, 10))
    assert gates.recorded_landmarks(gate=1) == pytest.approx(tight["landmarks"], abs=0.05)
    assert gates.recorded_wrong(gate=10) == pytest.approx(wide["wrong %"], abs=0.05)
    right = {(row["way"], row["gate"]): row["shares"]["right"] for row in gates.recorded()}
    assert right[gates.JOINTLY, 3.0] > right[gates.NEAREST, 3.0] + 0.05
    assert right[gates.JOINTLY, 10.0] > right[gates.NEAREST, 10.0] + 0.05


def section(heading: str) -> str:
    return re.split(r"^## ", text("11").partition(f"\n## {heading}\n")[2], flags=re.MULTILINE)[0]


def test_the_lesson_states_what_was_recorded_of_drives_and_single_pictures():
    found = json.loads((RESULTS / "association.json").read_text(encoding="utf-8"))
    tight, usual, wide = (found["drives"][f"nearest neighbour, gate {gate}"] for gate in (1, 3, 10))
    usual_j, wide_j = (found["drives"][f"joint compatibility, gate {gate}"] for gate in (3, 10))
    percent = tight["left out %"], tight["again %"], wide["wrong %"], usual["right %"], usual_j["right %"]
    quotes(
        section("Which gate?"),
        *(f"{each:.0f} %" for each in percent),
        f"{tight['landmarks']:.0f} landmarks",
        *(f"{each['off cm']:.0f} cm off" for each in (tight, wide)),
        f"{usual['> 10 cm']} of 30",
        f"{usual_j['> 10 cm']} of 30",
        f"{wide_j['> 50 cm']} of 30",
    )


def test_the_text_says_how_many_matches_are_right_in_the_panels_thirty_pictures(own):
    def right(heading, position=0.15, gate=3.0):
        pictures = [
            association_problem(seed, position, np.radians(heading), LANDMARK_SIGMA) for seed in range(RUNS)
        ]
        given = [
            (each.state, each.covariance, list(KINDS), each.observation, each.observation.covariance)
            for each in pictures
        ]
        return np.concatenate(
            [
                own["associate"](*of, gate) == np.array(each.origins)
                for of, each in zip(given, pictures, strict=True)
            ]
        )

    told = section("Which landmark is it?")
    shares = [100 * right(heading).mean() for heading in (0.5, 1, 2, 3, 5, 8, 10)]
    near = f"{100 * right(2, position=0.01).mean():.0f} % do at 2°"
    quotes(told, f"between {min(shares):.0f} and {max(shares):.0f} % get their own landmark", near)
    for heading in (8, 2):
        usual, tight = right(heading), right(heading, gate=1.0)
        quotes(told, f"{100 * (1 - (tight & usual).sum() / usual.sum()):.0f} % at {heading}°")


@pytest.mark.slow
def test_the_record_is_what_the_solution_does(own):
    recorded = {(row["way"], row["gate"]): row for row in gates.recorded()}
    for way, match in ((gates.NEAREST, None), (gates.JOINTLY, associate_jointly)):
        drives = (drawn_drive(seed, gates.MOVES) for seed in (400, 401))
        off = [gates.watch(own["EkfSlam"], drive, 3.0, match).outcome.off for drive in drives]
        assert recorded[way, 3.0]["off"][:2] == pytest.approx(off, abs=2e-4)
