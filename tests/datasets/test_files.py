"""Where the recordings are is said by a variable or by their place, and what is missing is said with what to do."""

import os

import pytest

from nao_course.datasets import data_folder, files


def test_the_data_folder_is_named_by_a_variable_or_beside_the_project_or_missing(tmp_path, monkeypatch):
    monkeypatch.setenv("NAO_COURSE_DATA", str(tmp_path))
    assert data_folder() == tmp_path
    monkeypatch.delenv("NAO_COURSE_DATA", raising=False)
    monkeypatch.setattr(files, "__file__", str(tmp_path / "project" / "nao_course" / "datasets" / "files.py"))
    with pytest.raises(FileNotFoundError, match="NAO_COURSE_DATA is not set"):
        data_folder()
    (tmp_path / "shared" / "data").mkdir(parents=True)
    assert os.path.samefile(data_folder(), tmp_path / "shared" / "data")
    monkeypatch.setenv("NAO_COURSE_DATA", str(tmp_path / "nowhere"))
    with pytest.raises(FileNotFoundError, match=r"(?s)nowhere.*set the environment variable.*amsterdam_2013"):
        data_folder()
