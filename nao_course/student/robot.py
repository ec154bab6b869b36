"""The student's robot: the control panel with the functions that the student has solved."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from nao_course.exercises.lesson_names import number_of
from nao_course.student.notebooks import notebooks_folder
from nao_course.student.stages import all_stages, any_ready, readiness, split_after

if TYPE_CHECKING:  # these modules take long to import, and the command line does not need them
    from nao_course.robot import Robot
    from nao_course.sim import Truth
    from nao_course.widgets import ControlPanel

SEED = 41
SIMULATED = "only the simulator measures what it needs"


def my_nao(
    nao: Robot | None = None,
    truth: Truth | None = None,
    *,
    upto: str = "",
    time_limit: float | None = None,
    **own: Callable[..., Any],
) -> ControlPanel:
    """Return the control panel of your robot, which runs all functions that you have solved.

    With `upto` it runs the functions of the first lessons, so that a lesson shows the same robot when later lessons are
    solved.

    Each function is taken from this notebook if it passes its public checks there, else from your saved notebooks. The
    panel lists the functions that are missing or do not pass, and drives without them.

    Parameters
    ----------
    nao : Robot, optional
        The robot: a `SimulatedNao`, a `RealNao` or a `RecordedNao`; by default a simulated one in front of the goal,
        the same each time. What the simulator measures is left out on the other two.
    truth : Truth, optional
        Truth about this robot; without `nao` it is made automatically.
    upto : str
        Number of the last lesson whose functions run, such as "06"; by default all lessons.
    time_limit : float, optional
        Seconds for your code and one picture; slower code is stopped, and the panel continues without it.
    **own : callable
        Functions to use, by name: ``my_nao(color_labels=color_labels)``.

    Returns
    -------
    ControlPanel
        The panel, shown if it is a cell's last line. ``panel.view`` is where your code's results are shown.

    Raises
    ------
    ValueError
        If `nao` is not a robot, there is no lesson `upto`, or no stage of the robot uses a function's name.
    """
    from nao_course.geometry import Pose
    from nao_course.sim import SimulatedNao, Truth
    from nao_course.widgets import ControlPanel
    from nao_course.widgets.control_panel import Pipeline
    from nao_course.widgets.control_panel.pipeline import PICTURE_LIMIT

    stages, later = split_after(all_stages(), upto)
    if nao is None:
        nao = SimulatedNao(pose=Pose(0.6, 0.5, -0.25), rng=SEED)
        truth = Truth(nao)
    names = {use.rpartition(":")[2] for stage in stages for use in (*stage.uses, *stage.helped_by)}
    if unknown := sorted(own.keys() - names):
        raise ValueError(
            f"no stage of the robot uses {', '.join(unknown)}; my_nao takes {', '.join(sorted(names))}"
        )
    given = {**_at_hand(names), **own}
    folder = notebooks_folder()
    simulated = isinstance(nao, SimulatedNao)
    found = readiness([stage for stage in stages if simulated or not stage.simulated], given, folder)
    missing = {} if simulated else dict.fromkeys((each.name for each in stages if each.simulated), SIMULATED)
    saved = [name for name, function in found.functions.items() if given.get(name, function) is not function]
    remarks = [
        f"{name} of this notebook does not pass its check, so the saved version is used" for name in saved
    ]
    remarks += found.remarks
    if any_ready(found, later, folder):
        remarks.append(f"this is your robot after lesson {number_of(upto)}; my_nao() runs all your lessons")
    limit = PICTURE_LIMIT if time_limit is None else time_limit
    pipeline = Pipeline(found.stages, found.functions, nao, {**found.missing, **missing}, limit, remarks)
    panel = ControlPanel(nao, truth, pipeline=pipeline)
    if found.stages:
        panel.view = "beside"  # green and yellow labels are hard to see over the picture
    return panel


def _at_hand(names: set[str]) -> dict[str, Any]:
    """Return the functions that the present notebook defines under these names."""
    ipython = sys.modules.get("IPython")  # not imported outside of notebooks
    shell = ipython.get_ipython() if ipython else None
    namespace: Mapping[str, Any] = shell.user_ns if shell else {}
    return {name: namespace[name] for name in names if callable(namespace.get(name))}
