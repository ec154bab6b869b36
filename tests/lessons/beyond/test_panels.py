"""The panels of lesson 12: the distances of two cameras, and the exploration of a room."""

import pytest

from nao_course.lessons.beyond import ExplorePanel, MovesPanel, TwoCamerasPanel, planning
from nao_course.lessons.beyond.panels import MOVES
from nao_course.lessons.beyond.worlds import LANDMARKS
from tests.lessons.every import blank


def sigmas(panel):
    words = panel.summary().split()
    return float(words[words.index("camera") + 1]), float(words[words.index("both") + 1])


def known(panel):
    return float(panel.summary().partition(" moves ")[2].partition("%")[0])


@pytest.mark.slow
def test_more_pixels_help_both_cameras_and_without_tilt_one_is_better(cameras):
    panel = TwoCamerasPanel(*cameras)
    one, both = sigmas(panel)
    panel.set(tilt=0.0)
    still, still_both = sigmas(panel)
    assert still < 0.02 and still_both == pytest.approx(both, rel=0.2)
    panel.reset()
    panel.set(width=1280)
    assert sigmas(panel) == (pytest.approx(one, rel=0.1), pytest.approx(both / 4, rel=0.15))


def test_a_point_in_only_one_picture_is_said_to_be_so_and_the_known_part_grows_while_it_plays(cameras, own):
    panel = TwoCamerasPanel(*cameras)
    panel.set(distance=3.0, pitch=20.0)
    assert "both pictures" in panel.summary() and "not see" in panel.summary()
    assert "nan" not in panel.summary()
    assert "deviation: the" not in panel.summary(), "what is not seen has no standard deviation"
    assert panel.drawing().alt.startswith("How far is it?")
    panel = ExplorePanel(own["find_frontiers"], own["travel_steps"])
    parts = []
    for move in (0, 20, MOVES - 1):
        panel.set(move=move)
        parts.append(known(panel))
    assert parts == sorted(parts) and parts[-1] >= 99
    assert "with 3 frontier cells" in panel.summary()  # between boxes, where no way leads


@pytest.mark.slow
def test_a_function_that_was_mended_explores_anew(own):
    """What was driven by the old function is not shown as the new one's."""
    panel = ExplorePanel(own["find_frontiers"], own["travel_steps"])
    other = ExplorePanel(lambda grid: grid == 5, own["travel_steps"])
    panel.set(move=40)
    other._explored = panel._explored
    other.set(move=40)
    assert known(other) < known(panel) - 20 and "with 0 frontier cells" in other.summary()


def test_a_drive_is_of_the_lessons_table_and_other_rules_drive_elsewhere_also_without_a_choice(own, ekf):
    panel = MovesPanel(own["choose_move"], *ekf)
    panel.set(move=planning.MOVES, drive=3)
    contents, drive = panel.world.contents, planning.journey(own["choose_move"], ekf, 3)
    assert contents.truth.as_array() == pytest.approx(drive.truth[-1])
    assert contents.estimate.pose == drive.estimates[-1].pose
    said = f"deviation {100 * drive.sigmas[-1]:.0f} cm, off by {100 * drive.errors[-1]:.0f} cm"
    assert said in panel.summary()
    assert len(contents.paths["truth"]) == len(contents.paths["ekf"]) == planning.MOVES + 1
    places = {tuple(place) for place in LANDMARKS.round(9).tolist()}
    ends = [tuple(round(value, 9) for value in ray.point[:2]) for ray in contents.rays]
    assert len(ends) == len(drive.seen[-1]) and set(ends) <= places
    panel.set(rule="along the edge")
    assert contents.truth != panel.world.contents.truth
    panel.set(move=0, behind=True)
    assert "After 0 moves: standard deviation 0 cm" in panel.summary() and "0 landmarks" in panel.summary()

    panel = MovesPanel(blank, *ekf)
    panel.set(move=2)
    assert "Finish exercise 12.7" in panel.summary()
    panel.set(rule="in a circle")
    assert "After 2 moves" in panel.summary()
