"""What the test modules of the catalogues share."""

import pytest

from tests.attacks import laws
from tests.attacks.range import ranges
from tests.sandboxed import need

LAYERS = (
    *("user namespace", "pid namespace", "mount namespace", "ipc namespace", "network namespace"),
    *("landlock", "seccomp", "unprivileged user"),
)


@pytest.fixture(scope="module")
def field():
    """Makes ranges, where there is the whole sandbox: hostile code runs nowhere else."""
    need(*LAYERS)
    with ranges() as make:
        yield make


@pytest.fixture(scope="module")
def options():
    """How a module's range differs from the usual one."""
    return {}


@pytest.fixture(scope="module")
def alone(field, options, request):
    """What the neighbours of a module's attacks get where nobody attacks."""
    return laws.alone(field(**options), request.module.ATTACKS)


@pytest.fixture(scope="module")
def graded(field, options, request):
    """What a run over all attacks of a module comes to."""
    return field(**options).run(request.module.ATTACKS)


@pytest.fixture(scope="module")
def hidden(field):
    """Numbers that no student may see."""
    return laws.hidden(field())
