#!/usr/bin/env bash
# mpmath.workdps(50) is a context manager, so you expect it to affect only the code inside, like
# decimal.localcontext. In mpmath 1.3.0 the precision is one number for the whole process, so other threads
# calculate with it as well. Seen: while one thread was inside workdps(50), another one's sqrt(2) had 50
# digits. When two threads overlap, each restores the precision that it found: a result inside workdps(40) had
# 15 digits, and after both threads had left, the process stayed at 50 digits. SymPy's evalf and any check of
# answers with a high precision share this state in a multithreaded grader.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check mpmath==1.3.0
"$folder/venv/bin/python" - <<'PYTHON'
import threading

import mpmath

inside, leave, left = threading.Event(), threading.Event(), threading.Event()


def other():
    with mpmath.workdps(50):
        inside.set()
        leave.wait(10)
    left.set()


def digits():
    return len(mpmath.nstr(mpmath.sqrt(2), mpmath.mp.dps)) - 1


thread = threading.Thread(target=other)
thread.start()
inside.wait(10)
outside = digits()
with mpmath.workdps(40):
    leave.set()
    left.wait(10)
    within = mpmath.mp.dps
thread.join()
print(f"digits outside workdps: {outside}, precision inside workdps(40): {within}, at the end: {mpmath.mp.dps}")
assert (outside, within, mpmath.mp.dps) == (50, 15, 50)
PYTHON
