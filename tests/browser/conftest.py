"""What the browser's test modules share."""

import pytest

from tests.browser.lab import browser_page, jupyter_lab


@pytest.fixture(autouse=True, scope="session")
def needs_jupyterlab_and_playwright():
    """Skip where the test extras are not installed."""
    pytest.importorskip("jupyterlab")
    pytest.importorskip("playwright")


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A JupyterLab that runs for a module's tests."""
    folder = tmp_path_factory.mktemp("notebooks")
    with jupyter_lab(folder, tmp_path_factory.mktemp("jupyter")) as running:
        yield running


@pytest.fixture
def page(lab, chromium):
    """A page on which nothing of ours may complain."""
    lab.console.clear()
    with browser_page(chromium) as opened:
        yield opened
    assert lab.our_errors() == []
