"""Inputs that differ in their last digits: where the answers to them differ, the answers are rounding errors."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from nao_course.codec import encode
from nao_course.codec.registry import fields_of
from nao_course.codec.sparse import is_sparse
from nao_course.exercises.case import Case

SIZE = 1e-14  # relative: about 50 rounding errors of double precision, more than processors differ by
SEEDS = (1, 2, 3)  # one perturbation leaves some ill-conditioned answers nearly as they were


def perturbed_cases(case: Case) -> Iterator[Case]:
    """Yield a case with its arguments perturbed, once for each seed; nothing if they contain no float."""
    given = encode((case.args, case.kwargs))
    for seed in SEEDS:
        args, kwargs = perturbed((case.args, case.kwargs), np.random.default_rng(seed))
        if encode((args, kwargs)) != given:
            yield replace(case, args=args, kwargs=kwargs)


def perturbed(value: Any, rng: np.random.Generator) -> Any:
    """Return a copy of a value in which each double-precision number has a relative error of at most `SIZE`.

    Integers, booleans, pictures and texts stay as they are, and so does an object whose class refuses the perturbed
    values.
    """
    kind = type(value)
    if kind in (float, complex, np.float64, np.complex128):
        return kind(value * (1 + SIZE * rng.uniform(-1, 1)))
    if isinstance(value, np.ndarray) and value.dtype in (np.float64, np.complex128):
        return np.asarray(value * (1 + SIZE * rng.uniform(-1, 1, value.shape)))
    if is_sparse(kind):
        copied = value.copy()
        copied.data = perturbed(value.data, rng)
        return copied
    if kind in (list, tuple):
        return kind(perturbed(each, rng) for each in value)
    if kind is dict:
        return {key: perturbed(each, rng) for key, each in value.items()}
    fields = fields_of(kind) or ()
    changed = {name: perturbed(getattr(value, name), rng) for name in fields}
    try:
        return kind(**changed) if fields else value
    except ValueError:
        return value
