"""Writing a course: texts and plans into notebooks and back, their checks, mutants and releases."""

__all__: list[str] = [
    "build",
    "course",
    "declarations",
    "execute",
    "leaks",
    "lesson_text",
    "mistake_pairs",
    "mistakes",
    "mutation",
    "perturbation",
    "plan_checks",
    "plans",
    "proofs",
    "release",
    "rounding_errors",
    "scaffold",
    "stamps",
]
