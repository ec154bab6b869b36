"""The sheet for a landmark's derivatives reads what the text says to type, and leaves no symbol in the notebook."""

import re

from nao_course.lessons.pose_graphs import landmark_sheet
from tests.paths import SOLUTIONS

DERIVATIVES = [["-cos(theta)", "-sin(θ)*Δx + cos(θ)*Δy"], ["sin(theta)", "-cos(theta)*dx - sin(theta)*dy"]]


def test_derivatives_by_delta_x_and_delta_y_are_right_and_a_wrong_sign_is_told():
    assert "All 4 entries are correct." in repr(landmark_sheet().write(DERIVATIVES))
    wrong = [DERIVATIVES[0], [DERIVATIVES[1][0], "cos(theta)*dx + sin(theta)*dy"]]
    assert "left by theta: its sign is wrong" in repr(landmark_sheet().write(wrong))


def test_the_lessons_cells_know_no_symbols():
    text = (SOLUTIONS / "09_pose_graphs.md").read_text(encoding="utf-8")
    assert not re.search(r"sympy|symbols\(", text)
