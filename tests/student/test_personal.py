"""The table of a student's personal numbers."""

from nao_course._internal.personal_world import stamp_of
from nao_course.student import personal_table


def numbers(world, double):
    return {"length of the name": double(float(len(world.student)))}


def test_the_table_names_the_world_and_has_three_decimals(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "release").mkdir()
    (tmp_path / "release" / "student.json").write_bytes(stamp_of("Ada"))
    shown = personal_table("picture", numbers, lambda value: 2 * value)
    assert shown.columns == ("picture of Ada", "value")
    assert shown.rows == (("length of the name", "6.000"),)
