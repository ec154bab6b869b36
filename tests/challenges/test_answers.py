"""Answers of entries that are no points are said."""

import numpy as np
import pytest

from nao_course.challenges.answers import as_found_points


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (None, "returns None"),
        ("feet", "got str"),
        ([1.0, 2.0], r"got shape \(2,\)"),
        (np.zeros((2, 3)), r"or \(0, 2\) without any points"),
        ([(np.nan, 1.0)], "NaN or infinite"),
        (np.zeros((1001, 2)), "at most 1000"),
        ([[1, 2], [3]], "got list"),
    ],
)
def test_what_is_no_points_is_said(answer, said):
    with pytest.raises((TypeError, ValueError), match=said):
        as_found_points(answer, "feet")
