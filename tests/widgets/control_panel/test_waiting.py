"""Commands wait in their order; too many are left out, and said to be."""

from nao_course.slam import Motion
from nao_course.widgets.control_panel.waiting import MOST_WAITING, WaitingMotions


def test_motions_come_out_as_they_went_in_and_one_too_many_is_left_out_and_said_until_there_is_room():
    waiting = WaitingMotions()
    motions = [Motion(0.2, 0.0), Motion(0.2, 0.0), Motion(0.0, 0.5)]
    for motion in motions:
        waiting.add(motion)
    assert waiting.text() == "Then: Walk 0.20 m ahead (2 times); Turn 29° left."
    assert [waiting.take() for _ in range(4)] == [*motions, None]
    assert waiting.text() == ""
    for _ in range(MOST_WAITING):
        waiting.add(Motion(0.2, 0.0))
    assert "ignored" not in waiting.text()
    waiting.add(Motion(-0.2, 0.0))
    assert "ignored" in waiting.text() and "back" not in waiting.text()
    waiting.take()
    assert "ignored" not in waiting.text()
    waiting.clear()
    assert waiting.take() is None


def test_by_itself_it_takes_what_the_code_says_after_what_waits_and_ends_with_nothing():
    said = [Motion(0.3, 0.0), Motion(0.0, 0.0), Motion(0.3, 0.0)]
    waiting = WaitingMotions(lambda: said.pop(0))
    assert waiting.take() is None and len(said) == 3  # nobody asked for it
    waiting.by_itself = True
    waiting.add(Motion(0.0, 0.5))
    assert [waiting.take() for _ in range(2)] == [Motion(0.0, 0.5), Motion(0.3, 0.0)]
    assert waiting.take() is None and not waiting.by_itself  # a motion of nothing would never end
    waiting.by_itself = True
    waiting.clear()
    assert waiting.take() is None and len(said) == 1
