"""The payoff: with a good heading the ellipses hold the robots, with a bad one they do not."""

import numpy as np

from nao_course.lessons.ekf_derivations.figures import bending_clouds, draw_bending


def test_the_payoff_holds_the_robots_at_5_degrees_and_loses_half_at_30(solution):
    functions = solution["predict_pose"], solution["predict_covariance"]
    good, bad = ([each.inside() for each in bending_clouds(*functions, np.radians(s))] for s in (5, 30))
    assert min(good) > 0.9 and max(bad) < 0.65
    alt = draw_bending(*functions).alt
    assert "5 degrees: 94, 92 and 92 %" in alt and "30 degrees: 62, 55 and 49 %" in alt
    assert draw_bending(functions[0], lambda covariance, *rest: covariance).alt != alt
