"""The phone lab: the student's photograph of the printed half field, and their own landmarks of it on the map."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import ipywidgets
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray, Pose, as_points
from nao_course.lessons.distance.panels.tilt import mark_pixels
from nao_course.lessons.distance.phone.photo import (
    ENLARGED,
    FOCALS_35,
    LARGEST_FILE,
    SIZE,
    Photo,
    read_photo,
    view_from_points,
)
from nao_course.lessons.distance.phone.sheet import (
    BELOW,
    CLICKED,
    FIELD,
    PAPER,
    SCALE,
    on_paper,
    sheet_pixels,
    usual_photo,
)
from nao_course.plotting import STYLES, Drawing, course_style, plot_pose, table
from nao_course.plotting.legends import legend_below
from nao_course.plotting.marks import at_scale, rgb
from nao_course.plotting.style import FOUND, INK
from nao_course.sim import CameraView
from nao_course.widgets import Action, FunctionPanel, Pixel, Slider

USUAL_FOCAL = 27.0  # mm in 35 mm terms: most phones' main camera, and the stand-in's
# Seen from the halfway line
WHERE = {"A": "near, left", "B": "near, right", "C": "far, right", "D": "far, left"}
# A browser hands files to the kernel in one message. JupyterLab's server takes 10 MB, and of more it says nothing:
# `make lab` lets it take what is read here. Other servers may have limits of their own.
UPLOADED = (
    f"JPEG or PNG, at most {LARGEST_FILE / 1e6:.0f} MB; or drag it into the list of files on the left and write "
    '<code>PhoneLab(..., photo="name.jpg")</code>'
)
STAND_IN = "This is a simulated photo. Choose a photo of your own, or use this one."
_CONTROLS = [
    Pixel("pixel", "Corner", SIZE, tooltip="Click a corner of the field, then its letter"),
    *(
        Action(
            letter.lower(), letter, key=letter.lower(), tooltip=f"The pixel is the field's corner {letter}"
        )
        for letter in CLICKED
    ),
    Slider("focal", "Focal length", *FOCALS_35, 0.5, USUAL_FOCAL, unit="mm", tooltip="In 35 mm terms"),
    Slider("height", "Height", 10.0, 100.0, 0.5, 33.0, unit="cm", tooltip="Of the phone above the table"),
    Slider("pitch", "Looks down by", 5.0, 85.0, 0.5, 55.0, unit="°", tooltip="By the phone's level"),
]
_UNFINISHED = {
    "find_landmarks": "Finish lessons 01 to 03 to see your landmarks in the photo.",
    "pixel_to_ground": "Finish exercise 4.4 to see points on the map.",
}


class PhoneLab(FunctionPanel):
    """Upload a photo of the sheet, click its four letters, and see your landmarks on the map.

    Without the four letters, the camera's height and pitch come from the sliders, as measured with a ruler and the
    phone's level; its position on the map needs the letters.

    Parameters
    ----------
    find_landmarks : callable
        ``find_landmarks(pixels)`` returns (K, 2), (u, v) px, of corners and posts in a picture of 320 x 240.
    pixel_to_ground : callable
        The student's of exercise 4.4.
    photo : str or Path, optional
        A photo's file beside the notebook. Without it the lab begins with the stand-in.
    """

    css = ".nao-laid-out.nao-phone .nao-body { --nao-most: 355px; }"

    def __init__(
        self,
        find_landmarks: Callable[..., Any],
        pixel_to_ground: Callable[..., Any],
        photo: str | Path | None = None,
    ) -> None:
        """Begin with the stand-in photo, or with the file that is named."""
        self._photo, self._said = Photo.of(usual_photo()), STAND_IN
        self._points: dict[str, tuple[int, int]] = {}
        self._pressed_before: dict[str, int] = {}
        super().__init__(
            "Phone lab",
            self._look,
            _CONTROLS,
            student={"find_landmarks": find_landmarks, "pixel_to_ground": pixel_to_ground},
            unfinished=_UNFINISHED,
        )
        self.widget.add_class("nao-phone")
        self._add_upload()
        if photo is not None:
            self._open(Path(photo))

    def _add_upload(self) -> None:
        """Put the button that takes a photo above everything else."""
        self._upload = ipywidgets.FileUpload(
            accept="image/*", multiple=False, description="Your photo", layout={"flex": "0 0 auto"}
        )
        self._upload.tooltip = "A JPEG or PNG of the printed sheet"
        self._upload.observe(self._uploaded, "value")
        style, *rest = self.widget.children
        note = ipywidgets.HTML(UPLOADED, layout={"width": "auto", "flex": "1 1 auto"})
        row = ipywidgets.HBox([self._upload, note])
        self.widget.children = (style, row, *rest)

    def upload(self, content: bytes) -> None:
        """Take a photo's file in place of the present one; what cannot be read is said in the panel."""
        try:
            self._photo = read_photo(content)
        except ValueError as error:
            self._said = str(error)
            self.set()
            return
        if self._photo.focal_35 is None:
            self._said = f"The file does not contain its focal length; {USUAL_FOCAL:g} mm is usual."
        else:
            self._said = f"The file gives a focal length of {self._photo.focal_35:g} mm."
        self.set(**dict.fromkeys(map(str.lower, CLICKED), 0), focal=self._photo.focal_35 or USUAL_FOCAL)

    def reset(self) -> None:
        """Set all controls back to where they began, the focal length to what the photo's camera says."""
        super().reset()
        if self._photo.focal_35 is not None:
            self.set(focal=self._photo.focal_35)

    def _open(self, file: Path) -> None:
        """Take a file by its name; where there is none, the panel says so."""
        try:
            content = file.read_bytes()
        except OSError:
            self._said = f"There is no file {str(file)!r} beside this notebook. {STAND_IN}"
            self.set()
            return
        self.upload(content)

    def _uploaded(self, change: Any) -> None:
        for file in change["new"]:
            self.upload(bytes(file["content"]))

    # --- what is seen ---

    def _look(self, values: Any, student: Any) -> Iterator[Any]:
        """Show the photo with the letters, then the landmarks in it, then the map."""
        clicked = self._clicked(values)
        yield {"The photo": _lettered(self._photo.large, clicked), "The paper": _draw_paper(clicked)}
        view, pose, words = self._camera(values, clicked)
        yield " ".join(filter(None, (self._said, words)))
        marks = as_points(student.find_landmarks(self._photo.pixels), name="landmarks (u, v)")
        if not len(marks):
            yield "Your code finds no post and no corner in this photo."
            return
        marked = mark_pixels(self._photo.large, at_scale(marks, ENLARGED), radius=13)
        yield {"The photo": _lettered(marked, clicked)}
        ground = as_points(student.pixel_to_ground(marks, view), name="points on the ground")
        if len(ground) != len(marks):
            raise ValueError(f"{len(marks)} pixels need as many points on the ground, got {len(ground)}")
        shown = np.isfinite(ground).all(axis=1)
        if not shown.all():
            above = np.count_nonzero(~shown)
            yield f"{above} of {len(marks)} landmarks are at or above the horizon: their points are NaN."
        ground = ground[shown]
        if pose is None:
            rows = [
                (f"({u:.0f}, {v:.0f})", f"{100 * SCALE * away:.1f} cm", f"{bearing:+.0f}°")
                for (u, v), (away, bearing) in zip(marks[shown], _polar(ground), strict=True)
            ]
            yield table(("landmark (u, v)", "from below the phone", "to the left"), rows)
        else:
            yield {"The paper": _draw_paper(clicked, pose, pose.to_parent(ground))}
            yield _nearest(pose.to_parent(ground))

    def _clicked(self, values: Any) -> dict[str, tuple[int, int]]:
        """Return the pixels of the letters: a pressed letter gets the selected pixel, and Reset removes all."""
        for letter in CLICKED:
            times = values[letter.lower()]
            if times > self._pressed_before.get(letter, 0):
                self._points[letter] = values.pixel
            elif times == 0:
                self._points.pop(letter, None)
            self._pressed_before[letter] = times
        return dict(self._points)

    def _camera(
        self, values: Any, clicked: Mapping[str, tuple[int, int]]
    ) -> tuple[CameraView, Pose | None, str]:
        """Return the view in metres of the field, the pose if it is known, and a sentence about both."""
        hfov = self._photo.hfov(values.focal)
        by_hand = CameraView.from_fov(
            SIZE, hfov, values.height / 100 / SCALE, float(np.radians(values.pitch))
        )
        missing = sorted(CLICKED.keys() - clicked.keys())
        if missing:
            letter = missing[0]
            where = f"Click the corner {letter} of the field ({WHERE[letter]}), then the button {letter}."
            return by_hand, None, where
        try:
            view, pose = view_from_points([clicked[each] for each in CLICKED], list(CLICKED.values()), hfov)
        except ValueError as error:
            return by_hand, None, f"By the letters {error}"
        height, pitch, roll = 100 * SCALE * view.height, np.degrees(view.pitch), np.degrees(view.roll)
        found = f"{height:.1f} cm up, {pitch:.1f}° down, roll {roll:.1f}°"
        turned = pose.x > max(x for x, _ in CLICKED.values())
        warned = (
            " It was behind the goal line. If it was not, the letters are at the wrong corners."
            if turned
            else ""
        )
        return view, pose, f"From the four letters, the phone was {found}.{warned}"


def _lettered(pixels: npt.NDArray[np.uint8], clicked: Mapping[str, tuple[int, int]]) -> npt.NDArray[np.uint8]:
    """Return a copy of the large picture with a ring and a letter at each clicked pixel."""
    shown = np.ascontiguousarray(pixels).copy()
    for letter, (u, v) in zip(
        clicked, at_scale(list(clicked.values()), ENLARGED).round().astype(int), strict=True
    ):
        for colour, thickness in (((255, 255, 255), 7), (rgb(FOUND), 4)):
            cv2.circle(shown, (u, v), 20, colour, thickness, cv2.LINE_AA)
            cv2.putText(
                shown, letter, (u + 24, v - 14), cv2.FONT_HERSHEY_SIMPLEX, 1.2, colour, thickness, cv2.LINE_AA
            )
    return shown


def _polar(points: FloatArray) -> list[tuple[float, float]]:
    """Return distance (m) and direction (degrees) of points."""
    return [(float(np.hypot(x, y)), float(np.degrees(np.arctan2(y, x)))) for x, y in points]


@course_style()
def _draw_paper(clicked: Collection[str], pose: Pose | None = None, points: npt.ArrayLike = ()) -> Drawing:
    """Draw the paper as it lies, the letters that are clicked, and the points (N, 2) of a phone in the field frame.

    The paper has its true colours on every page, so what is around it is transparent.
    """
    figure = Figure(figsize=(4.6, 4.4), facecolor="none")
    ax = figure.add_subplot(facecolor="none")
    ax.tick_params(colors=INK)
    ax.spines[:].set_color(INK)
    half, low = 50 * PAPER[0], -100 * BELOW
    lowest = low
    ax.imshow(_small_sheet(), extent=(-half, half, low, low + 100 * PAPER[1]))
    for letter, (x, y) in zip(CLICKED, on_paper(list(CLICKED.values())), strict=True):
        ax.text(
            x + 2.4 * np.sign(x), y, letter, color="white", weight="bold", size=15, ha="center", va="center"
        )
    rings = on_paper([CLICKED[letter] for letter in clicked] or np.empty((0, 2)))
    ax.plot(*rings.T, "o", color="none", mec=FOUND, mew=2.5, ms=13)
    keys = [
        Line2D([], [], color="none", marker="o", mec=FOUND, mew=2.5, ls="", ms=10, label="clicked corner")
    ]
    said = f"The paper with {len(clicked)} of {len(CLICKED)} letters clicked."
    if pose is not None:
        marks, (phone,) = on_paper(as_points(points)), on_paper([(pose.x, pose.y)])
        ax.plot(*marks.T, "P", color=STYLES["ekf"].colour, mec="white", ms=11)
        plot_pose(Pose(float(phone[0]), float(phone[1]), pose.theta + np.pi / 2), ax, "truth", length=4.0)
        lowest = min(lowest, phone[1] - 5)
        keys += [
            Line2D(
                [],
                [],
                color=STYLES["ekf"].colour,
                marker="P",
                mec="white",
                ls="",
                ms=10,
                label="your landmarks",
            ),
            Line2D([], [], color=STYLES["truth"].colour, marker="o", ls="", ms=8, label="phone"),
        ]
        places = ", ".join(f"({x:.1f}, {y:.1f})" for x, y in marks)
        said += f" The phone is above ({phone[0]:.1f}, {phone[1]:.1f}) cm; landmarks: {places or 'none'}."
    ax.set(xlabel="to the right on the paper (cm)", ylabel="up on the paper (cm)", ylim=(lowest, None))
    ax.xaxis.label.set_color(INK)
    ax.yaxis.label.set_color(INK)
    legend_below(figure, keys)
    for text in figure.legends[0].get_texts():
        text.set_color(INK)
    return Drawing(figure, said, photo=True)


@cache
def _small_sheet() -> npt.NDArray[np.uint8]:
    """Return the sheet in the map's size."""
    return np.asarray(cv2.resize(sheet_pixels(), (560, 396), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _nearest(points: FloatArray) -> Any:
    """Return the distance of each point from the nearest landmark, on paper."""
    known = FIELD.detectable
    places = np.array([(mark.x, mark.y) for mark in known])
    rows = []
    for point in points:
        apart = np.linalg.norm(places - point, axis=1)
        mark = known[int(apart.argmin())]
        rows.append((f"{mark.kind} at ({mark.x:g}, {mark.y:g})", f"{100 * SCALE * apart.min():.1f} cm"))
    return table(("nearest landmark", "error of your point"), rows)
