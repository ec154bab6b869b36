"""The readers give back what a file says, and refuse, by name, a file that says nonsense."""

import json
from dataclasses import FrozenInstanceError
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from nao_course.datasets import AnnotatedPoint, read_pictures
from nao_course.datasets.pictures import LARGEST_ANNOTATIONS
from nao_course.geometry import Pose
from nao_course.sim.camera import NAO_V4

WIDTH, HEIGHT = 320, 240


def entry(**changes: Any) -> dict[str, Any]:
    """One good entry of annotations.json, changed as asked; a change to ... takes the key away."""
    values: dict[str, Any] = {
        "file": "scene_001.png",
        "x_m": 1.0,
        "y_m": -2,
        "theta_deg": 270.0,
        "head_yaw_rad": 0.25,
        "head_pitch_rad": -0.5,
        "points": [{"kind": "L", "u": 301, "v": 17.5}, {"kind": "post_top", "u": 3, "v": 200}],
    }
    return {key: value for key, value in {**values, **changes}.items() if value is not ...}


def write(folder: Path, annotations: Any, name: str = "scenes") -> Path:
    """Make a data folder with these annotations (a value, or a file's text) and one picture."""
    root = folder / "amsterdam_2013" / name
    root.mkdir(parents=True, exist_ok=True)
    text = annotations if isinstance(annotations, str) else json.dumps(annotations)
    (root / "annotations.json").write_text(text)
    pixels = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    pixels[17, 301] = (0, 0, 255)  # BGR: one red pixel, at u = 301, v = 17
    cv2.imwrite(str(root / "scene_001.png"), pixels)
    return folder


def test_the_reader_gives_back_what_the_file_says_and_refuses_a_small_file_that_claims_to_be_huge(tmp_path):
    (picture,) = read_pictures("scenes", write(tmp_path, [entry()]))
    assert picture.name == "scene_001.png"
    assert picture.path == tmp_path / "amsterdam_2013" / "scenes" / "scene_001.png"
    assert picture.pose == Pose(1.0, -2.0, np.radians(270))
    assert (picture.head_yaw, picture.head_pitch) == (0.25, -0.5)
    assert picture.points == (AnnotatedPoint("L", 301.0, 17.5), AnnotatedPoint("post_top", 3.0, 200.0))
    assert picture.pixels.shape == (HEIGHT, WIDTH, 3)
    assert picture.pixels.dtype == np.uint8
    point = picture.points[0]
    assert picture.pixels[int(point.v), int(point.u)].tolist() == [255, 0, 0]
    (picture,) = read_pictures("scenes", write(tmp_path, [entry()]))
    contents = bytearray(picture.path.read_bytes())
    contents[16:24] = (60_000).to_bytes(4, "big") * 2
    picture.path.write_bytes(contents)
    with pytest.raises(ValueError, match="got 60000 x 60000"):
        _ = picture.pixels


def test_a_picture_is_read_when_first_asked_for_and_its_larger_version_where_there_is_one(tmp_path):
    (picture,) = read_pictures("scenes", write(tmp_path, [entry()]))
    with pytest.raises(ValueError, match="read-only"):
        picture.pixels[0, 0] = 1
    with pytest.raises(FrozenInstanceError):
        picture.name = "other"  # type: ignore[misc]
    picture.read()[0, 0] = 1
    assert picture.pixels[0, 0].tolist() == [0, 0, 0]
    first = picture.pixels
    picture.path.unlink()
    assert picture.pixels is first
    with pytest.raises(ValueError, match=r"scene_001\.png"):
        picture.read()
    (picture,) = read_pictures("scenes", write(tmp_path, [entry()]))
    assert not picture.has_large
    with pytest.raises(ValueError, match=r"scene_001\.png has no version of 1280 x 960"):
        picture.read(large=True)
    picture.large_path.parent.mkdir()
    cv2.imwrite(str(picture.large_path), np.zeros((960, 1280, 3), np.uint8))
    assert picture.has_large
    assert picture.read(large=True).shape == (960, 1280, 3)


def test_a_picture_may_have_no_points_but_a_missing_annotation_or_set_is_refused(tmp_path, monkeypatch):
    (picture,) = read_pictures("scenes", write(tmp_path, [entry(points=[])]))
    assert picture.points == ()
    monkeypatch.setenv("NAO_COURSE_DATA", str(write(tmp_path, [entry()])))
    assert len(read_pictures("scenes")) == 1
    with pytest.raises(ValueError, match=r"straightwalk.annotations\.json: cannot be read"):
        read_pictures("straightwalk", write(tmp_path, [entry()]))
    (tmp_path / "amsterdam_2013" / "scenes" / "annotations.json").write_bytes(b"\xff\xfe\xff")
    with pytest.raises(ValueError, match=r"annotations\.json: it is not text"):
        read_pictures("scenes", tmp_path)
    with pytest.raises(ValueError, match=r"'scenes', 'straightwalk'.*got '\.\./scenes'"):
        read_pictures("../scenes", tmp_path)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"file": "../scenes/scene_001.png"}, "plain file name"),
        ({"file": "..\\scene_001.png"}, "plain file name"),
        ({"file": "C:scene_001.png"}, "plain file name"),
        ({"file": "scene_001.png\0.png"}, "plain file name"),
        ({"file": "annotations.json"}, "png"),
        ({"file": "x" * 1000 + ".png"}, "file must be"),
        ({"file": 7}, "file must be"),
        ({"file": "scene_002.png"}, "no such picture"),
        ({"x_m": "1.0"}, "x_m must be a number"),
        ({"x_m": ...}, "x_m must be a number.*nothing"),
        ({"y_m": 10**400}, "y_m must be a number"),
        ({"theta_deg": None}, "theta_deg must be a number"),
        ({"head_pitch_rad": -31.0}, "head_pitch_rad must be a number"),
        ({"head_yaw_rad": {}}, "head_yaw_rad must be a number"),
        ({"points": [{"kind": "X", "u": 1, "v": 1}] * 2000}, "points must be a list of at most 1000"),
        ({"points": [[1, 2]]}, "point 0: expected an object"),
        ({"points": [{"kind": "Y", "u": 1, "v": 1}]}, "point 0: kind must be one of"),
        ({"points": [{"kind": "X", "u": 1, "v": 1}, {"kind": "X", "u": 1}]}, "point 1: v must be a number"),
    ],
)
def test_a_wrong_entry_is_refused_with_the_file_and_the_entrys_number(tmp_path, changes, message):
    folder = write(tmp_path, [entry(), entry(**changes)])
    with pytest.raises(ValueError, match=rf"(?s)annotations\.json, entry 1.*{message}") as caught:
        read_pictures("scenes", folder)
    assert len(str(caught.value)) < 1000


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("[]", "list of 1"),
        ("[1]", "entry 0: expected an object"),
        ("[{", "is not JSON"),
        ("[" * 200_000, "nested too deeply|is not JSON"),
        ("[" + "9" * 10_000 + "]", "is not JSON"),
        (" " * (LARGEST_ANNOTATIONS + 1), "got more"),
        (json.dumps([entry(x_m=float("nan"))]), "NaN is not a JSON number"),
        (json.dumps([entry()]).replace("1.0", "1e999"), "x_m must be a number"),
        (json.dumps([entry(), entry()]), "entry 1: the picture 'scene_001.png' is annotated twice"),
    ],
    ids=lambda value: str(value)[:20],
)
def test_a_wrong_file_is_refused_by_its_name(tmp_path, text, message):
    with pytest.raises(ValueError, match=rf"annotations\.json.*({message})"):
        read_pictures("scenes", write(tmp_path, text))


@pytest.mark.parametrize("kept", [0, 4, 20, 60])
def test_a_damaged_picture_is_refused_by_its_name(tmp_path, kept):
    (picture,) = read_pictures("scenes", write(tmp_path, [entry()]))
    picture.path.write_bytes(picture.path.read_bytes()[:kept])
    with pytest.raises(ValueError, match=r"scene_001\.png: "):
        _ = picture.pixels


def test_the_real_sets_have_their_published_numbers(data_dir):
    scenes, walk = read_pictures("scenes", data_dir), read_pictures("straightwalk", data_dir)
    assert (len(scenes), len(walk)) == (64, 30)
    assert sum(picture.has_large for picture in scenes) == 8
    assert scenes[0].read(large=True).shape == (960, 1280, 3)
    for picture in scenes + walk:
        assert picture.pixels.shape == (HEIGHT, WIDTH, 3)
        assert all(0 <= point.u <= WIDTH and 0 <= point.v <= HEIGHT for point in picture.points)
        NAO_V4.check_head(picture.head_yaw, picture.head_pitch)
