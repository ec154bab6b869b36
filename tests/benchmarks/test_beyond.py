"""The measurements of lesson 12: what they measure by, and that what was recorded is what they find."""

import numpy as np
import pytest

from benchmarks.beyond.beyond_cameras import COUNT, SEED
from benchmarks.beyond.beyond_exploring import MOVES as ROOM_MOVES
from benchmarks.beyond.beyond_moves import saving
from benchmarks.beyond.beyond_particles import QuickFastSlam
from nao_course.instructor.authoring.plans import load_solution
from nao_course.lessons.beyond import recorded
from nao_course.lessons.beyond.exploring import explore, nearest_frontier
from nao_course.lessons.beyond.figures import START, lap
from nao_course.lessons.beyond.particles import FastSlam, run_fast_slam
from nao_course.lessons.beyond.planning import journey
from nao_course.lessons.beyond.two_cameras import measure_again
from tests.paths import SOLUTIONS


@pytest.fixture(scope="module")
def own():
    return load_solution(SOLUTIONS / "12_beyond.ipynb")


def test_particles_all_at_once_do_what_the_lessons_function_does_one_by_one(own):
    functions = own["update_particle_landmark"], own["resample"], 20
    both = [
        run_fast_slam(kind(START, *functions, np.random.default_rng(3)), lap(3, 12))
        for kind in (FastSlam, QuickFastSlam)
    ]
    assert np.allclose(both[0].paths, both[1].paths, atol=1e-9)
    assert np.allclose(both[0].errors, both[1].errors, atol=1e-9)
    assert np.array_equal(both[0].ancestors, both[1].ancestors)


def test_what_is_saved_is_nothing_between_equals_and_half_where_all_is_half():
    values = np.linspace(0.1, 0.3, 30).tolist()
    part, low, high = saving(values, values)
    assert part == low == high == 0  # the same drives, in pairs
    assert saving((np.array(values) / 2).tolist(), values)[0] == pytest.approx(0.5)


def test_a_recorded_journey_is_what_the_solution_drives(own):
    seven = load_solution(SOLUTIONS / "07_ekf_slam.ipynb")
    ekf = [seven[name] for name in ("predict", "update_landmarks", "add_landmark")]
    end = journey(own["choose_move"], ekf, 3)
    of = recorded.read(recorded.MOVES)["variants"]["smallest variance"]
    assert end.sigmas[-1] == pytest.approx(of["sigma"][3], abs=1e-3)
    assert end.errors[-1] == pytest.approx(of["error"][3], abs=1e-3)


def test_a_recorded_room_is_what_the_solution_explores(own):
    enough = recorded.read(recorded.EXPLORING)["variants"]["nearest frontier"]["enough"]
    rule = nearest_frontier(own["find_frontiers"])
    parts = [known.part for known in explore(own["travel_steps"], rule, 2, ROOM_MOVES)]
    assert int(np.argmax(np.array(parts) >= 0.9)) == enough[2]


@pytest.mark.slow
def test_a_recorded_distance_is_what_the_cameras_measure(own):
    pixel_to_ground = load_solution(SOLUTIONS / "04_distance.ipynb")["pixel_to_ground"]
    distances = measure_again(own["intersect_rays"], pixel_to_ground, 2.0, (640, 480), count=COUNT, seed=SEED)
    rows = recorded.read(recorded.CAMERAS)["rows"]
    (row,) = (each for each in rows if (each["width"], each["distance"]) == (640, 2))
    assert distances.sigmas == pytest.approx((row["one"], row["both"]), abs=1e-3)
