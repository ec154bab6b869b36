"""A challenge small enough for tests: double the numbers that are given."""

from dataclasses import replace
from typing import Any

import numpy as np

from nao_course.challenges import CaseScore, Challenge, Column, Row


def judge(answer: Any, numbers: np.ndarray) -> CaseScore:
    found = np.asarray(answer, dtype=float)
    if found.shape != numbers.shape:
        raise ValueError(f"Your entry must return shape {numbers.shape}, got {found.shape}.")
    off = float(np.abs(found - 2 * numbers).mean())
    return CaseScore(max(1.0 - off, 0.0), {"off": off}, found)


CHALLENGE = Challenge(
    lesson="77_doubling",
    title="Doubling",
    task="Double what is given.",
    scoring="one less the mean error.",
    seeds=(1, 2, 3),
    make=lambda seed: np.arange(float(seed)),
    given=lambda numbers: (numbers,),
    judge=judge,
    columns=(Column("off", " m", 1),),
    rows=(
        Row("nothing", 0.0, {"off": 1.0}, (0.0, 0.0, 0.0)),
        Row("the reference", 0.75, {"off": 0.25}, (0.5, 1, 0.75)),
    ),
    name_of=lambda seed: f"case {seed}",
    seconds=0.1,
    seconds_in_all=2.0,
)
COST = replace(
    CHALLENGE,
    higher_is_better=False,
    nothing=9.0,
    unit=" m",
    judge=lambda answer, numbers: CaseScore(1.0 - judge(answer, numbers).score),
    columns=(),
    rows=(Row("nothing", 9.0), Row("the reference", 0.25)),
)


def double(numbers: np.ndarray) -> np.ndarray:
    return 2 * numbers
