"""The lesson's own solution, as a student who got everything right would have it."""

import pytest

from nao_course.exercises import load_definitions
from tests.paths import SOLUTIONS


@pytest.fixture(scope="session")
def solution():
    return load_definitions(SOLUTIONS / "05_ekf_derivations.ipynb")
