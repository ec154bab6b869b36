"""Recorded labels of lesson 02's pictures, for students whose lesson 01 is not finished."""

from __future__ import annotations

from pathlib import Path

from nao_course.datasets.recorded_labels import Pixels, RecordedLabels
from nao_course.geometry import Pose
from nao_course.lessons.goalposts.scenes import approach, robot_before, scenes_by_distance, turning_head
from nao_course.sim import Field, Reality, SimulatedNao

_NOTE = (
    "Your labels of lesson 01 are not usable yet, so the pictures of this lesson have recorded labels. They do not "
    "change with GREEN and YELLOW. The control panel and the challenge need your own labels."
)


def lesson_pictures() -> list[Pixels]:
    """Return every picture that the lesson labels, in the lesson's order."""
    nao = SimulatedNao(Field(2012), Pose(0.6, 0.5, -0.25), rng=41)
    pictures = [nao.take_picture("bottom").pixels, *turning_head().values()]
    pictures += [scene.pixels for seed in (0, 1) for scene in scenes_by_distance(seed=seed)]
    near, far = approach([0.9, 0.7, 0.55], Reality(seed=11)), approach([2.0], Reality(seed=11))[0]
    return [*pictures, *(scene.pixels for scene in near), robot_before(far.pixels, far.nearest)]


_LABELS = RecordedLabels(Path(__file__).with_name("labels.npz"), lesson_pictures, _NOTE)
record, recorded_labels, or_recorded = _LABELS.record, _LABELS.find, _LABELS.or_recorded
