"""The sheets for lesson 05's derivations on paper; their symbols stay in here and never become a notebook's globals."""

from __future__ import annotations

from nao_course.widgets.derivation_sheet import DerivationSheet, derivation


def motion_sheet() -> DerivationSheet:
    """Return the sheet for F and G, the Jacobians of equation 5.5 by the old pose and by the errors."""
    from sympy import Matrix, cos, sin, symbols  # SymPy takes long to import

    x, y, theta, d, alpha, e_x, e_y, e_alpha = symbols("x y theta d alpha e_x e_y e_alpha")
    along = Matrix([cos(theta), sin(theta), 0])
    left = Matrix([-sin(theta), cos(theta), 0])
    errors = [e_x, e_y, e_alpha]
    return derivation(
        "F (by x, y, theta) and G (by e_x, e_y, e_alpha): the motion",
        Matrix([x, y, theta + alpha + e_alpha]) + (d + e_x) * along + e_y * left,
        by=[x, y, theta, *errors],
        zero=errors,
        rows=("new x", "new y", "new theta"),
        known=[[1, 0, "", "", "", 0], [0, 1, "", "", "", 0], [0, 0, 1, 0, 0, 1]],
    )


def position_sheet() -> DerivationSheet:
    """Return the sheet for J_p and J_z, the Jacobians of a landmark's position."""
    from sympy import Matrix, cos, sin, symbols

    x, y, theta, beta, r = symbols("x y theta beta r")
    known = [[1, 0, "", "", ""], [0, 1, "", "", ""]]
    return derivation(
        "J_p (x, y, theta) and J_z (beta, r): a landmark's position",
        Matrix([x, y]) + r * Matrix([cos(theta + beta), sin(theta + beta)]),
        by=[x, y, theta, beta, r],
        rows=("l_x", "l_y"),
        known=known,
    )
