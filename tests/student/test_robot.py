"""The student's robot: their own functions, from this notebook or a saved one, and words for what is missing."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.student import my_nao, stages, strip
from nao_course.widgets.control_panel import Stage
from tests.toy import toy
from tests.widgets.robots import clean_nao


def clamp(x, low, high):
    return max(low, min(high, x))


def mean_of_positive(values):
    return float(values[values > 0].mean()) if (values > 0).any() else 0.0


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch, stage):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def drive(**own):
    return my_nao(clean_nao(), time_limit=60.0, **own)


def test_saved_functions_look_along_and_what_they_print_in_their_check_is_not_shown(here, capsys):
    noisy = toy.CLAMP.replace("    return", "    print('noise')\n    return")
    toy.write(here / "90_toy.ipynb", noisy, toy.MEAN)
    panel = drive()
    assert panel.view == "beside" and capsys.readouterr().out == ""
    panel.forward(0.05)
    assert "your NAO so far: ✔ distances (90)\ndistances: 1.0 m away" in panel.summary()
    assert np.allclose(panel._screen.contents().points, [(1.0, 0.0), (1.0, 0.5)])


def test_functions_of_this_notebook_need_not_be_saved_and_can_be_handed_over_by_name(monkeypatch):
    assert "✔ distances (90)" in drive(clamp=clamp, mean_of_positive=mean_of_positive).summary()
    with pytest.raises(ValueError, match="no stage of the robot uses colour_labels; my_nao takes clamp"):
        drive(colour_labels=clamp)
    shell = SimpleNamespace(user_ns={"clamp": clamp, "mean_of_positive": mean_of_positive, "nao": 3})
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    assert "✔ distances (90)" in drive().summary()
    shell.user_ns["clamp"] = 3
    assert "not yet: distances, because 90_toy.ipynb is not in your folder" in drive().summary()


def test_what_is_missing_or_wrong_is_named_and_the_robot_drives_with_the_saved_function(here):
    toy.write(here / "90_toy.ipynb", toy.CLAMP, "def mean_of_positive(values):\n    return 0.0")
    panel = drive()
    panel.forward(0.1)
    said = panel.summary()
    assert "not yet: distances, because mean_of_positive of lesson 90 does not pass its check yet" in said
    assert "Walk 0.10 m ahead: done." in said and panel.error is None
    toy.write(here / "90_toy.ipynb", *toy.SOLUTION)
    said = "clamp of this notebook does not pass its check, so the saved version is used"
    assert said in drive(clamp=lambda x, low, high: x).summary()
    assert said not in drive(clamp=clamp).summary()


def test_a_later_stage_waits_for_the_one_that_it_needs_and_not_for_one_that_helps(here, stage):
    toy.write(here / "90_toy.ipynb", toy.CLAMP)
    later = Stage("map", "90_toy", ("clamp",), stage.wire, after=("distances",))
    found = stages.readiness([stage, later], {}, here)
    assert found.stages == () and found.missing["map"] == "it needs distances"
    toy.write(here / "90_toy.ipynb", *toy.SOLUTION)
    assert stages.readiness([stage, later], {}, here).stages == (stage, later)
    later = Stage("map", "91_other", ("90:clamp",), stage.wire)
    assert list(stages.readiness([later], {}, here).functions) == ["clamp"]
    toy.write(here / "90_toy.ipynb", toy.CLAMP)
    helped = replace(stage, uses=("clamp",), helped_by=("mean_of_positive",))
    found = stages.add_ready(stages.Readiness(), helped, {}, here)
    assert found.stages == (helped,) and list(found.functions) == ["clamp"] and not found.missing
    assert found.remarks == (
        "distances runs without mean_of_positive, because mean_of_positive of lesson 90 is not written yet",
    )


def test_the_robot_of_a_lesson_leaves_later_lessons_out_and_says_so(here, stage, monkeypatch):
    monkeypatch.setattr(stages, "lessons", lambda: ["89_earlier", "90_toy"])
    toy.write(here / "90_toy.ipynb", *toy.SOLUTION)
    said = "this is your robot after lesson 89; my_nao() runs all your lessons"
    assert said not in drive(upto="89").summary()  # nobody has checked the saved notebook yet
    strip.so_far()
    panel = drive(upto="89")
    assert said in panel.summary() and "distances" not in panel.summary() and panel.view == "picture"
    for all_of_them in (drive(), drive(upto="90")):
        assert "✔ distances (90)" in all_of_them.summary() and said not in all_of_them.summary()
    with pytest.raises(ValueError, match="no stage of the robot uses clamp"):
        drive(upto="89", clamp=clamp)
    with pytest.raises(ValueError, match="upto must be the number of a lesson"):
        drive(upto="7")


def test_the_default_robot_is_the_same_each_time_and_its_truth_is_known():
    first, second = my_nao(time_limit=60.0), my_nao(time_limit=60.0)
    assert np.array_equal(first.cockpit.pictures["bottom"].pixels, second.cockpit.pictures["bottom"].pixels)
    assert first.cockpit.truth is not None and drive().cockpit.truth is None
    assert drive().view == "picture"
