"""Record the filter with two errors that opens lesson 07; ``python -m tests.lessons.ekf_slam.make_bent_map`` writes it.

Its errors are declared mistakes of the lesson, so no code of it is in the library.
"""

import json

import numpy as np

from nao_course.geometry import Pose
from nao_course.instructor.authoring.mistakes import changed
from nao_course.instructor.authoring.plans import load_plan, load_solution
from nao_course.lessons.ekf_slam.bent_map.runs import (
    ONE_ERROR,
    RECORDED,
    TEST_CONTROL,
    TEST_STEP,
    TWO_ERRORS,
    bent_drive,
    run_filter,
)
from nao_course.lessons.ekf_slam.consistency import NOISY
from nao_course.sim.drives import NamedEkf
from tests.paths import SOLUTIONS


def functions_with(*mistakes):
    """predict, update_landmarks and add_landmark of the solution, with declared mistakes by (exercise, name)."""
    plan = load_plan(SOLUTIONS / "exercises" / "07_ekf_slam.py")
    made = load_solution(SOLUTIONS / "07_ekf_slam.ipynb")
    functions = {name: made[name] for name in ("predict", "update_landmarks", "add_landmark")}
    for name, mistake in mistakes:
        exercise = next(each for each in plan.exercises if each.name == name)
        declared = next(each for each in exercise.mistakes if each.name == mistake)
        functions[name] = changed(name, declared, load_solution(SOLUTIONS / "07_ekf_slam.ipynb"))
    return tuple(functions.values())


def rounded(array):
    return np.round(np.asarray(array), 7).tolist()


def made():
    """Return what the file holds."""
    no_cross, no_wrap = ("predict", "cross-covariances left"), ("update_landmarks", "innovation unwrapped")
    one, two = functions_with(no_cross), functions_with(no_cross, no_wrap)
    runs = {TWO_ERRORS: two, ONE_ERROR: one}
    recorded = {}
    for name, functions in runs.items():
        run, drive = run_filter(functions), bent_drive()
        places = [int(np.argmin(np.hypot(*(drive.landmarks - true).T))) for true in run.true_landmarks]
        recorded[name] = {
            "path": rounded(run.path),
            "nees": rounded(run.nees),
            "landmarks": rounded(run.landmarks),
            "landmark_covariances": rounded(run.landmark_covariances),
            "bearings": rounded(run.bearings),
            "known": places,
        }
    slam = NamedEkf(Pose(), *functions_with())
    for step in bent_drive().steps[1 : TEST_STEP + 1]:
        slam.move(step.control, step.control_covariance)
        slam.observe(step.numbers, step.measurements, step.covariances)
    state, covariance = np.array(rounded(slam.state)), np.array(rounded(slam.covariance))
    _, predicted = one[0](state, covariance, TEST_CONTROL.copy(), NOISY.control_covariance, len(slam.known))
    recorded["test"] = {
        "state": rounded(state),
        "covariance": rounded(covariance),
        "predicted": rounded(predicted),
    }
    return recorded


if __name__ == "__main__":
    RECORDED.write_text(json.dumps(made()) + "\n", encoding="utf-8")
