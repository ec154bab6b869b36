"""What the browser's test modules share."""

import pytest

from tests.browser.lab import jupyter_lab


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A JupyterLab that runs for a module's tests."""
    folder = tmp_path_factory.mktemp("notebooks")
    with jupyter_lab(folder, tmp_path_factory.mktemp("jupyter")) as running:
        yield running
