"""The student's robot: the control panel with everything in it that they have solved."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from nao_course.student.notebooks import notebooks_folder
from nao_course.student.stages import all_stages, readiness

if TYPE_CHECKING:  # they take long to import, and the command line needs none of them
    from nao_course.sim import SimulatedNao, Truth
    from nao_course.widgets import ControlPanel

SEED = 41


def my_nao(
    nao: SimulatedNao | None = None,
    truth: Truth | None = None,
    *,
    time_limit: float | None = None,
    **own: Callable[..., Any],
) -> ControlPanel:
    """Drive your robot: the control panel with all that you have solved live in it.

    Your functions come from this notebook, as they are now, else from your saved notebooks. What is missing or does not
    pass its public checks is named and left out.

    Parameters
    ----------
    nao : SimulatedNao, optional
        The robot; by default one that looks at the goal, the same each time.
    truth : Truth, optional
        Of this robot; by default it is there where no robot is given.
    time_limit : float, optional
        Seconds for your code and one picture; then the panel goes on without it.
    **own : callable
        Functions to use, by their names: ``my_nao(color_labels=color_labels)``.

    Returns
    -------
    ControlPanel
        To be a cell's last line. ``panel.view`` says whether your code's view lies over the picture.

    Raises
    ------
    ValueError
        If `nao` is no robot, or a function has a name that no stage of the robot uses.
    """
    from nao_course.geometry import Pose
    from nao_course.sim import SimulatedNao, Truth
    from nao_course.widgets import ControlPanel
    from nao_course.widgets.control_panel import Pipeline
    from nao_course.widgets.control_panel.pipeline import PICTURE_LIMIT

    if nao is None:
        nao = SimulatedNao(pose=Pose(0.6, 0.5, -0.25), rng=SEED)
        truth = Truth(nao)
    stages = all_stages()
    names = {use.rpartition(":")[2] for stage in stages for use in (*stage.uses, *stage.helped_by)}
    if unknown := sorted(own.keys() - names):
        raise ValueError(f"my_nao uses {', '.join(sorted(names))}; got {', '.join(unknown)}")
    given = {**_at_hand(names), **own}
    found = readiness(stages, given, notebooks_folder())
    saved = [name for name, function in found.functions.items() if given.get(name, function) is not function]
    remarks = [
        f"{name} as it is in this notebook does not pass its check: the saved one drives" for name in saved
    ]
    remarks += found.remarks
    limit = PICTURE_LIMIT if time_limit is None else time_limit
    pipeline = Pipeline(found.stages, found.functions, nao, found.missing, limit, remarks)
    panel = ControlPanel(nao, truth, pipeline=pipeline)
    if found.stages:
        panel.view = "beside"  # over the picture, good labels of green and yellow are hard to see
    return panel


def _at_hand(names: set[str]) -> dict[str, Any]:
    """What the present notebook defines under these names."""
    ipython = sys.modules.get("IPython")  # where it is not imported, there is no notebook
    shell = ipython.get_ipython() if ipython else None
    namespace: Mapping[str, Any] = shell.user_ns if shell else {}
    return {name: namespace[name] for name in names if callable(namespace.get(name))}
