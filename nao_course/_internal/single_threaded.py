"""Limit NumPy and OpenCV to a single thread.

Small matrices do not become faster with more threads, and on a busy machine the threads wait for each other. The
libraries read these environment variables when they are loaded, so import this module before them.
"""

from __future__ import annotations

import os

__all__ = ["SINGLE_THREADED"]

SINGLE_THREADED = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
}

for _name, _number in SINGLE_THREADED.items():
    os.environ.setdefault(_name, _number)
