"""A photograph by the student's own phone: read from an upload, and what is known of the camera that took it."""

from __future__ import annotations

import io
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageOps, UnidentifiedImageError

from nao_course.geometry import FloatArray, Pose, as_points, finite, yaw_pitch_roll
from nao_course.sim import CameraView

SIZE = (320, 240)  # px: what lessons 01 to 03 were made for; other shapes get black bars
ENLARGED = 3  # times: the photo that is shown
LARGE = (ENLARGED * SIZE[0], ENLARGED * SIZE[1])
DIAGONAL_35 = 43.27  # mm, of a 35 mm picture: focal lengths "in 35 mm terms" go by it
FOCALS_35 = (10.0, 200.0)  # mm in 35 mm terms: from a phone's widest camera to its longest
LARGEST_FILE = 40_000_000  # bytes
MOST_PIXELS = 120_000_000
SMALLEST_SIDE = 100  # px
_EXIF_BLOCK, _FOCAL_35 = 0x8769, 0xA405  # where a camera writes its focal length in 35 mm terms
_HEIF_BRANDS = (b"heic", b"heix", b"hevc", b"heim", b"heis", b"mif1", b"msf1", b"avif")
# (right, down, ahead) as (ahead, left, up)
_FROM_OPENCV = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True, eq=False)
class Photo:
    """A photograph in the course's size.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (240, 320, 3)
        RGB; the picture lies in the middle, between black bars where it has another shape.
    large : ndarray of uint8, shape (720, 960, 3)
        The same at three times the size.
    part : (float, float)
        Which part of the width and of the height the picture takes.
    focal_35 : float or None
        Focal length in 35 mm terms that the camera wrote into the file, mm.
    """

    pixels: npt.NDArray[np.uint8]
    large: npt.NDArray[np.uint8]
    part: tuple[float, float] = (1.0, 1.0)
    focal_35: float | None = None

    @classmethod
    def of(cls, pixels: npt.NDArray[np.uint8], focal_35: float | None = None) -> Photo:
        """Shrink a picture (H, W, 3) into the middle of both sizes; its own middle stays the middle."""
        (small, part), (large, _) = _framed(pixels, SIZE), _framed(pixels, LARGE)
        return cls(small, large, part, focal_35)

    def hfov(self, focal_35: float) -> float:
        """Return the horizontal field of view (rad) of all 320 pixels for a focal length in 35 mm terms (mm)."""
        width, height = SIZE[0] * self.part[0], SIZE[1] * self.part[1]
        focal = finite("focal length (mm)", focal_35) / DIAGONAL_35 * np.hypot(width, height)
        if focal <= 0:
            raise ValueError(f"the focal length must be more than 0 mm, got {focal_35}")
        return float(2 * np.arctan(SIZE[0] / 2 / focal))


def read_photo(content: bytes) -> Photo:
    """Read an uploaded file.

    Parameters
    ----------
    content : bytes
        Of a JPEG, PNG, or another picture that Pillow reads; grey, with an alpha channel, turned: all are well.

    Returns
    -------
    Photo
        Upright, RGB.

    Raises
    ------
    ValueError
        With a sentence for the student: no picture, HEIC, too large, too small, damaged.
    """
    if len(content) > LARGEST_FILE:
        raise ValueError(
            f"The file has {len(content) / 1e6:.0f} MB; at most {LARGEST_FILE / 1e6:.0f} are read."
        )
    if content[4:8] == b"ftyp" and content[8:12] in _HEIF_BRANDS:
        raise ValueError(
            'This is a HEIC picture, which is not read here. Set the camera to "most compatible", or send a JPEG.'
        )
    try:
        with Image.open(io.BytesIO(content)) as image:
            width, height = image.size
            if width * height > MOST_PIXELS:
                raise ValueError(
                    f"The picture has {width} x {height} pixels; at most {MOST_PIXELS / 1e6:.0f} million are read."
                )
            if min(width, height) < SMALLEST_SIDE:
                raise ValueError(
                    f"The picture has {width} x {height} pixels; each side needs at least {SMALLEST_SIDE}."
                )
            focal = _focal_length(image)
            image.draft("RGB", (LARGE[0], LARGE[0]))  # a JPEG is read small at once
            upright = _as_rgb(ImageOps.exif_transpose(image))
    except (UnidentifiedImageError, Image.DecompressionBombError):
        raise ValueError("This file cannot be read as a picture. Use a JPEG or PNG.") from None
    except (OSError, SyntaxError):  # what Pillow raises for files that end too early
        raise ValueError("The picture's file is damaged or ends too early. Send it again.") from None
    return Photo.of(upright, focal)


def _focal_length(image: Image.Image) -> float | None:
    """Return the focal length in the file if it is plausible."""
    try:
        value = float(image.getexif().get_ifd(_EXIF_BLOCK).get(_FOCAL_35, 0))
    except (TypeError, ValueError, ZeroDivisionError, SyntaxError, OSError):
        return None
    return value if FOCALS_35[0] <= value <= FOCALS_35[1] else None


def _as_rgb(image: Image.Image) -> npt.NDArray[np.uint8]:
    """Return eight bits in three channels, with transparent parts on white."""
    if image.mode.startswith(("I", "F")):  # sixteen bits and more
        values = np.asarray(image, dtype=float)
        span = max(float(values.max() - values.min()), 1e-9)
        image = Image.fromarray((255 * (values - values.min()) / span).astype(np.uint8))
    if image.mode in ("LA", "PA", "RGBA", "RGBa", "La") or "transparency" in image.info:
        layer = image.convert("RGBA")
        image = Image.alpha_composite(Image.new("RGBA", layer.size, "white"), layer)
    return np.asarray(image.convert("RGB"), dtype=np.uint8)


def _framed(
    pixels: npt.NDArray[np.uint8], frame: tuple[int, int]
) -> tuple[npt.NDArray[np.uint8], tuple[float, float]]:
    """Return a picture in a frame of (width, height), and which part of both it takes."""
    height, width = pixels.shape[:2]
    scale = min(frame[0] / width, frame[1] / height)
    size = min(round(width * scale), frame[0]), min(round(height * scale), frame[1])
    inside = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)
    framed = np.zeros((frame[1], frame[0], 3), np.uint8)
    left, top = (frame[0] - size[0]) // 2, (frame[1] - size[1]) // 2
    framed[top : top + size[1], left : left + size[0]] = inside
    return framed, (size[0] / frame[0], size[1] / frame[1])


def view_from_points(pixels: npt.ArrayLike, points: npt.ArrayLike, hfov: float) -> tuple[CameraView, Pose]:
    """Find where a camera is and how it looks, from points of the ground whose places are known.

    Parameters
    ----------
    pixels : array_like, shape (N, 2)
        (u, v) of at least four points, not all on one line.
    points : array_like, shape (N, 2)
        Where they are, metres.
    hfov : float
        Horizontal field of view, rad; the pixels are square, and there is no lens term.

    Returns
    -------
    view : CameraView
        Height, pitch and roll; yaw and offset are zero: the frame stands below the camera and looks along it.
    pose : Pose
        Of that frame, in the frame of the points.

    Raises
    ------
    ValueError
        If no camera above the ground sees the points so.
    """
    seen, known = as_points(pixels, name="pixels"), as_points(points)
    if len(seen) != len(known) or len(seen) < 4:
        raise ValueError(
            f"at least four pixels and as many points are needed, got {len(seen)} and {len(known)}"
        )
    guess = CameraView.from_fov(SIZE, hfov, height=1.0, pitch=0.0)
    matrix = np.array(
        [[guess.focal[0], 0, guess.centre[0]], [0, guess.focal[1], guess.centre[1]], [0, 0, 1.0]]
    )
    there = np.column_stack([known, np.zeros(len(known))])
    wrong = "no camera can see the four points there: is each letter at its own corner, and none twice?"
    try:
        found, turn, shift = cv2.solvePnP(there, seen, matrix, None, flags=cv2.SOLVEPNP_IPPE)
        if found:
            found, turn, shift = cv2.solvePnP(
                there, seen, matrix, None, turn, shift, True, cv2.SOLVEPNP_ITERATIVE
            )
    except cv2.error:
        raise ValueError(wrong) from None
    if not found or not (np.isfinite(turn).all() and np.isfinite(shift).all()):
        raise ValueError(wrong)
    to_camera = cv2.Rodrigues(turn)[0]
    place = -to_camera.T @ shift[:, 0]
    yaw, pitch, roll = yaw_pitch_roll((_FROM_OPENCV @ to_camera).T)
    if place[2] <= 0 or not _seen_again(to_camera, shift, matrix, there, seen):
        raise ValueError(wrong)
    view = CameraView(SIZE, guess.hfov, guess.vfov, float(place[2]), pitch, roll=roll)
    return view, Pose(float(place[0]), float(place[1]), yaw)


def _seen_again(
    turn: FloatArray, shift: FloatArray, matrix: FloatArray, points: FloatArray, pixels: FloatArray
) -> bool:
    """Return True if a camera there sees the points in front of it and near their marks."""
    ahead = points @ turn.T + shift[:, 0]
    if (ahead[:, 2] <= 0).any():
        return False
    again = (ahead @ matrix.T)[:, :2] / ahead[:, 2:]
    return bool(np.linalg.norm(again - pixels, axis=1).max() < 0.1 * matrix[0, 2] * 2)
