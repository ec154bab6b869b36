"""The sheet for a landmark's derivatives. Its symbols stay in this module, so a notebook's x or theta is never one."""

from __future__ import annotations

from nao_course.widgets.derivation_sheet import DerivationSheet, derivation


def landmark_sheet() -> DerivationSheet:
    """Return a sheet for four derivatives of equation 9.1: of both rows by the pose's x and by its heading.

    Returns
    -------
    DerivationSheet
        It reads dx and dy, or Δx and Δy, as l_x - x and l_y - y, and c and s as cos(theta) and sin(theta).
    """
    from sympy import Matrix, cos, sin, symbols  # SymPy takes long to import

    x, y, theta, l_x, l_y, z_x, z_y = symbols("x y theta l_x l_y z_x z_y")
    away = Matrix([l_x - x, l_y - y])
    turn = Matrix([[cos(theta), -sin(theta)], [sin(theta), cos(theta)]])
    seen = turn.T * away - Matrix([z_x, z_y])
    return derivation(
        "A landmark's residual",
        seen,
        by=[x, theta],
        rows=("ahead", "left"),
        short={"dx": away[0], "dy": away[1], "c": cos(theta), "s": sin(theta)},
    )
