"""What several tests need: recorded data, random numbers, a browser, and no windows."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from nao_course.datasets import data_folder

os.environ["MPLBACKEND"] = "Agg"  # here and in every kernel that a test starts: no test opens a window

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSERS_ELSEWHERE = (
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
)


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
