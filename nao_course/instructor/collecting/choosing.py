"""Notebooks of submissions, inspected without running them."""

from collections.abc import Iterator

from nao_course.exercises.answered import Inspection, inspect_content
from nao_course.exercises.notebook_text import MOST_BYTES
from nao_course.exercises.outline import read_outline
from nao_course.instructor.collecting.archives import LARGEST_READ, Item, Refused
from nao_course.instructor.sandbox.large_notebooks import without_outputs
from nao_course.instructor.sandbox.layers import SandboxError
from nao_course.instructor.sandbox.protocol import Allowance, Ended, ServerEnded

NOT_INSPECTED = Inspection("", 1)


def inspect_notebook(item: Item, lesson: str) -> Inspection:
    """Read a notebook of a student and count its answers; none of its code runs.

    A large notebook is parsed by a process of its own, because that takes several times its size in memory.
    """
    file = f"{lesson}.ipynb"
    try:
        content = item.content(MOST_BYTES)
        short = content if len(content) <= LARGEST_READ else _shortened(file, content)
    except Refused as refused:
        return Inspection(str(refused), -1)
    return inspect_content(file, short, read_outline(lesson), content)


def _shortened(file: str, content: bytes) -> bytes:
    """Return a large notebook without its outputs."""

    def parts() -> Iterator[bytes]:
        for start in range(0, len(content), 2**20):
            yield content[start : start + 2**20]

    try:
        return without_outputs(file, len(content), parts(), None, Allowance())
    except Ended as ended:
        raise Refused(ended.outcome.text) from None
    except (SandboxError, ServerEnded) as error:
        raise Refused(str(error)) from None
