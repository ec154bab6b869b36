"""How answers are compared with what is expected; a comparison that needs a driver has it beside it."""

from nao_course.exercises.comparisons.jacobians import Derivative
from nao_course.exercises.comparisons.methods import Methods, calls, first_items, over_log
from nao_course.exercises.comparisons.sampling import Sampled
from nao_course.exercises.comparisons.values import Between, Close, Comparison, Exact, Points, Verdict

__all__ = [
    "Between",
    "Close",
    "Comparison",
    "Derivative",
    "Exact",
    "Methods",
    "Points",
    "Sampled",
    "Verdict",
    "calls",
    "first_items",
    "over_log",
]
