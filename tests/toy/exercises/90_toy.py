"""The toy lesson's exercises."""

import numpy as np

from nao_course.exercises import Case, Exercise, LessonPlan, Mistake, Question, Sibling

CLAMP = Exercise(
    name="clamp",
    points=2,
    public=lambda: [
        Case((x, 0.5, 2.25), name) for x, name in ((3.0, "above"), (-3.0, "below"), (1.125, "inside"))
    ],
    hidden=lambda rng: [Case((float(x), -1.5, 0.75)) for x in (-9, 9, 0, *rng.normal(0, 2, 5))],
    hints=("Which of the three is in the middle?", "The smaller of x and high, but at least low."),
    sibling=Sibling(
        "A shift is at least 4 and at most 8 hours long.",
        """
        for hours in (2, 9):
            if hours < 4 or hours > 8:
                print(hours, "is refused")
        """,
        """
        2 is refused
        9 is refused
        """,
    ),
    mistakes=[
        Mistake("low only", lambda x, low, high: max(low, x), "Too large an x stays as it is."),
        Mistake("high only", lambda x, low, high: min(high, x), "Too small an x stays as it is."),
        Mistake("min and max swapped", lambda x, low, high: min(low, max(high, x)), "Swap min and max."),
    ],
    alternatives={
        "numpy": lambda x, low, high: np.clip(x, low, high),
        "if": lambda x, low, high: low if x < low else high if x > high else x,
        "sorted": lambda x, low, high: sorted([low, x, high])[1],
    },
)


def _loop(values):
    total, count = 0.0, 0
    for value in values:
        if value > 0:
            total, count = total + value, count + 1
    return total / count if count else 0.0


def _in_place(values):
    values[values < 0] = 0
    return float(values.sum() / max(np.count_nonzero(values), 1))


MEAN = Exercise(
    name="mean_of_positive",
    points=3,
    public=lambda: [
        Case((np.array([1.5, -2.0, 0.0, 4.0]),), "a mixture"),
        Case((np.array([-1.0, -2.5]),), "nothing positive"),
    ],
    hidden=lambda rng: [Case((rng.normal(1, 2, size),)) for size in (3, 10, 20)] + [Case((np.zeros(3),))],
    hints=("A mask selects.", "values[values > 0]"),
    mistakes=[
        Mistake("all", lambda values: float(values.mean()), "That is the mean of all values."),
        Mistake("zeros counted", lambda v: float(np.maximum(v, 0).mean()), "Zeros should not count."),
        Mistake("empty mean", lambda v: sum(v[v > 0].tolist()) / int((v > 0).sum()), "That divides by zero."),
        Mistake("in place", _in_place, "values[...] = writes into what you were given."),
    ],
    alternatives={
        "loop": _loop,
        "float32": lambda values: np.float32(_loop(values)),
        "list": lambda values: np.mean([v for v in values if v > 0] or [0.0]),
    },
    stars=2,
)

REPLIES = {"Safety": "Yes: a joint has an end.", "Speed": "No: it costs time."}
PLAN = LessonPlan([CLAMP, MEAN], [Question("why", "Why clamp?", REPLIES, "Safety")])
