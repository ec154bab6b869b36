"""The stage of lesson 10 in the student's robot: it tries settings while it drives and uses the best one so far."""

from __future__ import annotations

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.colours import GREEN, YELLOW, mean_lightness
from nao_course.geometry import as_points
from nao_course.lessons.experiments.paper_table import PICTURES, SETTINGS, Setting, say_setting
from nao_course.lessons.experiments.resampling import as_table
from nao_course.lessons.experiments.scenes import simulated_scene
from nao_course.robot import Robot
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction

EVERY = 3  # pictures until the next setting is tried: with more tries the robot would have to wait
TRIES = tuple((number, setting) for number in range(PICTURES) for setting in SETTINGS)


def _tune_and_look(student: StudentCode, nao: Robot) -> StageFunction:
    """Try the 27 settings on scene after scene during the drive, and find corners with the best setting so far."""
    costs: dict[Setting, list[float]] = {setting: [] for setting in SETTINGS}
    pictures = tried = 0

    def tune() -> tuple[Setting, int]:
        nonlocal pictures, tried
        wanted = min(len(SETTINGS) + pictures // EVERY, len(TRIES))  # the first scene at once
        for number, (beta, gap, length) in TRIES[tried:wanted]:
            table = as_table(student.grid_search([simulated_scene(number)], [beta], [gap], [length]))
            for setting, each in table.items():
                costs[setting].extend(each.tolist())
            tried += 1
        pictures += 1
        scenes = tried // len(SETTINGS)
        return min(costs, key=lambda setting: float(np.mean(costs[setting][:scenes]))), scenes

    def look(frame: Frame) -> Overlay:
        setting, scenes = tune()
        beta, gap, length = setting
        pixels = frame.picture.pixels
        labels = student.color_labels(
            pixels, GREEN, YELLOW, student.white_threshold(mean_lightness(pixels), beta)
        )
        corners = as_points(student.find_corners(labels, gap, length), name="corners (u, v)")
        found, on = say_count(len(corners), "corner"), say_count(scenes, "scene")
        text = f"{found} with {say_setting(setting)}, your best on {on}"
        return Overlay(corners, pixels=corners, text=text)

    return look


STAGE = Stage(
    name="corners, best setting",
    lesson="10_experiments",
    uses=("grid_search", "01:color_labels", "01:white_threshold", "03:find_corners"),
    wire=_tune_and_look,
)
