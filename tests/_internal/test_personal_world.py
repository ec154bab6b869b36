"""A student's personal world: it depends on the name only, and the name is found beside the notebooks."""

import unicodedata

import numpy as np
import pytest

from nao_course._internal.personal_world import EXAMPLE, PersonalWorld, personal_world, stamp_of


def test_seeds_depend_on_the_student_and_the_purpose_and_not_on_case_spaces_or_the_encoding_of_an_accent():
    seeds = [PersonalWorld(f"student {n}").seed(purpose) for n in range(300) for purpose in ("a", "b")]
    assert len(set(seeds)) == 600
    # They must never change, because answers refer to them.
    assert PersonalWorld("ada").seed("07: drives") == 1071474710
    first, second = (PersonalWorld("ada").rng("x").normal(size=3) for _ in range(2))
    assert np.array_equal(first, second)
    for name in ("ADA lovelace", " ada Lovelace "):
        assert PersonalWorld(name).seed("x") == PersonalWorld("ada lovelace").seed("x")
    each = {PersonalWorld(unicodedata.normalize(form, "Zoë")).seed("x") for form in ("NFC", "NFD")}
    assert len(each) == 1 and PersonalWorld("Zoe").seed("x") not in each


@pytest.fixture
def copy(tmp_path, monkeypatch):
    monkeypatch.delenv("JUPYTERHUB_USER", raising=False)
    (tmp_path / "release").mkdir()
    (tmp_path / "notebooks").mkdir()
    return tmp_path


def test_the_name_is_found_from_notebooks_of_a_students_copy_and_on_a_hub_is_the_users(copy, monkeypatch):
    assert personal_world(copy / "notebooks") == PersonalWorld("") and str(personal_world(copy)) == EXAMPLE
    (copy / "release" / "student.json").write_bytes(stamp_of("Łucja"))
    assert personal_world(copy / "notebooks") == PersonalWorld("Łucja")
    monkeypatch.chdir(copy / "notebooks")
    assert str(personal_world()) == "Łucja"
    (copy / "release" / "student.json").unlink()
    monkeypatch.setenv("JUPYTERHUB_USER", "bob")
    assert personal_world(copy) == PersonalWorld("bob")
    (copy / "release" / "student.json").write_bytes(stamp_of("ada"))
    assert personal_world(copy) == PersonalWorld("ada")


@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b'{"student": 3}', b'{"student": " "}', b"\xff\xfe"])
def test_a_damaged_name_is_refused_with_what_to_do(copy, content):
    (copy / "release" / "student.json").write_bytes(content)
    with pytest.raises(ValueError, match="Unpack your copy of the course again"):
        personal_world(copy)
