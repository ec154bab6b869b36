"""What the browser's test modules share."""

import shutil

import pytest

from tests.browser.lab import browser, jupyter_lab


@pytest.fixture(autouse=True, scope="session")
def needs_jupyterlab_and_playwright():
    """Skip where the test extras are not installed."""
    pytest.importorskip("jupyterlab")
    pytest.importorskip("playwright")


@pytest.fixture(scope="session")
def running_lab(tmp_path_factory):
    """A JupyterLab that runs for all tests of a process."""
    folder = tmp_path_factory.mktemp("notebooks")
    with jupyter_lab(folder, tmp_path_factory.mktemp("jupyter")) as running:
        yield running


@pytest.fixture(scope="module")
def lab(running_lab):
    """A JupyterLab in which a module's tests find nothing open and nothing saved."""
    yield running_lab
    running_lab.close_notebooks()
    for each in running_lab.folder.iterdir():  # a saved notebook would be a stage of the next module's robot
        shutil.rmtree(each) if each.is_dir() else each.unlink()


@pytest.fixture(scope="module")
def context(chromium):
    """A Chromium for a module's tests."""
    with browser(chromium) as opened:
        yield opened


@pytest.fixture
def page(lab, context):
    """A page on which nothing of ours may complain."""
    lab.console.clear()
    page = context.new_page()
    yield page
    page.close()
    assert lab.our_errors() == []
