"""Laws of the standard sets of scenes."""

from itertools import product

import numpy as np
import pytest

from nao_course.sim import Reality, standard_scenes
from nao_course.sim.render import GREEN, render
from nao_course.sim.scenes import standard_scene

SMALL = (80, 60)


@pytest.fixture(scope="module")
def sets():
    """Of half the usual size: four times as quickly drawn, and of the same places."""
    return {which: standard_scenes(which, (160, 120)) for which in ("tune", "report")}


def corners(scene):
    return [m for m in scene.truth.landmarks if m.landmark.kind == "corner" and not m.occluded]


@pytest.fixture
def realities(monkeypatch):
    """How real the pictures were to be, in their order; only the first is drawn, and stands for all."""
    seen, drawn = [], []

    def recorded(field, pose, view, reality, rng):
        seen.append(reality)
        drawn[:] = drawn or [render(field, pose, view, Reality.clean(), rng)]
        return drawn[0]

    monkeypatch.setattr("nao_course.sim.scenes.render", recorded)
    return seen


@pytest.mark.slow
def test_two_calls_give_the_same_bytes_and_the_sets_share_no_picture(sets):
    for number in range(0, 30, 6):  # one in each room
        once, again = sets["tune"][number], standard_scene("tune", number, (160, 120))
        assert again.pixels.tobytes() == once.pixels.tobytes()
        assert again.view == once.view
    every = [s.pixels.tobytes() for scenes in sets.values() for s in scenes]
    assert len(set(every)) == len(every) == 60
    poses = [tuple(s.truth.pose.as_array()) for scenes in sets.values() for s in scenes]
    assert len(set(poses)) == 60


def test_no_set_shares_a_room_with_another_and_paper_lies_on_the_whole_field_alone(realities):
    rooms = {}
    for which, seed in product(("tune", "report", "whole_tune", "whole"), range(2)):
        realities.clear()
        standard_scenes(which, (8, 6), Reality(seed=seed))
        rooms[which, seed] = [each.seed for each in realities]
    for (which, _), seeds in rooms.items():
        assert (len(seeds), len(set(seeds))) == ((60, 10) if "whole" in which else (30, 5))
    every = [room for seeds in rooms.values() for room in set(seeds)]
    assert len(every) == len(set(every)) == 60
    papered = {}
    for which in ("tune", "report", "whole_tune", "whole"):
        realities.clear()
        standard_scenes(which, (8, 6))
        papered[which] = {each.sheets > 0 for each in realities}
    assert papered == {"tune": {False}, "report": {False}, "whole_tune": {True}, "whole": {True}}


@pytest.mark.slow
def test_the_whole_field_is_seen_from_both_halves_to_all_sides_and_its_two_sets_share_no_place():
    one, other = (standard_scenes(which, (8, 6), Reality.clean()) for which in ("whole_tune", "whole"))
    assert not {s.truth.pose for s in one} & {s.truth.pose for s in other}
    for scenes in (one, other):
        x, y, heading = np.array([s.truth.pose.as_array() for s in scenes]).T
        assert x.min() < -2.0 and x.max() > 2.0 and np.abs(y).max() > 1.5
        assert np.abs(np.mean(np.exp(1j * heading))) < 0.3
        seen = [m.landmark.x for s in scenes for m in s.truth.landmarks]
        assert (min(seen), max(seen)) == (-3.0, 3.0)
        assert any(not s.truth.landmarks for s in scenes)


@pytest.mark.slow
def test_a_set_shows_as_many_corners_as_real_pictures_and_the_body_leans(sets):
    for scenes in sets.values():
        # 128 marked on 64 pictures, 94 on 30
        assert 1.6 <= np.mean([len(corners(s)) for s in scenes]) <= 3.4
        assert all(any(m.landmark.kind != "cross" for m in s.truth.landmarks) for s in scenes)
        assert np.mean([(s.truth.labels == GREEN).mean() for s in scenes]) == pytest.approx(0.6, abs=0.1)
    lean = [s.truth.view.pitch - s.view.pitch for s in sets["tune"]]
    assert 0.5 < np.degrees(np.std(lean)) < 1.6
    usual = standard_scene("tune", 0)
    assert usual.view.size == usual.truth.view.size == (320, 240)


@pytest.mark.slow
def test_places_depend_neither_on_size_nor_on_how_real_the_picture_is(sets):
    for other in (standard_scenes("tune", SMALL), standard_scenes("tune", SMALL, Reality.clean())):
        assert [s.truth.pose for s in other] == [s.truth.pose for s in sets["tune"]]
        assert other[0].pixels.shape == (60, 80, 3)


def test_another_seed_gives_other_places_and_another_name_is_refused_with_those_there_are():
    one, other = (standard_scenes("report", SMALL, Reality.clean(seed)) for seed in (0, 1))
    assert not {s.truth.pose for s in one} & {s.truth.pose for s in other}
    for which in ("test", None):
        with pytest.raises(ValueError, match='"tune", "report", "whole_tune" or "whole", got'):
            standard_scenes(which)
