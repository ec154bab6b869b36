"""What stands behind `draw.`: the course's names and nothing else, soon loaded."""

import subprocess
import sys

import pytest

from nao_course import plotting


def test_the_library_holds_no_way_back_from_a_pixel_to_the_ground():
    names = [name for name in dir(plotting) if "ground" in name.lower() or "inverse" in name.lower()]
    assert names == []


@pytest.mark.parametrize(
    "part", ["plotting", "sim", "widgets", "exercises", "student", "lessons.meet_the_nao"]
)
def test_nothing_of_the_students_side_waits_for_scipy_or_sympy(part):
    code = (
        f"import sys; from nao_course.{part} import *; print({{'scipy', 'sympy'}} & {{*sys.modules}} or '')"
    )
    loaded = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    assert loaded.strip() == ""
