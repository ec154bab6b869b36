"""What tests of the instructors' side share: one warm server in each test process, for starting it takes seconds."""

import pytest

from nao_course.instructor.sandbox.layers import probe
from nao_course.instructor.sandbox.warm_server import WarmServer
from tests.toy import chain


@pytest.fixture(scope="session")
def warm_server():
    """A server with all layers that this machine has, and everything imported."""
    with WarmServer(probe()) as server:
        yield server


@pytest.fixture
def secret(tmp_path, monkeypatch):
    """Return the path of an instructor's secret, which the commands use."""
    path = tmp_path / "secret"
    path.write_bytes(chain.SECRET)
    path.chmod(0o600)
    monkeypatch.setenv("NAO_COURSE_SECRET", str(path))
    return path
