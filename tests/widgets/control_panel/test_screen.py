"""The pictures on the control panel: when each is taken, sent and waited for."""

from nao_course.sim import Truth
from nao_course.widgets import ControlPanel
from tests.widgets.robots import clean_nao


def test_a_step_takes_one_picture_with_each_camera_and_sends_the_chosen_one_before_it_takes_the_other():
    nao = clean_nao()
    panel = ControlPanel(nao, Truth(nao))
    images, done = panel._controls.images, []
    take = panel.cockpit.photograph
    panel.cockpit.photograph = lambda camera: done.append(f"take {camera}") or take(camera)
    for camera, image in images.items():
        image.observe(lambda change, camera=camera: done.append(f"send {camera}"), "value")
    panel.forward(0.05)
    assert done == ["take bottom", "send bottom", "take top", "send top"]
    panel.camera = "top"
    done.clear()
    panel.forward(0.05)
    assert done == ["take top", "send top", "take bottom", "send bottom"]


def test_a_drive_waits_for_the_chosen_picture_only_and_never_for_one_that_the_page_already_shows():
    panel = ControlPanel(clean_nao())
    chosen, other = (panel._controls.images[camera] for camera in ("bottom", "top"))
    asked, before = chosen.asked, other.value
    panel.forward(0.05)
    assert chosen.asked == asked + 1
    assert other.asked == 0 and other.value != before
    panel._screen.show_chosen()
    panel._screen.show_chosen()
    assert chosen.asked == asked + 1
