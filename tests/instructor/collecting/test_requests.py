"""Requests are found where notebooks are: in folders, platforms' zips and students' own zips."""

import pytest

from nao_course.homework import REQUEST
from nao_course.instructor.collecting.requests import LARGEST, request_files, requests_in
from nao_course.instructor.collecting.submissions import gather
from tests.handed_in import HSL, LESSONS, NOTEBOOK, packed, put

TEXT = "hue_mask: red is right\n"


def test_a_file_in_a_students_folder_is_that_students(tmp_path):
    folder = put(tmp_path / "in", f"ada/{REQUEST}", f"ben/{HSL}", content=TEXT.encode())
    assert request_files(folder, tmp_path, LESSONS, ()) == ({"ada": TEXT}, [])


@pytest.mark.parametrize("zipped", [False, True])
def test_a_file_in_a_students_zip_in_a_platforms_zip_is_found(tmp_path, zipped):
    mine = packed(tmp_path / "mine.zip", {HSL: NOTEBOOK, REQUEST: TEXT.encode()})
    name = "Ada Lovelace_1234567_assignsubmission_file_/submission-20261120-101010.zip"
    if zipped:
        place = packed(tmp_path / "moodle.zip", {name: mine.read_bytes()})
    else:
        place = put(tmp_path / "in", name, content=mine.read_bytes())
    assert request_files(place, tmp_path, LESSONS, ()) == ({"Ada Lovelace_1234567": TEXT}, [])


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    folder = put(tmp_path / "in", f"ada/{REQUEST}", content=b"x" * (LARGEST + 1))
    put(folder, "ben/x.zip", content=b"PK no zip")
    texts, problems = request_files(folder, tmp_path, LESSONS, ())
    assert texts == {} and [each.split(":")[0] for each in problems] == ["ada", "ben"]


def test_a_path_that_is_no_folder_of_submissions_is_refused(tmp_path):
    with pytest.raises(ValueError, match="is not a folder of submissions"):
        request_files(put(tmp_path, "x.txt") / "x.txt", tmp_path, LESSONS, ())


def test_each_exercise_has_its_text_and_lines_before_the_first_are_named():
    text = "Hello!\nhue_mask : red,\n  see page 3: it says so\nrgb_to_hsl:\nwhy 0?\n"
    found, lost = requests_in(text, ["hue_mask", "rgb_to_hsl"])
    assert found == {"hue_mask": "red,\nsee page 3: it says so", "rgb_to_hsl": "why 0?"} and lost == [
        "Hello!"
    ]


def test_grading_does_not_list_a_request_as_left_out(tmp_path):
    folder = put(tmp_path / "in", f"ada/{HSL}", f"ada/{REQUEST}")
    (tmp_path / "scratch").mkdir()
    found = gather(folder, tmp_path / "scratch", LESSONS)
    assert len(found.submissions) == 1 and found.unknown == ()
