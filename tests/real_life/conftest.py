"""The warm server of the grader's tests."""

from tests.instructor.conftest import warm_server

__all__ = ["warm_server"]

# It imports what all lessons use, in the process that other processes are forked from.
collect_ignore = ["preloaded.py"]
