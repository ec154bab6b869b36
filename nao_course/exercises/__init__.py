"""Exercises: their declarations, their checks, and the functions that a lesson calls."""

from nao_course._internal.lazy_names import list_public
from nao_course.codec import CodecError, Limits, decode, encode, register, register_function
from nao_course.exercises.asking import prediction
from nao_course.exercises.case import Case
from nao_course.exercises.checking import CheckFailed, Checks, lesson
from nao_course.exercises.comparisons import (
    All,
    Between,
    Close,
    Comparison,
    Derivative,
    Each,
    Exact,
    Methods,
    Points,
    Property,
    Sampled,
    Unordered,
    Verdict,
    calls,
    first_items,
    over_log,
)
from nao_course.exercises.definitions import Definitions, load_definitions
from nao_course.exercises.exercise import Exercise, LessonPlan, Mistake, Question, Sibling, Written
from nao_course.exercises.judging import Report
from nao_course.exercises.running import Outcome, call, register_driver
from nao_course.exercises.trying import Message, try_out

__all__ = [
    "All",
    "Between",
    "Case",
    "CheckFailed",
    "Checks",
    "Close",
    "CodecError",
    "Comparison",
    "Definitions",
    "Derivative",
    "Each",
    "Exact",
    "Exercise",
    "LessonPlan",
    "Limits",
    "Message",
    "Methods",
    "Mistake",
    "Outcome",
    "Points",
    "Property",
    "Question",
    "Report",
    "Sampled",
    "Sibling",
    "Unordered",
    "Verdict",
    "Written",
    "call",
    "calls",
    "decode",
    "encode",
    "first_items",
    "lesson",
    "load_definitions",
    "over_log",
    "prediction",
    "register",
    "register_driver",
    "register_function",
    "try_out",
]
__dir__ = list_public(__name__)
