"""Lesson 09's panel in a real browser: keys go a step on and back, and the player plays the steps."""

import pytest

from tests.browser.notebook_page import expect, panel_of, screenshot
from tests.paths import PROJECT

pytestmark = pytest.mark.browser

STUDENT = f"""from nao_course.exercises import load_definitions
from nao_course.lessons.pose_graphs import RelaxPanel

own = load_definitions({str(PROJECT / "solutions" / "09_pose_graphs.ipynb")!r})"""
PANEL = "RelaxPanel(linearize=own['linearize'], gauss_newton=own['gauss_newton'])"


def test_keys_step_on_and_back_and_the_player_goes_to_the_last_step(lab, page):
    root = panel_of(lab, page, "relax.ipynb", STUDENT, PANEL)
    expect(root, "odometry, chi2 123,111, off by 2.62 m.")
    slider = root.locator(".nao-slider-step .noUi-handle")
    slider.focus()
    page.keyboard.press("ArrowRight")
    expect(root, "Step 1: chi2")
    page.keyboard.press("ArrowRight")
    expect(root, "Step 2: chi2")
    page.keyboard.press("ArrowLeft")
    expect(root, "Step 1: chi2")
    screenshot(page, "pose_graphs", root)
    root.locator(".nao-do-forwards").click()
    expect(root, "Step 10: chi2")
    screenshot(page, "pose_graphs_end")
