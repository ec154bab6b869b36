"""The lesson's own solution, as a student who got everything right would have it."""

import pytest

from tests.lessons.every import own


@pytest.fixture(scope="session")
def solution():
    return own("05")
