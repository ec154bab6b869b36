"""Places of a challenge: names, and pictures that are the same at every call."""

from nao_course.challenges.rooms import places

ROOMS = {"dark": (3, 5), "harsh": (4,)}


def test_places_are_counted_by_preset_and_have_names_of_their_own():
    names = [str(place) for place in places(ROOMS, 2)]
    assert names == ["dark 1", "dark 2", "dark 3", "dark 4", "harsh 1", "harsh 2"]


def test_a_place_gives_the_first_picture_that_will_do_the_same_each_time_and_another_by_stream():
    place = places(ROOMS, 2)[3]
    seen = []

    def second(scene):
        seen.append(scene)
        return len(seen) == 2

    scene = place.scene(second)
    assert scene is seen[1] and (place.reality.seed, place.number) == (5, 1)
    assert (place.scene(lambda scene: True).pixels == seen[0].pixels).all()
    before = places(ROOMS, 2)[2]  # the other one in this room
    assert (before.scene(lambda scene: True).pixels != seen[0].pixels).any()
    assert (place.scene(lambda scene: True, stream=[2]).pixels != seen[0].pixels).any()
