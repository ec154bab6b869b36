"""What a cell says is read from any file, whoever wrote it."""

import nbformat
import pytest

from nao_course.exercises.cells import grade_id, is_graded, is_solution, metadata, source_of

GRADING = {"grade_id": "hue_mask", "solution": True, "grade": False}


@pytest.mark.parametrize("kind", [dict, nbformat.from_dict])
def test_a_cell_of_json_and_one_of_nbformat_say_the_same(kind):
    cell = kind({"metadata": {"nbgrader": GRADING}, "source": "x = 1"})
    assert metadata(cell, "nbgrader") == GRADING and metadata(cell, "nao_course") == {}
    assert (grade_id(cell), is_solution(cell), is_graded(cell)) == ("hue_mask", True, False)


def test_a_source_is_one_text_however_the_file_holds_it_and_metadata_of_another_kind_say_nothing():
    for held in [None, 5, [], "nbgrader", {"nbgrader": None}, {"nbgrader": [1]}, {"nbgrader": "x"}]:
        cell = {"metadata": held}
        assert metadata(cell, "nbgrader") == {} == metadata({}, "nbgrader")
        assert grade_id(cell) == "" and not is_solution(cell) and not is_graded(cell)
    for text in ["a\nb", ["a\n", "b"]]:
        assert source_of({"source": text}) == "a\nb"
        assert source_of({}) == source_of({"source": None}) == ""
