"""The phone lab, from an upload to landmarks on the map, with a picture of the sheet as a phone takes it."""

import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from nao_course.lessons.distance.phone import PhoneLab, read_photo, sheet, sheet_pdf, view_from_points
from nao_course.lessons.distance.phone.photo import SIZE
from tests.lessons.distance.own import OWN
from tests.paths import PROJECT

CORNERS = np.array(list(sheet.CLICKED.values()))
FOCAL_35 = 27.3  # mm: a horizontal field of view of 1.13 rad


def as_file(pixels, kind="jpeg", **options):
    buffer = io.BytesIO()
    image = pixels if isinstance(pixels, Image.Image) else Image.fromarray(pixels)
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def exif(focal=None, orientation=None):
    written = Image.Exif()
    if orientation:
        written[0x0112] = orientation
    if focal:
        written.get_ifd(0x8769)[0xA405] = focal
    return written


def true_pixels():
    """Return the pixels of the four corners and both posts in the photo of 320 x 240."""
    view, pose = sheet.usual_phone()
    return view.at_size(SIZE).project(CORNERS, pose)


def test_a_phones_file_is_read_upright_with_its_focal_length_if_that_makes_sense():
    photo = read_photo(as_file(sheet.usual_photo(), exif=exif(focal=28)))
    assert photo.pixels.shape == (240, 320, 3) and photo.focal_35 == 28
    assert photo.hfov(FOCAL_35) == pytest.approx(1.13, abs=0.01)
    upside_down = np.ascontiguousarray(sheet.usual_photo()[::-1, ::-1])
    turned = read_photo(as_file(upside_down, exif=exif(orientation=3)))
    assert np.abs(turned.pixels.astype(int) - photo.pixels).mean() < 2
    assert read_photo(as_file(sheet.usual_photo(), exif=exif(focal=3))).focal_35 is None
    assert read_photo(as_file(sheet.usual_photo())).focal_35 is None
    with pytest.raises(ValueError, match="more than 0 mm"):
        read_photo(as_file(sheet.usual_photo())).hfov(0.0)


def test_a_wide_or_tall_picture_is_centred_and_its_field_of_view_with_it():
    wide = read_photo(as_file(np.full((360, 640, 3), 200, np.uint8)))
    tall = read_photo(as_file(np.full((640, 480, 3), 200, np.uint8)))
    assert (wide.pixels[:, 160].max(axis=1) > 150).sum() == 180 and wide.part == (1.0, 0.75)
    assert (tall.pixels[120].max(axis=1) > 150).sum() == 180 and tall.part == (180 / 320, 1.0)
    assert wide.hfov(27) == pytest.approx(2 * np.arctan(160 / (27 / 43.27 * np.hypot(320, 180))))
    assert tall.hfov(27) > wide.hfov(27), "black bars beside a tall picture see something, too"


@pytest.mark.parametrize(
    "image",
    [
        Image.new("RGBA", (400, 300), (200, 30, 30, 0)),
        Image.new("P", (400, 300), 3),
        Image.new("I;16", (400, 300), 40_000),
    ],
    ids=lambda image: image.mode,
)
def test_alpha_palette_and_sixteen_bits_become_rgb(image):
    pixels = read_photo(as_file(image, "png")).pixels
    assert pixels.shape == (240, 320, 3) and pixels.dtype == np.uint8
    if image.mode == "RGBA":
        assert (pixels[120, 160] == 255).all(), "what is see-through lies on white"


def png_of(width, height):
    """Return the header of a PNG with this size."""
    good = as_file(np.zeros((1, 1, 3), np.uint8), "png")
    chunk = b"IHDR" + struct.pack(">II", width, height) + good[24:29]
    return good[:12] + chunk + struct.pack(">I", zlib.crc32(chunk)) + good[33:]


NOISE = np.random.default_rng(0).integers(0, 255, (300, 400, 3)).astype(np.uint8)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "cannot be read as a picture"),
        (b"\x00\x00\x00\x18ftypheic" + b"\x00" * 100, "HEIC"),
        (b"\xff" * 40_000_001, "at most 40"),
        (as_file(np.zeros((50, 50, 3), np.uint8)), "at least 100"),
        (png_of(40_000, 40_000), "million|cannot be read as a picture"),
        (as_file(NOISE)[:3000], "damaged"),
    ],
    ids=["empty", "heic", "huge file", "tiny", "huge picture", "cut off"],
)
def test_a_bad_upload_gets_a_sentence(content, said):
    with pytest.raises(ValueError, match=said) as caught:
        read_photo(content)
    assert str(caught.value).endswith(".")


def test_four_exact_points_give_back_the_camera_and_points_in_another_order_are_refused():
    view, pose = sheet.usual_phone()
    found, at = view_from_points(true_pixels(), CORNERS, 1.13)
    wanted = pytest.approx((view.height, view.pitch, 0.0), rel=1e-3, abs=2e-3)
    assert (found.height, found.pitch, found.roll) == wanted
    assert at.as_array() == pytest.approx(pose.as_array(), abs=0.01)
    for pixels, said in (
        (true_pixels()[[0, 2, 1, 3]], "own corner"),
        (np.tile([[100.0, 100.0]], (4, 1)), "own corner"),
        (true_pixels()[:3], "at least four"),
    ):
        with pytest.raises(ValueError, match=said):
            view_from_points(pixels, CORNERS[: len(pixels)], 1.13)


def test_the_pdf_is_one_page_of_a3_and_the_one_that_is_handed_out_with_the_lines_of_the_field():
    pdf = sheet_pdf()
    assert pdf.startswith(b"%PDF") and pdf == sheet_pdf()
    for each in (pdf, (PROJECT / "solutions" / "images" / "half_field_A3.pdf").read_bytes()):
        assert b"/Count 1" in each
        box = [float(value) for value in each.split(b"/MediaBox [")[1].split(b"]")[0].split()]
        assert np.array(box[2:]) / 72 * 0.0254 == pytest.approx(sheet.PAPER, abs=1e-4)
    pixels = sheet.sheet_pixels()
    rows, columns = pixels.shape[:2]
    metres = rows / (sheet.PAPER[1] / sheet.SCALE)  # pixels a metre of the field
    goal_line, column = rows - 0.02 / sheet.SCALE * metres - 3.0 * metres, round(columns / 2 + 1.5 * metres)
    assert (pixels[round(goal_line), column] > 240).all()
    assert (pixels[round(goal_line + 0.2 * metres), column] < 200).any()


def lab(find=None, **more):
    return PhoneLab(find or (lambda pixels: true_pixels()), OWN["pixel_to_ground"], **more)


def click_all(panel, pixels=None):
    for letter, (u, v) in zip("abcd", true_pixels() if pixels is None else pixels, strict=True):
        panel.set(pixel=(round(u), round(v)))
        panel.set(**{letter: 1})


def rows(panel, column):
    """Return a column of the panel's table, in cm."""
    (table,) = panel.shown.tables.values()
    return [float(row[column].removesuffix(" cm")) for row in table.rows]


@pytest.mark.slow
def test_from_an_upload_to_landmarks_on_the_map_and_a_bad_one_keeps_the_photo():
    panel = lab()
    before = panel.shown.pictures["The photo"].copy()
    panel.upload(b"no picture at all")
    assert "cannot be read" in panel.summary()
    assert (panel.shown.pictures["The photo"] == before).all()
    panel.upload(as_file(sheet.usual_photo(), exif=exif(focal=27)))
    assert "The file gives a focal length of 27 mm. Click the corner A" in panel.summary()
    click_all(panel)
    assert "From the four letters, the phone was 32." in panel.summary() or "was 33." in panel.summary()
    assert len(rows(panel, 1)) == 4 and max(rows(panel, 1)) < 0.8
    assert "The phone is above" in panel.shown.drawings["The paper"].alt


def test_a_clicked_corner_gets_a_ring_in_the_photo_and_one_on_the_paper():
    panel = lab()
    before = panel.shown.pictures["The photo"]
    assert "0 of 4 letters" in panel.shown.drawings["The paper"].alt
    panel.set(pixel=(100, 50))
    panel.set(a=1)
    changed = np.argwhere((panel.shown.pictures["The photo"] != before).any(axis=2))
    assert before.shape == (720, 960, 3) and np.abs(changed - (151, 301)).max() < 60
    assert "1 of 4 letters" in panel.shown.drawings["The paper"].alt
    assert sheet.on_paper([sheet.CLICKED["A"], sheet.CLICKED["C"]]) == pytest.approx(
        100 / 15 * np.array([(-2, 0), (2, 3)])
    )


def test_without_the_letters_height_and_pitch_are_the_sliders_and_a_landmark_without_ground_is_said():
    panel = lab()
    assert panel.shown.pictures["The paper"][0, 0, 3] == 0  # a dark page is seen around the paper
    (table,) = panel.shown.tables.values()
    assert [row[0] for row in table.rows] == [f"({u:.0f}, {v:.0f})" for u, v in true_pixels()]
    assert "Click the corner A" in panel.summary() and "phone" not in panel.shown.drawings["The paper"].alt
    near = np.array(rows(panel, 1))
    panel.set(height=66.0)
    assert rows(panel, 1) == pytest.approx(2 * near, abs=0.2)
    nothing = lab(find=lambda pixels: np.zeros((0, 2)))
    assert "no post" in nothing.summary() and not nothing.shown.tables
    sky = np.vstack([true_pixels(), [[160.0, 5.0]]])
    panel = lab(find=lambda pixels: sky)
    panel.set(pitch=20.0)
    assert "NaN" in panel.summary()


@pytest.mark.slow
def test_a_letter_can_be_set_again_reset_forgets_all_and_letters_turned_round_are_suspected():
    panel = lab()
    assert "(near, left)" in panel.summary()
    click_all(panel, true_pixels()[[0, 2, 1, 3]])
    assert "own corner" in panel.summary()
    for letter, (u, v) in (("b", true_pixels()[1]), ("c", true_pixels()[2])):
        panel.set(pixel=(round(u), round(v)))
        panel.set(**{letter: 2})
    assert "From the four letters, the phone was" in panel.summary() and "turned" not in panel.summary()
    panel.reset()
    assert "Click the corner A" in panel.summary()
    click_all(panel, true_pixels()[[2, 3, 0, 1]])
    assert "wrong corners" in panel.summary()


def test_reset_keeps_the_photos_focal_length_and_a_file_beside_the_notebook_is_taken_by_its_name(tmp_path):
    panel = lab()
    panel.upload(as_file(sheet.usual_photo(), exif=exif(focal=120)))
    assert panel.values.focal == 120 and "focal length of 120 mm" in panel.summary()
    panel.reset()
    assert panel.values.focal == 120
    panel.upload(as_file(sheet.usual_photo()))
    assert panel.values.focal == 27 and "focal length" in panel.summary()
    file = tmp_path / "sheet.jpg"
    file.write_bytes(as_file(sheet.usual_photo(), exif=exif(focal=35)))
    assert lab(photo=file).values.focal == 35
    missing = lab(photo=tmp_path / "none.jpg").summary()
    assert "no file" in missing and "simulated photo" in missing
