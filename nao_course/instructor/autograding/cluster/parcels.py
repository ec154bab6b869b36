"""Submissions and assignments with the content of their files, so that a worker needs no folder of the grader's."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from nao_course.exercises.notebook_text import LARGEST_HELPER, MOST_BYTES
from nao_course.instructor.autograding.assignment import Assignment
from nao_course.instructor.collecting.archives import Refused, read_plain
from nao_course.instructor.collecting.submissions import Submission


@dataclass(frozen=True)
class SubmissionParcel:
    """A submission with the content of its files, as handed in, and of the student's earlier work, in its order.

    The submission's paths are the grader's and mean nothing elsewhere. A file that cannot be read is its reason to be
    refused.
    """

    submission: Submission
    notebook: bytes = b""
    helpers: tuple[bytes, ...] = ()
    earlier: tuple[SubmissionParcel, ...] = ()

    @classmethod
    def of(cls, submission: Submission) -> SubmissionParcel:
        """Read a submission's files, each of a bounded size and none through a link."""
        if submission.reason:
            return cls(submission)
        try:
            notebook = read_plain(submission.path, MOST_BYTES)
            helpers = tuple(read_plain(path, LARGEST_HELPER) for _, path in submission.helpers)
        except Refused as refused:
            return cls(replace(submission, reason=str(refused)))
        return cls(submission, notebook, helpers, tuple(map(cls.of, submission.earlier)))

    @property
    def size(self) -> int:
        """Number of bytes of all its files."""
        own = len(self.notebook) + sum(map(len, self.helpers))
        return own + sum(each.size for each in self.earlier)

    @contextmanager
    def laid_out(self) -> Iterator[Submission]:
        """Write the files into a folder that is deleted in any case."""
        with tempfile.TemporaryDirectory(prefix="nao_course_", ignore_cleanup_errors=True) as folder:
            yield self._written_to(Path(folder))

    def _written_to(self, folder: Path) -> Submission:
        """Write the files under names of our own, because students chose theirs."""
        (notebook := folder / "notebook").write_bytes(self.notebook)
        helpers, earlier = [], []
        for number, ((name, _), content) in enumerate(
            zip(self.submission.helpers, self.helpers, strict=False)
        ):
            (path := folder / f"helper{number}").write_bytes(content)
            helpers.append((name, path))
        for number, each in enumerate(self.earlier):
            (inside := folder / f"earlier{number}").mkdir()
            earlier.append(each._written_to(inside))
        return replace(self.submission, path=notebook, helpers=tuple(helpers), earlier=tuple(earlier))


@dataclass(frozen=True)
class AssignmentParcel:
    """An assignment with the content of its solution notebooks: a worker needs neither the solutions nor the secret.

    Its paths are the grader's and mean nothing elsewhere; `earlier` are in the assignment's order.
    """

    assignment: Assignment
    reference: bytes
    earlier: tuple[bytes, ...]

    @classmethod
    def of(cls, assignment: Assignment) -> AssignmentParcel:
        """Read an assignment's solution notebooks."""
        earlier = tuple(each.reference.read_bytes() for each in assignment.earlier)
        return cls(assignment, assignment.reference.read_bytes(), earlier)

    def written_to(self, folder: Path) -> Assignment:
        """Write the notebooks into a folder, unless they are there."""
        folder.mkdir(exist_ok=True)
        kept = self.assignment
        paths = [folder / f"{lesson}.ipynb" for lesson in (kept.lesson, *(it.lesson for it in kept.earlier))]
        for path, content in zip(paths, (self.reference, *self.earlier), strict=True):
            if not path.exists():
                path.write_bytes(content)
        earlier = [replace(each, reference=path) for each, path in zip(kept.earlier, paths[1:], strict=True)]
        return replace(kept, reference=paths[0], earlier=tuple(earlier))


def unpacked(parcel: AssignmentParcel) -> AssignmentParcel:
    """Return an assignment as it is: as a task of its own, Dask carries it once to each worker that needs it."""
    return parcel
