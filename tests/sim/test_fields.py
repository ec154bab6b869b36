"""A field of one's own: what its file may say, and that everything stands on it that stands on a rule book's field."""

import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from nao_course.codec import CodecError, decode, encode
from nao_course.geometry import Pose
from nao_course.plotting import draw_map
from nao_course.sim import DIMENSIONS, NAO_V4, Field, Reality, SimulatedNao, render
from nao_course.sim.fields import SHIPPED, FieldDimensions
from nao_course.widgets.world.scene import WorldScene

GIVEN = {"half": "false", "length": "4.5", "width": "3.0", "border": "0.3", "line_width": "0.05"}
GIVEN |= {"goal_colour": '"none"'}
GOAL = {"goal_colour": '"white"', "goal_width": "1.0", "post_height": "0.6"}
GOAL |= {"post_diameter": "0.05", "bar_diameter": "0.05"}


def written(folder, **changes):
    """Write a field's file with some keys changed, or left out if they are None."""
    table = {key: value for key, value in {**GIVEN, **changes}.items() if value is not None}
    path = folder / "own.toml"
    path.write_text("\n".join(f"{key} = {value}" for key, value in table.items()), encoding="utf-8")
    return path


@pytest.mark.parametrize("name", SHIPPED)
def test_every_key_of_a_fields_file_arrives_on_the_field(name):
    table = tomllib.loads(SHIPPED[name].read_text(encoding="utf-8"))
    field = Field.from_toml(SHIPPED[name])
    assert field.half == table.pop("half")
    for key, value in table.items():
        assert getattr(field.dimensions, key) == (tuple(value) if isinstance(value, list) else value)
    assert field == Field.from_toml(name)


def test_a_file_makes_the_field_of_its_year_and_what_it_leaves_out_is_not_on_the_field(tmp_path):
    assert sorted(DIMENSIONS) == [2012, 2013, 2025]
    for year, dimensions in DIMENSIONS.items():
        assert Field.from_toml(str(year)).dimensions == dimensions == Field(year).dimensions
    copy = tmp_path / "copy.toml"
    copy.write_bytes(SHIPPED["2012"].read_bytes())
    own, year = Field.from_toml(copy), Field(2012)
    assert own.landmarks == year.landmarks
    view, pose = NAO_V4.view("bottom"), Pose(1.5, 0.3, 0.1)
    pictures = [render(each, pose, view, Reality.lab(3), np.random.default_rng(0))[0] for each in (own, year)]
    assert np.array_equal(*pictures)
    bare = Field.from_toml(written(tmp_path))
    assert [mark.shape for mark in bare.landmarks] == ["L"] * 4 + ["T"] * 2
    for each in (bare.posts, bare.bars, bare.arcs, bare.marks, bare.mark_lines):
        assert len(each) == 0
    assert len(Field.from_toml(written(tmp_path, **GOAL)).posts) == 4


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"length": None}, "length is missing; the keys half, length, width, border, line_width, goal_col"),
        ({"half": "1"}, "half must be true or false, got 1"),
        ({"width": '"3 m"'}, "width must be a number of metres, got '3 m'"),
        ({"border": "-0.3"}, "border must be a number of metres that is not negative, got -0.3"),
        ({"length": "nan"}, "length must be a number of metres that is not negative, got nan"),
        ({"length": "0"}, "length must be above 0 and below 30 m, got 0"),
        ({"width": "31"}, "width must be above 0 and below 30 m, got 31"),
        ({"line_width": "0.8"}, "line_width must be above 0 and below 0.75 m (a quarter of the width), got"),
        ({"circle_diameter": "3.0"}, "circle_diameter must be above 0.1 and below 3 m (the circle would"),
        ({"goal_area": "[2.3, 2.0]"}, "goal_area: the depth must be above 0.05 and below 2.25 m (half of"),
        ({"goal_area": "[0.6, 3.0]"}, "goal_area: the width must be above 0.05 and below 3 m (the field's"),
        ({"goal_area": "0.6"}, "goal_area must be its depth and width in metres, such as [0.6, 2.2]"),
        ({"goal_area": "[0.6, 2.0]", "penalty_area": "[0.5, 2.5]"}, "penalty_area: the depth must be above"),
        ({"penalty_area": "[1.5, 2.0]", "circle_diameter": "1.6"}, "circle_diameter must be above 0.1 and"),
        ({"penalty_mark": "1.0"}, "mark_size must be given for a field with penalty marks"),
        ({"penalty_mark": "2.5", "mark_size": "0.1"}, "penalty_mark must be above 0 and below 2.25 m"),
        ({"mark_size": "2"}, "mark_size must be above 0 and below 1.5 m"),
        ({"goal_colour": '"red"'}, """goal_colour must be one of "yellow", "white", "none", got 'red'"""),
        ({"goal_width": "1.4"}, 'goal_width must be left out if goal_colour = "none"'),
        ({"goal_colour": '"white"'}, "goal_width must be given for a field with goals"),
        ({**GOAL, "goal_width": "3.5"}, "goal_width must be above 0 and below 3 m (the field's width), got"),
        ({**GOAL, "post_height": "5"}, "post_height must be above 0 and below 3 m"),
        ({**GOAL, "post_diameter": "0.5"}, "post_diameter must be above 0 and below 0.3 m"),
        ({"lenght": "4"}, "lenght is not a key of a field; did you mean length?"),
        ({"flags": "4"}, "flags is not a key of a field; the keys are half, length, width"),
        ({"length": ""}, "not a TOML file"),
    ],
)
def test_a_wrong_file_is_refused_with_its_name_its_key_and_what_is_allowed(tmp_path, changes, message):
    path = written(tmp_path, **changes)
    with pytest.raises(ValueError, match=re.escape(f"{path}: {message}")):
        Field.from_toml(path)


def test_a_missing_file_is_named_with_the_courses_fields_and_a_robot_stands_on_a_field_of_ones_own(tmp_path):
    with pytest.raises(ValueError, match=r"none\.toml: the field cannot be read.*2012, 2013, 2025, lab"):
        Field.from_toml(tmp_path / "none.toml")
    (tmp_path / "latin.toml").write_bytes(b'goal_colour = "\xe4"')
    with pytest.raises(ValueError, match=r"latin\.toml: not a TOML file"):
        Field.from_toml(tmp_path / "latin.toml")
    nao = SimulatedNao(Field.from_toml("lab"), Pose(1.0, 0.0, 0.6))
    assert {each.kind for each in nao.sense()} == {"corner"}
    with pytest.raises(ValueError, match="pose must be on the carpet"):
        SimulatedNao(Field.from_toml("lab"), Pose(2.7, 0.0, 0.0))
    field = Field.from_toml("lab")
    assert decode(encode(field)) == field
    forged = encode(field).replace((4.5).hex().encode(), (4.5 * 2**20).hex().encode())
    assert len(forged) == len(encode(field)) + 1
    with pytest.raises(CodecError):
        decode(forged[:4] + (int.from_bytes(forged[4:12], "little") + 1).to_bytes(8, "little") + forged[12:])
    assert len({DIMENSIONS[2012], replace(DIMENSIONS[2012]), replace(DIMENSIONS[2012], border=0.5)}) == 2
    assert isinstance(DIMENSIONS[2012], FieldDimensions)


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("half", [True, False])
def test_pictures_labels_and_landmarks_agree_on_every_field(name, half):
    """Each landmark's pixel has the label of what is there, and no picture shows a thing that the field lacks."""
    field = replace(Field.from_toml(name), half=half)
    goal = {"yellow": 2, "white": 3, "none": None}[field.dimensions.goal_colour]
    labels = set()
    for heading in np.linspace(-np.pi, np.pi, 8, endpoint=False):
        pose = Pose(field.x_range[1] - 1.2, 0.2, heading)
        _, truth = render(field, pose, NAO_V4.view("bottom", 0.0, np.radians(-31)), Reality.clean())
        labels |= set(np.unique(truth.labels))
        for mark in truth.landmarks:
            if mark.distance < 2.5 and not mark.occluded:
                u, v = np.rint(mark.pixel).astype(int)
                around = truth.labels[max(v - 2, 0) : v + 3, max(u - 2, 0) : u + 3]
                assert (goal if mark.landmark.kind == "post" else 3) in around, mark
    assert (2 in labels) == (goal == 2)


@pytest.mark.parametrize("name", SHIPPED)
def test_maps_and_the_room_are_drawn_for_every_field(name):
    field = Field.from_toml(name)
    drawing = draw_map(field, landmarks=True)
    words = [text.get_text() for text in drawing.figure.legends[0].get_texts()]
    assert ("the field's post" in words) == bool(len(field.posts))
    assert len(WorldScene(field, Reality()).posts) == len(field.posts) + len(field.bars)
