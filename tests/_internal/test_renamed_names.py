"""Names of older releases: which words are replaced, and what an import of an old name says."""

import importlib

import pytest

from nao_course._internal.renamed_names import RENAMED, with_new_names
from nao_course.field_slam.observation import Observation
from nao_course.lessons import slam_on_the_field


def test_only_whole_names_are_replaced_and_each_new_name_exists():
    code = "about = MyFieldOdometry() or FieldOdometry(); z = seen.part(i).about(r); z.about_it = apart"
    assert with_new_names(code) == (
        "about = MyFieldOdometry() or OdometryNoisePerMove(); "
        "z = seen.part(i).linearised_at(r); z.about_it = apart"
    )
    package = importlib.import_module("nao_course.field_slam")
    modules = [importlib.import_module(f"nao_course.field_slam.{name}") for name in package.__all__]
    for new in RENAMED.values():
        name = new.removeprefix(".")
        assert any(hasattr(each, name) for each in (package, Observation, *modules)), name


def test_an_import_of_an_old_name_says_the_new_one_and_a_name_that_never_existed_is_an_ordinary_error():
    with pytest.raises(ImportError, match="is now called OdometryNoisePerMove.*nao-course renew"):
        exec("from nao_course.lessons.slam_on_the_field import FieldOdometry")
    assert not hasattr(slam_on_the_field, "NoSuchName")
    with pytest.raises(ImportError, match="cannot import name 'NoSuchName'"):
        exec("from nao_course.lessons.slam_on_the_field import NoSuchName")
