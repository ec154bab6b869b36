"""Lesson 04's panels in a real browser: a photo is uploaded and clicked on, and a slider moves points on the map."""

import numpy as np
import pytest
from PIL import Image

from nao_course.lessons.distance.phone.photo import SIZE
from nao_course.lessons.distance.phone.sheet import CLICKED, usual_phone, usual_photo
from tests.browser.lab import wait_for
from tests.browser.notebook_page import expect, panel_of, screenshot
from tests.paths import PROJECT

pytestmark = pytest.mark.browser

STUDENT = f"""from nao_course.exercises import load_definitions
from nao_course.lessons.distance import PhoneLab, TiltPanel

own = load_definitions({str(PROJECT / "solutions" / "04_distance.ipynb")!r})"""
TILT = "TiltPanel(*(own[name] for name in ('pixel_to_ground', 'ground_to_measurement', 'measurement_covariance')))"
PHONE = """import numpy as np

PhoneLab(lambda picture: np.array([[133.6, 79.0], [187.8, 76.9]]), own["pixel_to_ground"])"""


def upload(page, root, file):
    with page.expect_file_chooser() as chosen:
        root.locator(".jupyter-widget-fileupload, .widget-upload").first.click()
    chosen.value.set_files(file)


def test_a_photo_is_uploaded_its_corners_are_clicked_and_landmarks_stand_on_the_map(lab, page, tmp_path):
    root = panel_of(lab, page, "phone.ipynb", STUDENT, PHONE)
    expect(root, "This is a simulated photo")
    written = Image.Exif()
    written.get_ifd(0x8769)[0xA405] = 27
    Image.fromarray(usual_photo()).save(tmp_path / "IMG_0001.jpg", quality=92, exif=written)
    upload(page, root, tmp_path / "IMG_0001.jpg")
    expect(root, "The file gives a focal length of 27 mm. Click the corner A")
    view, pose = usual_phone()
    for letter, (u, v) in zip(
        CLICKED, view.at_size(SIZE).project(np.array(list(CLICKED.values())), pose), strict=True
    ):
        picture, mark = root.locator(".nao-pad-over").first, root.locator(".nao-cursor").first
        box, before = picture.bounding_box(), mark.get_attribute("style")
        picture.click(
            position={"x": (u + 0.5) / SIZE[0] * box["width"], "y": (v + 0.5) / SIZE[1] * box["height"]}
        )
        # JupyterLab keeps a change back while the kernel works on an earlier one: the letter would come before it.
        wait_for(lambda before=before, mark=mark: mark.get_attribute("style") != before, "the clicked pixel")
        said = root.inner_text()
        root.locator(f".nao-do-{letter.lower()}").click()
        wait_for(lambda said=said: root.inner_text() != said, "the next letter")
    expect(root, "From the four letters, the phone was 3")
    expect(root, "post at (3, 0.7)")
    expect(root, "post at (3, -0.7)")
    screenshot(page, "phone_lab", root)
    (tmp_path / "notes.txt").write_text("no picture")
    upload(page, root, tmp_path / "notes.txt")
    expect(root, "This file cannot be read as a picture")


def test_the_tilt_slider_moves_all_points(lab, page):
    root = panel_of(lab, page, "tilt.ipynb", STUDENT, TILT)
    expect(root, "+0.")
    handle = root.locator(".noUi-handle, .ui-slider-handle").first
    handle.focus()
    for _ in range(25):
        page.keyboard.press("ArrowLeft")
    expect(root, "-0.")
    screenshot(page, "tilt_panel", root)
