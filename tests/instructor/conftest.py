"""What tests of the instructors' side share: one warm server in each test process, for starting it takes seconds."""

import pytest

from nao_course.instructor.sandbox.layers import probe
from nao_course.instructor.sandbox.warm_server import WarmServer


@pytest.fixture(scope="session")
def warm_server():
    """A server with all layers that this machine has, and everything imported."""
    with WarmServer(probe()) as server:
        yield server
