"""Gathering submissions as every test of collecting does."""

import tempfile
from pathlib import Path

import pytest

from nao_course.instructor.collecting.files import read
from nao_course.instructor.collecting.submissions import gather
from tests.handed_in import LESSONS


@pytest.fixture
def look(tmp_path):
    """Gather, and see that nothing is written outside of the scratch folder."""

    def gathered(path, lessons=LESSONS):
        scratch = Path(tempfile.mkdtemp(prefix="scratch", dir=tmp_path))
        before = {each for each in tmp_path.rglob("*") if scratch not in each.parents}
        found = gather(path, scratch, lessons)
        assert {each for each in tmp_path.rglob("*") if scratch not in each.parents} == before
        for submission in found.submissions:
            assert read(submission).digest
        return found

    return gathered
