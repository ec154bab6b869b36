"""The reality dial: a slider for each effect that makes a simulated picture realistic."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import ipywidgets
import numpy as np
import numpy.typing as npt

from nao_course.geometry import Pose
from nao_course.plotting import Drawing, draw_picture
from nao_course.sim import NAO_V4, CameraView, Field, Reality, render
from nao_course.widgets.layout import lay_out, place_beside
from nao_course.widgets.parts import RateLimited, box, bundle, status_box
from nao_course.widgets.picture_row import CSS, PictureRow

PRESETS = ("clean", "lab", "dark", "harsh", "messy")
_FRACTIONS = ("seams", "gradient", "exposure", "vignette")  # at most 1
_STANDING = tuple(name for name in Reality.effects() if name != "motion")  # this picture has no motion blur
_TILT_WORDS = ("tilt (degrees)", "tilts the whole robot forwards or backwards")
_GROUPS = {  # effect: its slider's label and explanation, which also appears below the picture while the slider moves
    "Carpet": {
        "grain": ("fibres", "the carpet's brightness from fibre to fibre"),
        "mottle": ("patches", "the carpet's brightness from patch to patch"),
        "pile": ("darker from above", "the carpet is darker and greener from above than from the side"),
        "seams": ("joints", "joints between the carpet's strips"),
        "specks": ("specks", "pale and dark specks on the carpet"),
        "crumbs": ("crumbs", "clusters of crumbs on the carpet"),
        "tape": ("tape", "dark tape along the outer lines"),
    },
    "Room and light": {
        "clutter": ("behind the field", "amount of furniture and clutter behind the field"),
        "litter": ("beside the field", "things that lie on the carpet beyond the lines"),
        "sheets": ("paper", "sheets of paper on the carpet"),
        "glare": ("glare", "lamps and windows are reflected by the ground"),
        "gradient": ("uneven light", "one end of the field gets less light"),
    },
    "Camera": {
        "white_balance": (
            "wrong colour",
            "the camera assumes a light that is redder or bluer than the real one",
        ),
        "exposure": ("auto exposure", "the camera makes every picture equally bright on average"),
        "overexposure": ("overexposure", "white is brighter than the largest value that the camera records"),
        "vignette": ("dark corners", "corners of the picture are darker than its centre"),
        "blur": ("blur", "lens and sensor smear the picture"),
        "noise": ("noise", "the sensor adds random numbers to each pixel"),
    },
}
_WORDS = {name: words for group in _GROUPS.values() for name, words in group.items()}
_CSS = """
.nao-controls, .nao-fold { overflow: visible; }
.nao-presets { flex-wrap: wrap; }
.nao-presets button { flex: 1 1 60px; width: auto; margin: 0; padding: 0 4px; }
.nao-controls .widget-slider { width: 100%; height: 24px; margin: 0; }
.nao-controls .jupyter-widget-Collapse-contents { padding: 4px; }
"""


class RealityDial:
    """A picture of the field with a slider for each effect.

    Parameters
    ----------
    field : Field, optional
        The field; by default half a field of 2012.
    pose : Pose, optional
        Pose of the robot in the world.
    seed : int
        Seed of the noise, so that equal sliders give equal pictures.

    Examples
    --------
    >>> dial = RealityDial()
    >>> dial.preset("clean")
    >>> dial.set(noise=10.0)
    >>> dial
    RealityDial: body tilt 0.0 degrees; on: noise 10
    """

    def __init__(self, field: Field | None = None, pose: Pose | None = None, seed: int = 0) -> None:
        """Begin with the preset "lab"."""
        self.field, self.pose, self.seed = field or Field(), pose or Pose(0.6, -0.5, 0.2), seed
        self.reality, self.tilt = Reality.lab(), 0.0
        self._moving_sliders, self._newest = False, RateLimited(self._show)
        self._moved: tuple[str, str] | None = None  # label and explanation of the last slider that was moved
        self._row, self._said = PictureRow("The reality dial"), ipywidgets.HTML()
        self._sliders = {name: self._slider(name) for name in _STANDING}
        self._tilt = self._made(_TILT_WORDS, -3.0, 3.0, self._tilted)
        buttons = [
            ipywidgets.Button(description=name, tooltip=f"Set all effects as {name}") for name in PRESETS
        ]
        for button in buttons:
            button.on_click(lambda pressed: self.preset(pressed.description))
        folds = ipywidgets.Accordion(
            [box("V", "nao-fold", *(self._sliders[name] for name in group)) for group in _GROUPS.values()],
            titles=[f"{title}: {len(group)} sliders" for title, group in _GROUPS.items()],
            selected_index=0,
        )
        sliders = box("V", "nao-controls", box("H", "nao-presets", *buttons), self._tilt, folds)
        self.widget = lay_out(CSS + _CSS, self._row.widget, [sliders], self._said)
        self.widget.add_class("nao-tall-side")
        self._show()

    # --- from code ---

    def preset(self, name: str) -> None:
        """Set all effects at once: "clean", "lab", "dark", "harsh" or "messy".

        Raises
        ------
        ValueError
            If there is no such preset.
        """
        if name not in PRESETS:
            raise ValueError(f"preset must be one of {PRESETS}, got {name!r}")
        self._put(getattr(Reality, name)(self.reality.seed))

    def set(self, **effects: float) -> None:
        """Set some effects, named as in `Reality`.

        Raises
        ------
        ValueError
            If a strength is outside its limits.
        TypeError
            If an effect does not exist.
        """
        changes: dict[str, Any] = dict(effects)
        self._put(replace(self.reality, **changes))

    @property
    def view(self) -> CameraView:
        """The camera's true view, with the tilt of the slider."""
        return NAO_V4.view("bottom", pitch=float(np.radians(-26.0)), torso_pitch=self.tilt)

    @property
    def pixels(self) -> npt.NDArray[np.uint8]:
        """The picture (240, 320, 3) for the present sliders."""
        rng = np.random.default_rng(self.seed)
        return render(self.field, self.pose, self.view, self.reality, rng)[0]

    def drawing(self) -> Drawing:
        """Return the picture as a figure."""
        return draw_picture(self.pixels, title="The reality dial")

    def summary(self) -> str:
        """Return the body tilt and the effects that are on as text."""
        strengths = {label: getattr(self.reality, name) for name, (label, _) in _WORDS.items()}
        on = [f"{label} {strength:.3g}" for label, strength in strengths.items() if strength]
        tilt = round(float(np.degrees(self.tilt)), 1) + 0.0  # without a minus sign before 0
        return f"body tilt {tilt:.1f} degrees; on: {', '.join(on) or 'nothing'}"

    def __repr__(self) -> str:
        """Return the body tilt and the effects that are on as text."""
        return f"RealityDial: {self.summary()}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the widgets, and a picture and the summary for places without widgets."""
        return bundle(self.widget, self.drawing(), repr(self), repr(self))

    # --- sliders ---

    def _slider(self, name: str) -> Any:
        presets = [getattr(getattr(Reality, preset)(), name) for preset in PRESETS]
        most = 1.0 if name in _FRACTIONS else max(3 * getattr(Reality.lab(), name), *presets)
        return self._made(_WORDS[name], 0.0, most, partial(self._slid, name), getattr(self.reality, name))

    @staticmethod
    def _made(words: tuple[str, str], low: float, high: float, action: Any, value: float = 0.0) -> Any:
        label, meaning = words
        slider = ipywidgets.FloatSlider(
            value=value,
            min=low,
            max=high,
            step=(high - low) / 1000,  # a browser rounds to this step, which is fine enough for every preset
            description=label,
            readout_format=".2f",
            tooltip=f"{label}: {meaning}; from {low:g} to {high:g}",
            style={"description_width": "9.5em"},
        )
        slider.observe(action, names="value")
        return slider

    def _slid(self, name: str, change: Any) -> None:
        if not self._moving_sliders and not _is_rounded(change, getattr(self.reality, name)):
            changes: dict[str, Any] = {name: float(change["new"])}
            self.reality, self._moved = replace(self.reality, **changes), _WORDS[name]
            self._newest.ask()

    def _tilted(self, change: Any) -> None:
        if not _is_rounded(change, float(np.degrees(self.tilt))):
            self.tilt, self._moved = float(np.radians(change["new"])), _TILT_WORDS
            self._newest.ask()

    def _put(self, reality: Reality) -> None:
        """Set the effects, move the sliders, and render one picture."""
        self.reality, self._moving_sliders, self._moved = reality, True, None
        for name, slider in self._sliders.items():
            slider.value = getattr(reality, name)
        self._moving_sliders = False
        self._show()

    def _show(self) -> None:
        self._row.show({" ": self.pixels})
        place_beside(self.widget, self._row.ratio)
        label, meaning = self._moved or ("", "")
        self._said.value = status_box(f"{label}: {meaning}" if label else "", self.summary())


def _is_rounded(change: Any, value: float) -> bool:
    """Return whether a slider has only rounded its value, as a browser does once it shows it."""
    return bool(abs(change["new"] - value) < 0.6 * change["owner"].step)
