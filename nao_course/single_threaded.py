"""One thread for NumPy and OpenCV: small matrices gain nothing by more, and on a busy machine they wait for each other.

The libraries look once, when they are loaded: who wants it imports this module before them.
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
