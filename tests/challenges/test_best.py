"""The best score so far: kept in a file that may have become anything."""

import json
import os
from dataclasses import replace

import pytest

from nao_course.challenges.best import Best, BestFile
from tests.challenges.example import CHALLENGE, COST


@pytest.fixture
def file(tmp_path):
    return BestFile(CHALLENGE, tmp_path)


def test_the_best_is_kept_and_a_worse_one_changes_nothing_and_columns_of_no_challenge_are_not_read(file):
    assert file.read() == (None, "")
    for score in (0.5, 0.8, 0.6):
        assert file.keep(Best(score, 0.1, {"off": 0.2})) == ""
    assert file.read() == (Best(0.8, 0.1, {"off": 0.2}), "")
    assert [each.name for each in file.path.parent.iterdir()] == ["77_doubling.challenge.json"]
    file.path.write_text(json.dumps({"score": 1, "worst": 0, "columns": {"<b>": "hello", "off": 0.5}}))
    assert file.read() == (Best(1.0, 0.0, {"off": 0.5}), "")


def test_of_a_cost_the_smallest_is_the_best_and_the_file_stands_beside_the_notebook(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert BestFile(CHALLENGE).path == tmp_path / "77_doubling.challenge.json"
    file = BestFile(COST, tmp_path)
    for score in (0.5, 0.8, 0.4):
        file.keep(Best(score, 1.0, {}))
    assert file.read()[0].score == 0.4


@pytest.mark.parametrize(
    "content",
    [
        b"\xff\xfe\x00",
        b"no json",
        b'{"score": 1}',
        b'{"score": NaN, "worst": 0, "columns": {}}',
        b'{"score": true, "worst": 0, "columns": {}}',
        b'{"score": 0.5, "worst": 0, "columns": {"off": "<script>"}}',
        b'{"score": 1' + b"0" * 9000 + b', "worst": 0, "columns": {}}',
        b"[" * 90_000,
        b'{"score": 1, "worst": 0, "columns": {}}' + b" " * 200_000,
    ],
    ids=lambda content: str(content[:24]),
)
def test_a_file_that_holds_something_else_is_set_aside_and_nothing_is_lost(file, content):
    file.path.write_bytes(content)
    best, remark = file.read()
    aside = file.path.with_name("77_doubling.challenge.json.old-1")
    assert best is None and aside.name in remark and aside.read_bytes() == content
    file.keep(Best(0.5, 0.1, {}))
    file.path.write_bytes(content)
    assert "old-2" in file.read()[1]


def test_a_score_of_another_scoring_is_set_aside_with_one_sentence(file):
    file.keep(Best(0.8, 0.1, {}))
    kept = file.path.read_bytes()
    changed = BestFile(replace(CHALLENGE, version=2), file.path.parent)
    best, remark = changed.read()
    assert best is None and "the challenge is now scored differently" in remark and "starts again" in remark
    assert file.path.with_name("77_doubling.challenge.json.old-1").read_bytes() == kept
    changed.keep(Best(0.5, 0.1, {}))
    assert BestFile(changed.challenge, file.path.parent).read() == (Best(0.5, 0.1, {}), "")
    # Files from before scorings had versions are of the first.
    file.path.write_text('{"score": 0.5, "worst": 0, "columns": {}}')
    assert file.read()[0] == Best(0.5, 0.0, {})


def test_a_folder_in_its_place_is_set_aside_and_a_score_kept_by_another_notebook_is_not_lost(file):
    file.path.mkdir()
    assert "it is not a file" in file.read()[1]
    if hasattr(os, "mkfifo"):
        os.mkfifo(file.path)
        assert "it is not a file" in file.read()[1]
    file.keep(Best(0.5, 0.1, {}))
    assert BestFile(CHALLENGE, file.path.parent).read() == (Best(0.5, 0.1, {}), "")
    other = BestFile(CHALLENGE, file.path.parent)
    file.read()
    other.keep(Best(0.9, 0.1, {}))
    file.keep(Best(0.5, 0.1, {}))
    assert file.read()[0].score == 0.9


def test_a_file_that_can_neither_be_read_nor_moved_is_never_written_over(file, monkeypatch):
    def refuse(*paths):
        raise PermissionError

    file.path.write_bytes(b"no json")
    monkeypatch.setattr(os, "rename", refuse)
    assert "it stays unchanged" in file.keep(Best(0.5, 0.1, {}))
    assert file.path.read_bytes() == b"no json"
    assert "not be stored" in BestFile(CHALLENGE, file.path.parent / "nowhere").keep(Best(0.5, 0.1, {}))
