"""What several tests need: recorded data, random numbers, a browser, and no windows."""

import gc
import itertools
import os
import shutil
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from nao_course.datasets import data_folder
from tests import order

gc.disable()  # until all is collected: thousands of tests that stay would be gone through again and again
os.environ["MPLBACKEND"] = "Agg"  # here and in every kernel that a test starts: no test opens a window
os.environ["NAO_COURSE_TIME_LIMIT"] = "60"  # of a panel that names no other: no test fails for being late
settings.register_profile("any machine", deadline=None)
settings.load_profile("any machine")
# jsonschema, and with it nbformat, would read the grammar of internationalised addresses: seconds for each process.
sys.modules.setdefault("rfc3987_syntax", None)

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSERS_ELSEWHERE = (
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    config.option.loadscopereorder = False  # the tests are in their order already
    return order.LongestFirst(config, log)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items):
    items[:] = [items[place] for place in order.in_order([item.nodeid for item in items])]


def pytest_addoption(parser):
    parser.addoption("--slowest-files", type=int, default=0, help="list this number of the slowest files")


def pytest_terminal_summary(terminalreporter, config):
    if listed := config.getoption("slowest_files"):
        seconds = Counter()
        for each in itertools.chain(*terminalreporter.stats.values()):
            seconds[getattr(each, "nodeid", "").partition("::")[0]] += getattr(each, "duration", 0.0)
        terminalreporter.section("slowest files")
        for file, total in seconds.most_common(listed):
            terminalreporter.line(f"{total:7.1f} s  {file}")


def pytest_collection_finish():
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def _nothing_is_compiled_while_tests_run():
    """The tests' own modules are kept compiled; what a test starts leaves no file where another looks for changes."""
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    sys.dont_write_bytecode = True


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of recorded pictures and logs; they are not ours to pass on, so most machines have none."""
    try:
        return data_folder()
    except FileNotFoundError as problem:
        pytest.skip(f"no recorded data: {problem}")


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers, the same at every run; the seed is the day of the first paper."""
    return np.random.default_rng(20140122)


@pytest.fixture(scope="session")
def chromium() -> str:
    """The path of a Chromium for Playwright's `executable_path`; for a test that is marked `browser`."""
    found = [path for name in BROWSERS if (path := shutil.which(name))]
    found += [path for path in BROWSERS_ELSEWHERE if Path(path).exists()]
    if found:
        return found[0]
    reason = "no Chromium on this machine (on Debian and Ubuntu: apt install chromium)"
    if os.environ.get("NAO_COURSE_REQUIRE_BROWSER") == "1":
        pytest.fail(f"NAO_COURSE_REQUIRE_BROWSER=1, but {reason}")
    pytest.skip(reason)
