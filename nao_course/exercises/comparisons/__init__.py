"""Comparisons of answers with expected answers, and the drivers that some of them need."""

from nao_course.exercises.comparisons.combined import All, Each, Property, Unordered
from nao_course.exercises.comparisons.comparison import Comparison, Verdict
from nao_course.exercises.comparisons.jacobians import Derivative
from nao_course.exercises.comparisons.methods import Methods, calls, first_items, over_log
from nao_course.exercises.comparisons.sampling import Sampled
from nao_course.exercises.comparisons.values import Between, Close, Exact, Points

__all__ = [
    "All",
    "Between",
    "Close",
    "Comparison",
    "Derivative",
    "Each",
    "Exact",
    "Methods",
    "Points",
    "Property",
    "Sampled",
    "Unordered",
    "Verdict",
    "calls",
    "first_items",
    "over_log",
]
