"""Requests are found where notebooks are: in folders, platforms' zips and students' own zips."""

import pytest

from nao_course.homework import REQUEST
from nao_course.instructor.collecting.requests import LARGEST, AskedAbout, request_files, requests_in
from nao_course.instructor.collecting.roster import Roster
from nao_course.instructor.collecting.submissions import gather
from tests.handed_in import HSL, LESSONS, NOTEBOOK, packed, put

TEXT = "hue_mask: red is right\n"


def test_a_file_in_a_students_folder_or_zip_is_that_students(tmp_path):
    folder = put(tmp_path / "in", f"ada/{REQUEST}", f"ben/{HSL}", content=TEXT.encode())
    mine = packed(tmp_path / "mine.zip", {HSL: NOTEBOOK, REQUEST: TEXT.encode()}).read_bytes()
    moodle = "Ada L_1234567_assignsubmission_file_/submission-20261120-101010.zip"
    canvas = {f"lovelaceada_12_34_{REQUEST}": TEXT.encode(), f"bob_1_2_{HSL}": NOTEBOOK}
    late = {"lovelaceada_LATE_12_34_Regrade_Request-1.txt": TEXT.encode(), f"bob_1_2_{HSL}": NOTEBOOK}
    for place, student in (
        (folder, "ada"),
        (packed(tmp_path / "moodle.zip", {moodle: mine}), "Ada L_1234567"),
        (put(tmp_path / "moodle", moodle, content=mine), "Ada L_1234567"),
        (packed(tmp_path / "canvas.zip", canvas), "lovelaceada_12"),
        (packed(tmp_path / "late.zip", late), "lovelaceada_12"),
    ):
        assert request_files(place, tmp_path, LESSONS) == ({student: TEXT}, [])


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    folder = put(tmp_path / "in", f"ada/{REQUEST}", content=b"x" * (LARGEST + 1))
    put(folder, "ben/x.zip", content=b"PK no zip")
    put(folder, f"eve/{REQUEST}", content=b"\x00\x01\xff")
    texts, problems = request_files(folder, tmp_path, LESSONS)
    assert texts == {} and [student for student, _ in problems] == ["ada", "ben", "eve"]


def test_a_folder_that_may_be_a_students_asks_nothing_in_a_classmates_name(tmp_path):
    path = put(tmp_path / "in", f"Eve/Ada/{HSL}", f"Eve/Ben/{HSL}")
    put(path, f"Eve/Ada/{REQUEST}", f"Eve/Ben/{REQUEST}", content=TEXT.encode())
    texts, problems = request_files(path, tmp_path, LESSONS, Roster.of(["Ada", "Ben"]))
    assert texts == {} and len(problems) == 2 and all("may be a student's" in line for _, line in problems)
    put(path, f"Zoe/{HSL}", f"Zoe/{REQUEST}", content=TEXT.encode())
    texts, problems = request_files(path, tmp_path, LESSONS, Roster.of(["Ada", "Ben"]))
    assert texts == {"Zoe": TEXT} and all("several students" in line for _, line in problems)


def test_a_file_is_refused_and_grading_does_not_list_a_request_as_left_out(tmp_path):
    with pytest.raises(ValueError, match="is not a folder of submissions"):
        request_files(put(tmp_path, "x.txt") / "x.txt", tmp_path, LESSONS)
    found = gather(put(tmp_path / "in", f"ada/{HSL}", f"ada/{REQUEST}"), tmp_path / "scratch", LESSONS)
    assert len(found.submissions) == 1 and found.unknown == ()


EXERCISES = [
    AskedAbout("01_hsl_filtering", "1.4", "hue_mask"),
    AskedAbout("01_hsl_filtering", "1.1", "rgb_to_hsl"),
    AskedAbout("02_goal_posts", "2.1", "find_posts"),
]
RED = "r\u00f6d is right,"
FORMS = (
    *("{}: ", "{} :", "  {}:\t", "{}\uff1a", "* {}: ", "- `{}`: ", "\u2022 **{}**: ", '"{}": ', "{}(): "),
    *("1.4 {}: ", "01:{}: ", "Exercise 1.4 {}: ", "lesson 01 {}: ", "1) {}: "),
)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["hue_mask", "Hue_Mask", "hue mask", "HUE-MASK"])
def test_a_request_is_read_however_it_is_written(tmp_path, form, name):
    text = f"{form.format(name)}{RED}\r\n  see page 3: it says so\r\n1.1: why 0?\r\n"
    said = {"hue_mask": f"{RED}\nsee page 3: it says so", "rgb_to_hsl": "why 0?"}
    for encoding in ("utf-8", "utf-8-sig", "utf-16", *(["cp1252"] if "\uff1a" not in text else [])):
        folder = put(tmp_path / "in", f"ada/{REQUEST}", content=text.encode(encoding))
        (read,) = request_files(folder, tmp_path, LESSONS)[0].values()
        found = {("01_hsl_filtering", key): value for key, value in said.items()}
        assert requests_in(read, EXERCISES) == (found, [])


@pytest.mark.parametrize(
    "line", ["nosuch: please", "hue_mas: please", "1.9: please", "02:hue_nask: please", "Find Post: x"]
)
def test_a_line_about_no_exercise_is_named_and_not_added_to_the_reason_above(line):
    found, lost = requests_in(f"hue_mask: red\n{line}\nand more", EXERCISES)
    assert found == {("01_hsl_filtering", "hue_mask"): "red"}
    assert len(lost) == 1 and line[:6] in lost[0]
    assert requests_in("Hello!\nhue_mask: red", EXERCISES)[1] != []
