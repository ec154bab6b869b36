"""The numbers of a student's personal world, which the written answers of some lessons quote."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from nao_course._internal.personal_world import personal_world
from nao_course.plotting import Table, table


def personal_table(
    what: str, numbers: Callable[..., Mapping[str, float]], *functions: Callable[..., Any]
) -> Table:
    """Return the numbers of your personal world as a table.

    Parameters
    ----------
    what : str
        What the numbers belong to, such as "picture".
    numbers : callable
        ``numbers(world, *functions)`` returns the numbers by what they are.
    *functions : callable
        Your functions, with which the numbers are computed.

    Returns
    -------
    Table
        A row for each number, with three decimals.
    """
    world = personal_world()
    rows = [(name, f"{value:.3f}") for name, value in numbers(world, *functions).items()]
    return table((f"{what} of {world}", "value"), rows)
