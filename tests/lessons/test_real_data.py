"""What the lessons say of a real NAO's walk and of a real building is what their figures show."""

import numpy as np
import pytest

from nao_course.datasets import intel_graph
from nao_course.datasets.real_walk import FIELD, measured_posts
from nao_course.lessons.beyond import draw_real_finding
from nao_course.lessons.beyond.figures import FOUND, REAL_SHOWN
from nao_course.lessons.beyond.particles import find_itself
from nao_course.lessons.ekf_derivations import draw_real_measurements
from nao_course.lessons.ekf_slam import draw_real_map
from nao_course.lessons.graph_slam import draw_real_building
from nao_course.lessons.localization.drives import follow
from nao_course.lessons.localization.real_walk import START_SIGMAS, WRONG_START, draw_real_walk, recorded_walk
from nao_course.lessons.meet_the_nao import draw_real_posts
from tests.lessons.every import own, quotes, text


def test_real_posts_are_measured_too_near_but_hardly_to_the_side():
    alt = draw_real_posts().alt
    assert "47 measurements" in alt and "-0.66 to 0.17 m off, and across it 0.13 m at most" in alt
    quotes(text("00"), "47 times", "up to 0.66 m off", "across it 0.13 m at most")


def test_the_measured_posts_are_two_clusters_which_are_too_near():
    posts, cluster_points = measured_posts(), own("02")["cluster_points"]
    assert posts.shape == (47, 2)
    found = [cluster_points(posts, distance) for distance in (0.05, 0.1, 0.15, 0.5, 1.1, 1.2)]
    assert [len(each) for each in found] == [12, 7, 2, 2, 2, 1]
    for each in found[2:5]:
        near, far = each[np.argsort(each[:, 1])]
        assert near == pytest.approx((2.8, -0.7), abs=0.05) and far == pytest.approx((2.8, 0.7), abs=0.05)
    quotes(text("02"), "measured them 47 times", "(3.0, ±0.7) m", "From 0.15 to 1.1 m", "0.2 m too near")


@pytest.mark.slow
def test_particles_of_the_real_walk_end_at_the_robot_or_opposite_it():
    weigh, resample = own("12")["weigh"], own("12")["resample"]
    alt = draw_real_finding(weigh, resample).alt
    assert "after 16 observations 30% and 69%; after 24 observations 0% and 100%." in alt
    steps = recorded_walk().steps[: REAL_SHOWN[-1]]
    ends = [
        np.median(find_itself(weigh, resample, steps, np.random.default_rng(seed), 2000, FIELD)[-1], axis=0)
        for seed in range(20)
    ]
    sides = [sum(np.hypot(*(end - side * steps[-1].pose)[:2]) < FOUND for end in ends) for side in (1, -1)]
    assert sides == [7, 13]
    quotes(text("12"), "60 measurements of posts and corners", "7 end at the robot and 13 opposite it")


def test_real_ranges_from_far_away_are_too_short_and_bearings_are_right():
    alt = draw_real_measurements(own("05")["expected_measurement"]).alt
    assert "60 measurements" in alt and "beyond 4 m the bearing's median error is 0.2 degrees" in alt
    assert alt.endswith("and the median range is -0.33 m off.")
    quotes(text("05"), "24 of its pictures", "0.2 degrees (median)", "0.3 m too short beyond 4 m")
    assert np.degrees(np.arctan(0.05 / 1.5)) == pytest.approx(2, abs=0.1)  # 5 cm to the side at 1.5 m


def test_the_filter_finds_a_real_robot_and_then_states_too_small_an_error():
    functions = own("06")["localize"], own("05")["predict_pose"], own("05")["predict_covariance"]
    alt = draw_real_walk(*functions).alt
    assert "begins 0.58 m and 10 degrees off; it is 0.10 m" in alt
    quotes(text("06"), "0.58 m and 10 degrees off", "Picture 16", "falls to 0.10 m", "60 measurements")
    trace = follow(recorded_walk(), *functions, np.diag(np.square(START_SIGMAS)), WRONG_START)
    off = np.hypot(*trace.errors[:, :2].T)
    stated = np.sqrt(trace.covariances[:, 0, 0] + trace.covariances[:, 1, 1])
    assert off[14] > 0.25 and off[15:].max() < 0.12  # picture 16 is the turn
    assert (off[15:20] > stated[15:20]).all()


def test_the_map_of_the_real_field_has_a_goal_of_the_right_width():
    slam = own("07")
    alt = draw_real_map(slam["predict"], slam["update_landmarks"], slam["add_landmark"]).alt
    assert "after picture 1 65 cm off" in alt and "after picture 24 4 cm off and 1.43 m apart" in alt
    quotes(text("07"), "65 cm off", "4 cm off and 1.43 m apart", "in reality it is 1.40 m")


def test_the_linear_graph_repairs_a_real_building():
    alt = draw_real_building(own("08")["solve_sparse"]).alt
    assert "943 poses" in alt and "the odometry differs from it by 1.1 m and the graph" in alt
    assert "differs from it by 0.4 m" in alt
    quotes(text("08"), "942 motions and 895 recognised places")
    graph, _, steps = intel_graph()
    assert (len(steps), len(graph.edges) - len(steps)) == (942, 895)
