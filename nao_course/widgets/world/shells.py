"""The NAO's shells as superellipsoids on its links, measured on drawings of the robot and simplified."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from nao_course.widgets.world.meshes import Shape

SHELL, TRIM, JOINT, DARK, EYE, LED = "#f3f4f2", "#c8372f", "#565b63", "#23262b", "#e8f6ff", "#39b6ff"
_RIGHT = np.pi / 2


@lru_cache(maxsize=1)
def shells() -> tuple[Shape, ...]:
    """Return the shapes of the whole robot."""
    body = _head() + _torso()
    left = _arm() + _leg()
    return (*body, *left, *(shape.mirrored(f"R{shape.link[1:]}") for shape in left))


def _head() -> list[Shape]:
    h = "HeadPitch"
    one_side = [
        # The loudspeakers at its ears
        Shape(
            h, TRIM, (-0.004, 0.058, 0.048), (0.058, 0.062, 0.020), (0.35, 1.0), (0.86, 0.86), (0, 0, -_RIGHT)
        ),
        Shape(
            h, SHELL, (-0.004, 0.067, 0.048), (0.044, 0.046, 0.010), (0.35, 1.0), (0.9, 0.9), (0, 0, -_RIGHT)
        ),
        Shape(h, DARK, (-0.004, 0.0705, 0.048), (0.020, 0.020, 0.006), (0.3, 1.0), (1, 1), (0, 0, -_RIGHT)),
        # Eyes
        Shape(h, DARK, (0.0505, 0.0265, 0.044), (0.012, 0.031, 0.034), (0.8, 0.9), (1, 1), (0.42, 0.12, 0)),
        Shape(h, LED, (0.0535, 0.0280, 0.0435), (0.0100, 0.024, 0.026), (0.8, 0.9), (1, 1), (0.42, 0.12, 0)),
        Shape(h, EYE, (0.0572, 0.0292, 0.0432), (0.0055, 0.014, 0.015), (0.9, 0.9), (1, 1), (0.42, 0.12, 0)),
    ]
    other = [shape.mirrored(h) for shape in one_side]
    return [
        Shape("HeadYaw", JOINT, (0.0, 0.0, -0.014), (0.052, 0.052, 0.052), (0.3, 1.0)),
        Shape(h, SHELL, (-0.002, 0.0, 0.055), (0.118, 0.122, 0.112), (0.80, 0.9), (0.90, 0.90)),
        Shape(h, SHELL, (0.020, 0.0, 0.020), (0.070, 0.080, 0.044), (0.6, 0.7), (1.15, 1.15)),
        # Forehead with the upper camera, mouth with the lower one
        Shape(h, TRIM, (-0.006, 0.0, 0.093), (0.090, 0.032, 0.036), (0.7, 0.5)),
        Shape(h, JOINT, (-0.008, 0.0, 0.1055), (0.052, 0.014, 0.014), (0.5, 0.5)),
        Shape(h, DARK, (0.0500, 0.0, 0.0636), (0.018, 0.020, 0.014), (0.5, 0.5)),
        Shape(h, DARK, (0.0480, 0.0, 0.0177), (0.014, 0.018, 0.012), (0.5, 0.5)),
        *one_side,
        *other,
    ]


def _torso() -> list[Shape]:
    t = "Torso"
    return [
        Shape(t, SHELL, (0.000, 0.0, 0.058), (0.112, 0.136, 0.116), (0.45, 0.55), (1.08, 1.16)),
        Shape(t, SHELL, (0.002, 0.0, 0.108), (0.096, 0.128, 0.040), (0.8, 0.6), (0.72, 0.70)),
        Shape(t, TRIM, (0.0445, 0.0, 0.086), (0.034, 0.086, 0.046), (0.6, 0.6), (1.0, 1.25)),
        Shape(t, TRIM, (-0.046, 0.0, 0.066), (0.030, 0.092, 0.074), (0.5, 0.5), (1.0, 1.1)),
        # The button on its chest
        Shape(t, JOINT, (0.062, 0.0, 0.046), (0.034, 0.034, 0.014), (0.5, 1.0), (0.9, 0.9), (0, _RIGHT, 0)),
        Shape(t, EYE, (0.067, 0.0, 0.046), (0.020, 0.020, 0.008), (0.7, 1.0), (1, 1), (0, _RIGHT, 0)),
        Shape(t, JOINT, (0.0, 0.0, -0.012), (0.074, 0.086, 0.050), (0.5, 0.7)),
        Shape(t, SHELL, (0.0, 0.0, -0.052), (0.092, 0.112, 0.058), (0.5, 0.55), (0.92, 0.92)),
        Shape(t, TRIM, (0.036, 0.0, -0.052), (0.030, 0.040, 0.050), (0.5, 0.5)),
        Shape(t, JOINT, (0.0, 0.090, 0.100), (0.044, 0.044, 0.046), (0.3, 1.0), (1, 1), (0, 0, _RIGHT)),
        Shape(t, JOINT, (0.0, -0.090, 0.100), (0.044, 0.044, 0.046), (0.3, 1.0), (1, 1), (0, 0, _RIGHT)),
    ]


def _arm() -> list[Shape]:
    # At zero angles the arm points ahead.
    return [
        Shape("LShoulderPitch", TRIM, (0.002, 0.013, 0.0), (0.070, 0.062, 0.070), (0.75, 0.8)),
        Shape(
            "LShoulderRoll",
            SHELL,
            (0.046, 0.013, 0.0),
            (0.062, 0.056, 0.076),
            (0.6, 0.7),
            (0.8, 0.86),
            (0, _RIGHT, 0),
        ),
        Shape("LShoulderRoll", JOINT, (0.090, 0.015, 0.0), (0.034, 0.036, 0.036), (0.5, 0.9)),
        Shape("LElbowRoll", JOINT, (0.002, 0.0, 0.0), (0.044, 0.044, 0.046), (0.35, 1.0)),
        Shape(
            "LElbowRoll",
            SHELL,
            (0.038, 0.0, 0.0),
            (0.050, 0.050, 0.056),
            (0.5, 0.7),
            (1.22, 1.22),
            (0, _RIGHT, 0),
        ),
        Shape(
            "LWristYaw",
            SHELL,
            (0.020, 0.0, 0.0),
            (0.064, 0.064, 0.046),
            (0.55, 0.7),
            (0.82, 0.82),
            (0, _RIGHT, 0),
        ),
        Shape(
            "LWristYaw", TRIM, (0.002, 0.0, 0.0), (0.067, 0.067, 0.012), (0.4, 0.7), (1, 1), (0, _RIGHT, 0)
        ),
        Shape("LWristYaw", JOINT, (0.050, 0.0, -0.004), (0.034, 0.040, 0.026), (0.6, 0.7)),
        # Two fingers and a thumb
        Shape(
            "LWristYaw",
            SHELL,
            (0.074, 0.010, -0.010),
            (0.036, 0.014, 0.016),
            (0.7, 0.7),
            (1, 1),
            (0, 0.35, 0),
        ),
        Shape(
            "LWristYaw",
            SHELL,
            (0.074, -0.010, -0.010),
            (0.036, 0.014, 0.016),
            (0.7, 0.7),
            (1, 1),
            (0, 0.35, 0),
        ),
        Shape(
            "LWristYaw", SHELL, (0.062, 0.0, -0.026), (0.030, 0.014, 0.014), (0.7, 0.7), (1, 1), (0, 0.6, 0)
        ),
    ]


def _leg() -> list[Shape]:
    return [
        Shape("LHipRoll", JOINT, (0.0, 0.0, -0.004), (0.056, 0.050, 0.056), (0.6, 0.8)),
        Shape("LHipPitch", SHELL, (0.006, 0.006, -0.052), (0.082, 0.076, 0.094), (0.55, 0.6), (1.08, 0.94)),
        Shape("LHipPitch", TRIM, (0.038, 0.006, -0.046), (0.026, 0.046, 0.060), (0.6, 0.6)),
        Shape(
            "LKneePitch", JOINT, (0.0, 0.0, 0.0), (0.058, 0.058, 0.064), (0.35, 1.0), (1, 1), (0, 0, _RIGHT)
        ),
        Shape("LKneePitch", SHELL, (0.010, 0.002, -0.046), (0.078, 0.074, 0.088), (0.55, 0.6), (0.86, 0.9)),
        Shape("LKneePitch", SHELL, (0.030, 0.002, -0.008), (0.030, 0.052, 0.046), (0.7, 0.7)),
        Shape("LKneePitch", TRIM, (-0.026, 0.002, -0.048), (0.030, 0.048, 0.060), (0.6, 0.6)),
        Shape("LAnklePitch", JOINT, (0.0, 0.0, -0.002), (0.048, 0.048, 0.052), (0.5, 0.9)),
        Shape(
            "LAnklePitch", SHELL, (0.022, 0.006, -0.0262), (0.160, 0.088, 0.038), (0.6, 0.55), (0.78, 0.72)
        ),
        Shape("LAnklePitch", TRIM, (0.080, 0.006, -0.0310), (0.046, 0.070, 0.022), (0.5, 0.8)),
        Shape("LAnklePitch", DARK, (0.022, 0.006, -0.0420), (0.158, 0.088, 0.0064), (0.3, 0.55)),
    ]
