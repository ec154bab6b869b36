"""Pictures of lesson 03: which corners are in them, and where the goal line is."""

import numpy as np
import pytest

from nao_course.lessons.hough_corners import scenes
from nao_course.lessons.hough_corners.scenes import (
    PLACES,
    goal_line_at,
    match_pictures,
    real_pictures,
    three_places,
    tuning_pictures,
)


@pytest.mark.slow
def test_the_tuning_pictures_have_61_corners_that_the_text_counts():
    pictures = tuning_pictures()
    assert (len(pictures), sum(len(each.truth.corners) for each in pictures)) == (30, 61)
    assert tuning_pictures() is pictures, "they are made once"


def test_the_truth_finds_every_corner_and_nobody_can_paint_on_the_pictures_and_places():
    assert list(three_places()) == list(PLACES) and three_places() is three_places()
    with pytest.raises(ValueError, match="read-only"):
        next(iter(three_places().values())).pixels[0] = 0
    pictures = tuning_pictures()[:3]
    truth = {id(each): each.truth.corners for each in pictures}
    assert all(each.match(truth[id(each)]).found.all() for each in pictures)
    matches = match_pictures(lambda pixels: [], pictures)
    assert [match.missed for match in matches] == [len(each.truth.corners) for each in pictures]
    before = tuning_pictures()[0].pixels.copy()

    def spoils(pixels):
        pixels[:] = 0
        return []

    match_pictures(spoils, tuning_pictures()[:1])
    assert (tuning_pictures()[0].pixels == before).all()


def test_the_goal_line_is_white_where_it_is_said_to_be_and_its_share_is_that_of_its_columns_with_white():
    for picture in goal_line_at([1.5, 2.5]):
        column = picture.pixels[:, 160].astype(int)
        rows = column[picture.rows]
        assert rows.min(axis=1).max() > 150, "white"
        above = column[picture.rows.start - 5 : picture.rows.start]
        assert (above[:, 1] > above[:, 0] + 20).all() and (above[:, 1] > above[:, 2] + 20).all(), "green"
    (picture,) = goal_line_at([2.0])
    labels = np.zeros((240, 320), dtype=np.uint8)
    assert picture.share(labels) == 0.0
    labels[picture.rows.start, 140:150] = 3
    assert picture.share(labels) == 0.25
    labels[: picture.rows.start - 1] = 3
    assert picture.share(labels) == 0.25, "white elsewhere does not count"


def test_of_the_real_pictures_eight_with_a_larger_version_are_taken_or_none(data_dir, monkeypatch):
    monkeypatch.setenv("NAO_COURSE_DATA", str(data_dir))
    pictures = real_pictures()
    assert (len(pictures), sum(len(each.truth.corners) for each in pictures)) == (8, 10)

    def nowhere(name):
        raise FileNotFoundError("not here")

    monkeypatch.setattr(scenes, "read_pictures", nowhere)
    assert real_pictures() == ()
