"""The lesson's own solution, which its tests run."""

import pytest

from tests.lessons import every


@pytest.fixture(scope="session")
def own():
    return every.own("11")
