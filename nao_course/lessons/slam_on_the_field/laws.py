"""What an answer of lesson 11 has to obey, whatever its values are."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_course.exercises import register


@register
def whole_numbers(args: tuple[Any, ...], kwargs: dict[str, Any], answer: Any) -> str:
    """Refuse floats where numbers of landmarks are wanted: a later cell counts with them."""
    numbers = np.asarray(answer)
    if numbers.size and numbers.dtype.kind not in "iu":
        return "your numbers are right, but floats: what looks up landmarks has to be whole, as np.full(m, -1) is"
    return ""
