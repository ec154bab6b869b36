"""The drive that runs through lesson 11: each of the student's functions improves it, and the text says by how much."""

import re

import numpy as np
import pytest

from nao_course.lessons.slam_on_the_field.one_drive import draw_one_drive, the_drive
from nao_course.lessons.slam_on_the_field.panel import ReplayPanel
from nao_course.lessons.slam_on_the_field.worlds import LANDMARKS
from nao_course.slam import range_and_bearing
from tests.lessons.every import quotes, text

TEXT = text("11")


def numbers(alt, title):
    """Return the wrong matches, and centimetres off, of a panel."""
    wrong, off = re.search(rf"{title}: (?:(\d+) of 98 [a-z ]+, )?off by (\d+) cm", alt).groups()
    return int(wrong or 0), int(off)


def test_in_metres_a_quarter_of_the_matches_is_wrong_and_the_text_says_what_associate_does(own):
    assert numbers(draw_one_drive().alt, "nearest in metres") == (23, 39)
    alt = draw_one_drive(associate=own["associate"]).alt
    (metres, _), (wrong, off), (jointly, _) = (
        numbers(alt, title) for title in ("nearest in metres", "your associate", "joint compatibility")
    )
    quotes(TEXT, f"{wrong} of 98", f"metres {metres}", f"{off} cm off")
    assert jointly == 0


def test_ranges_of_a_picture_are_too_long_together_and_the_replay_shows_where_nearest_neighbour_fails(own):
    drive, alike = the_drive(), []
    for (_, seen), pose, origins in zip(drive.log, drive.poses, drive.origins, strict=True):
        exact = range_and_bearing(pose, LANDMARKS)[list(origins), 1]
        off = np.array([each.range for each in seen]) - exact
        if len(off) > 1:
            alike.append(bool((off > 0).all() or (off < 0).all()))
    assert f"In {sum(alike)} of the {len(alike)} pictures with two or more landmarks" in TEXT
    text = ReplayPanel(own["associate"], own["joint_distance"]).summary()
    assert "Nearest neighbour: pair 3 is WRONG, 0.7 σ alone; 3 together: 4.0 σ." in text
    assert "Joint compatibility: pair 3 is right, 0.8 σ alone; 3 together: 1.5 σ." in text


@pytest.mark.slow
def test_the_drive_gets_better_method_by_method_and_the_text_says_so(own):
    alt = draw_one_drive(EkfSlam=own["EkfSlam"]).alt
    titles = ("move", "move, use_compass", "your EkfSlam", "your EkfSlam, jointly")
    ends = [numbers(alt, title) for title in titles]
    assert [off for _, off in ends] == [39, 17, 11, 1] and ends[-1][0] == 0
    quotes(TEXT, "39 cm", "17 cm", "11 cm", f"{ends[2][0]} of 98", "1 cm")
    graph = draw_one_drive(EkfSlam=own["EkfSlam"], GraphSlam=own["GraphSlam"]).alt
    off = numbers(graph, "your GraphSlam, jointly")[1]
    quotes(TEXT, f"{off} cm off")


def test_what_is_not_written_yet_has_a_panel_that_says_so_and_an_answer_of_another_length_is_rejected(own):
    class Half(own["EkfSlam"]):
        def number(self, seen):
            raise NotImplementedError

    alt = draw_one_drive(EkfSlam=Half).alt
    assert "move, use_compass: off by 17 cm" in alt and "your EkfSlam: not written yet" in alt
    with pytest.raises(ValueError, match="need as many numbers"):
        draw_one_drive(associate=lambda *given: np.zeros(1, dtype=int))
