"""The reality dial: every effect that makes a picture real, on a slider of its own."""

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
from nao_course.widgets.parts import LabelledImage, Newest, bundle, jpeg

PRESETS = ("clean", "lab", "dark", "harsh", "messy")
_FRACTIONS = ("seams", "gradient", "exposure", "vignette")  # at most 1
_STANDING = tuple(name for name in Reality.effects() if name != "motion")  # nothing shakes in this picture
_MEANINGS = {  # of the sliders; said where one is, and below the picture while it is moved
    "tilt": "leans the whole robot forwards or backwards",
    "grain": "the carpet's brightness from fibre to fibre",
    "mottle": "the carpet's brightness from patch to patch",
    "seams": "joints between the carpet's strips",
    "specks": "pale and dark specks on the carpet",
    "crumbs": "clusters of crumbs on the carpet",
    "tape": "dark tape along the outer lines",
    "pile": "the carpet is darker and greener from above than from the side",
    "glare": "lamps and windows shine back from the ground",
    "clutter": "how much stands and lies behind the field",
    "litter": "things that lie on the carpet beyond the lines",
    "sheets": "sheets of paper on the carpet",
    "gradient": "one end of the field gets less light",
    "white_balance": "the camera takes the light for redder or bluer than it is",
    "exposure": "the camera makes every picture equally bright on average",
    "overexposure": "white is beyond the brightest that the camera can show",
    "vignette": "corners of the picture are darker than its middle",
    "blur": "lens and sensor smear the picture",
    "noise": "the sensor adds random numbers to each pixel",
}
_TILT = float(np.radians(3.0))  # the largest on the slider, rad


class RealityDial:
    """One picture of the field, and a slider for each effect.

    Parameters
    ----------
    field : Field, optional
        By default half a field by the rules of 2012.
    pose : Pose, optional
        Where the robot stands, in the world.
    seed : int
        Of the noise; the picture is the same for the same sliders.

    Examples
    --------
    >>> dial = RealityDial()
    >>> dial.preset("clean")
    >>> dial.set(noise=10.0)
    >>> dial
    RealityDial: the robot leans by 0.0 degrees; on: noise 10
    """

    def __init__(self, field: Field | None = None, pose: Pose | None = None, seed: int = 0) -> None:
        """Begin with the laboratory's picture."""
        self.field, self.pose, self.seed = field or Field(), pose or Pose(0.6, -0.5, 0.2), seed
        self.reality, self.tilt = Reality.lab(), 0.0
        self._moving_sliders, self._moved, self._newest = False, "", Newest(self._show)
        self._image = LabelledImage(format="jpeg", layout=ipywidgets.Layout(width="480px"))
        self._said = ipywidgets.HTML()
        self._sliders = {name: self._slider(name) for name in _STANDING}
        self._tilt = self._made("tilt (degrees)", -3.0, 3.0, self._tilted)
        buttons = [
            ipywidgets.Button(description=name, tooltip=f"Set all effects as {name}") for name in PRESETS
        ]
        for button in buttons:
            button.on_click(lambda pressed: self.preset(pressed.description))
        shown = ipywidgets.VBox(
            [ipywidgets.HBox(buttons), self._image, self._said], layout=ipywidgets.Layout(width="500px")
        )
        sliders = ipywidgets.VBox([self._tilt, *self._sliders.values()])
        self.widget = ipywidgets.HBox([shown, sliders], layout=ipywidgets.Layout(flex_flow="row wrap"))
        self._show()

    # --- from code ---

    def preset(self, name: str) -> None:
        """Set all effects at once: "clean", "lab", "dark", "harsh" or "messy".

        Raises
        ------
        ValueError
            For another name.
        """
        if name not in PRESETS:
            raise ValueError(f"preset must be one of {PRESETS}, got {name!r}")
        self._put(getattr(Reality, name)(self.reality.seed))

    def set(self, **effects: float) -> None:
        """Set some effects, named as in `Reality`.

        Raises
        ------
        ValueError
            If a strength is not possible.
        TypeError
            For an effect that there is not.
        """
        changes: dict[str, Any] = dict(effects)
        self._put(replace(self.reality, **changes))

    @property
    def view(self) -> CameraView:
        """The camera's true view, with the tilt that is set."""
        return NAO_V4.view("bottom", pitch=float(np.radians(-26.0)), torso_pitch=self.tilt)

    @property
    def pixels(self) -> npt.NDArray[np.uint8]:
        """The picture (240, 320, 3) as the sliders are now."""
        rng = np.random.default_rng(self.seed)
        return render(self.field, self.pose, self.view, self.reality, rng)[0]

    def drawing(self) -> Drawing:
        """Return the picture as a figure."""
        return draw_picture(self.pixels, title="The reality dial")

    def summary(self) -> str:
        """Say which effects are on."""
        on = [
            f"{name} {getattr(self.reality, name):.3g}" for name in _STANDING if getattr(self.reality, name)
        ]
        lean = round(float(np.degrees(self.tilt)), 1) + 0.0  # no minus before a zero
        return f"the robot leans by {lean:.1f} degrees; on: {', '.join(on) or 'nothing'}"

    def __repr__(self) -> str:
        """Say what the dial shows."""
        return f"RealityDial: {self.summary()}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Show the widgets; beside them lie a picture and the summary for where they cannot live."""
        return bundle(self.widget, self.drawing(), repr(self), repr(self))

    # --- sliders ---

    def _slider(self, name: str) -> Any:
        presets = [getattr(getattr(Reality, preset)(), name) for preset in PRESETS]
        most = 1.0 if name in _FRACTIONS else max(3 * getattr(Reality.lab(), name), *presets)
        return self._made(name, 0.0, most, partial(self._slid, name), getattr(self.reality, name))

    @staticmethod
    def _made(name: str, low: float, high: float, action: Any, value: float = 0.0) -> Any:
        slider = ipywidgets.FloatSlider(
            value=value,
            min=low,
            max=high,
            step=(high - low) / 1000,  # a browser rounds to it: fine enough for every preset
            description=name,
            readout_format=".2f",
            tooltip=f"{name}: {_MEANINGS[name.split()[0]]}; from {low:g} to {high:g}",
            style={"description_width": "8em"},
            layout=ipywidgets.Layout(height="24px", width="340px"),
        )
        slider.observe(action, names="value")
        return slider

    def _slid(self, name: str, change: Any) -> None:
        if not self._moving_sliders:
            changes: dict[str, Any] = {name: float(change["new"])}
            self.reality, self._moved = replace(self.reality, **changes), name
            self._newest.ask()

    def _tilted(self, change: Any) -> None:
        self.tilt, self._moved = float(np.radians(change["new"])), "tilt"
        self._newest.ask()

    def _put(self, reality: Reality) -> None:
        """Take on effects, and move the sliders without a picture for each."""
        self.reality, self._moving_sliders, self._moved = reality, True, ""
        for name, slider in self._sliders.items():
            slider.value = getattr(reality, name)
        self._moving_sliders = False
        self._show()

    def _show(self) -> None:
        self._image.value = jpeg(self.pixels)
        self._image.alt = repr(self)
        meaning = f"<b>{self._moved}</b>: {_MEANINGS[self._moved]}<br>" if self._moved else ""
        self._said.value = f'<div role="status">{meaning}{self.summary()}</div>'
