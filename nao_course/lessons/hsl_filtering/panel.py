"""The filter panel: the student's colour filter in any light, with sliders, calibration by clicks, and scores."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from nao_course.lessons.hsl_filtering.instruments import circle_picture, histogram_picture, hue_counts
from nao_course.lessons.hsl_filtering.light import MARKS, in_light, lightness_counts
from nao_course.lessons.hsl_filtering.scores import (
    COLOURS,
    ERROR_COLOURS,
    PrecisionRecall,
    ScoreTable,
    error_classes,
    legend,
)
from nao_course.lessons.hsl_filtering.settings import FilterSettings, Limits
from nao_course.plotting import LABEL_COLOURS, Drawing, course_style, painted, plot_picture
from nao_course.plotting.legends import label_keys, legend_below
from nao_course.sim import LABELS
from nao_course.widgets import Action, Choice, FunctionPanel, Legend, Pixel
from nao_course.widgets.attempts import TIME_LIMIT, StudentCode, attempt
from nao_course.widgets.inputs import Values
from nao_course.widgets.shown import on_white

Pixels = npt.NDArray[np.uint8]
Label = Callable[[Pixels, Limits, Limits, float, float], Any]
Threshold = Callable[[float, float], float]
Calibrate = Callable[[Any, Any, float], Limits]

# Names of the student's functions in messages.
FILTER, THRESHOLD, CALIBRATE = ("your filter", "white_threshold", "calibrate_hue")
TRUTH = "True labels"
SLOW = 0.1  # s for one picture; whole-array code needs a tenth of it
SHOWN = {"Labels": "", TRUTH: "", **{f"Errors in {colour}": colour for colour in COLOURS}}
EPSILON = {"green": 10.0, "yellow": 0.0}  # degrees, as the paper widens limits
SCENE, LIGHTNESS, HUE = "The scene", "Lightness", "Hue"
_CSS = """
.nao-filter .nao-hue .noUi-connects { background: linear-gradient(to right, hsl(0 85% 55%), hsl(60 85% 50%),
  hsl(120 85% 42%), hsl(180 85% 45%), hsl(240 85% 60%), hsl(300 85% 55%), hsl(359 85% 55%)); }
.nao-filter .nao-hue .noUi-connect { background: none; }
.nao-laid-out.nao-filter .nao-body { --nao-most: 335px; }
"""


class FilterPanel(FunctionPanel):
    """Show a picture in any light with the labels of a colour filter and with its lightnesses and hues.

    Sliders set the light and the filter's limits. A pixel of the picture can be added to a colour's example; then your
    calibration function computes new limits. The panel calls your functions with copies of the picture.

    Parameters
    ----------
    picture : array_like of uint8, shape (H, W, 3), or mapping of str to these
        The scene to label, or several scenes by their names.
    truth : PictureTruth or array_like of int, shape (H, W), or mapping of str to these
        The true labels; one array serves for all scenes.
    label : callable
        ``label(picture, green, yellow, beta, min_saturation)`` returns labels (H, W): 0 other, 1 green, 2 yellow,
        3 white. It is called again for each change, so a corrected function is used at once.
    green, yellow : (float, float)
        Limits of the hue at the start, in degrees; the panel rounds them.
    beta : float
        Lower bound of the threshold at the start, 0 to 255.
    min_saturation : float
        Minimum saturation at the start, 0 to 1.
    threshold : callable, optional
        ``threshold(mean, beta)``, the lightness above which a pixel is white. Without it the threshold is not shown.
    calibrate : callable, optional
        ``calibrate(hue, saturation, epsilon)`` returns limits (low, high) of hues (N,).
    examples : mapping of str to index, optional
        Pixels of the first scene that are the examples of "green" and "yellow": a mask or slices.
    unfinished : str
        Message for functions that raise NotImplementedError.
    time_limit : float
        Seconds for one picture. A function that takes longer is stopped, and the panel shows a message.

    Raises
    ------
    ValueError
        If pictures and labels have different shapes, or a limit is out of its range.

    Examples
    --------
    >>> bright = np.full((2, 2, 3), 250, dtype=np.uint8)
    >>> def label(picture, green, yellow, beta, min_saturation):
    ...     return np.where(picture[..., 0] > beta, 3, 0).astype(np.uint8)
    >>> panel = FilterPanel(bright, np.full((2, 2), 3), label, green=(105, 150), yellow=(45, 60))
    >>> panel.set(light=0.4)
    >>> print(panel.summary())
    green 105° to 150°, yellow 45° to 60°, beta 120, minimum saturation 0.16, light 0.40
    Mean lightness 100. The pixel (1, 1) has lightness 100 and is grey: it has no hue.
    green: precision -, recall -
    yellow: precision -, recall -
    white: precision -, recall 0.0 %
    """

    css, wide_controls = _CSS, True

    def __init__(
        self,
        picture: Any,
        truth: Any,
        label: Label,
        *,
        green: Limits,
        yellow: Limits,
        beta: float = 120.0,
        min_saturation: float = 0.16,
        threshold: Threshold | None = None,
        calibrate: Calibrate | None = None,
        examples: Mapping[str, Any] | None = None,
        unfinished: str = "Finish exercises 1.1 to 1.5 to use this panel.",
        time_limit: float = TIME_LIMIT,
    ) -> None:
        """Create the widgets and label the first scene."""
        if not callable(label):
            raise ValueError(f"label must be a function that labels a picture, got {type(label).__name__}")
        self._scenes = _paired(picture, truth)
        self._known: tuple[Values, Pixels] | None = None  # labels, and where the controls stood
        self._made: dict[
            str, tuple[Any, Any]
        ] = {}  # by name: parts of the display, and what each was made from
        self._seconds = 0.0
        self._examples = _examples(examples or {}, next(iter(self._scenes.values()))[0])
        self._added: list[tuple[str, float, float]] = []  # colour, hue and saturation of each pixel
        scenes = [Choice("scene", "Scene", list(self._scenes), tooltip="The picture to label", stays=True)]
        given = {FILTER: label, THRESHOLD: threshold, CALIBRATE: calibrate}
        super().__init__(
            "Filter panel",
            self._label_scene,
            [
                *(scenes if len(self._scenes) > 1 else ()),
                Choice("shown", "Show", list(SHOWN), tooltip="Contents of the second picture"),
                self._pixel_control(),
                *(self._adders() if calibrate else ()),
                *FilterSettings(green, yellow, beta, min_saturation).sliders(),
            ],
            student={name: function for name, function in given.items() if function is not None},
            unfinished={FILTER: unfinished, THRESHOLD: "Finish exercise 1.3 to see the threshold."},
            small=(LIGHTNESS, HUE),
            time_limit=time_limit,
        )
        self.widget.add_class("nao-filter")

    def _pixel_control(self) -> Pixel:
        height, width = next(iter(self._scenes.values()))[0].shape[:2]
        return Pixel("pixel", "Pixel", (width, height), (width // 2, 5 * height // 6), picture=SCENE)

    def _adders(self) -> list[Action]:
        return [
            Action(
                f"to_{colour}",
                f"Add to {colour}",
                key=colour[0],
                tooltip=f"Add this pixel to {colour}'s example and calibrate again",
            )
            for colour in self._examples
        ]

    # --- from code ---

    def set(self, **settings: Any) -> None:
        """Set some of green, yellow, beta, min_saturation, light, pixel, shown and scene together.

        Raises
        ------
        ValueError
            If a value is out of its range.
        TypeError
            If there is no setting of that name.
        """
        others = {name: settings.pop(name) for name in ("pixel", "shown", "scene") if name in settings}
        changed = FilterSettings(**{**vars(self.settings), **settings})
        super().set(**changed.by_slider(), **others)

    def add(self, colour: str) -> None:
        """Add the selected pixel to a colour's example, calibrate again, and use the new limits.

        Parameters
        ----------
        colour : "green" or "yellow"
            Colour with an example.

        Raises
        ------
        ValueError
            If there is no such example.
        """
        if colour not in self._examples or CALIBRATE not in self._student:
            raise ValueError(f"colour must be one of {list(self._examples)}, got {colour!r}")
        hue, saturation, _ = self.chosen_pixel
        self._added.append((colour, hue, saturation))
        with self._one_at_a_time:
            found = attempt(
                lambda: self._calibrated(colour),
                f"{CALIBRATE}()",
                limit=self.time_limit,
                unfinished="Finish exercise 1.6 to calibrate with this pixel.",
                quiet=True,
            )
        if found.value is None:
            self._added.pop()
            self._take(dict(self._values))
            self._error, self._refused = found.error or self._error, found.message
        else:
            changed = FilterSettings(**{**vars(self.settings), colour: found.value})
            self._take(self._checked(changed.by_slider()))
        self._newest.ask()

    def reset(self) -> None:
        """Reset all controls and the examples to their initial values."""
        self._added.clear()
        super().reset()

    @property
    def chosen_pixel(self) -> tuple[float, float, float]:
        """Return hue in degrees, saturation and lightness of the selected pixel in the current light."""
        u, v = self.values.pixel
        picture = self._scene[0]
        row, column = min(v, picture.shape[0] - 1), min(u, picture.shape[1] - 1)
        pixel = in_light(picture[row : row + 1, column : column + 1], self.settings.light)
        hue, saturation, lightness = (float(each[0, 0]) for each in _hsl(pixel))
        return hue, saturation, lightness

    @property
    def settings(self) -> FilterSettings:
        """Return the current settings."""
        return FilterSettings.of_sliders(self.values)

    @property
    def labels(self) -> Pixels | None:
        """Return the labels (H, W) for the current settings, or None if your function failed."""
        return None if self._known is None else self._known[1]

    @property
    def scores(self) -> dict[str, PrecisionRecall]:
        """Return precision and recall of green, yellow and white, or an empty dict if your function failed."""
        labels, truth = self.labels, self._scene[1]
        if labels is None:
            return {}
        return {name: PrecisionRecall.of(labels == i, truth == i) for i, name in enumerate(COLOURS, start=1)}

    def say_values(self) -> str:
        """Return the current settings in words."""
        return str(self.settings)

    def summary(self) -> str:
        """Return the settings and the scores, one per line, or the reason why there are none."""
        scene = f"scene: {self.values.scene}\n" if len(self._scenes) > 1 else ""
        return scene + super().summary()

    @course_style()
    def drawing(self) -> Drawing:
        """Return a static figure of the panel, for pages without widgets."""
        scores = self.scores
        texts = [f"{name}: {scores[name]}" if name in scores else name for name in LABELS]
        figure = Figure(figsize=(6.4, 5.9))
        for ax, (title, pixels) in zip(figure.subplots(2, 2).flat, self.shown.pictures.items(), strict=False):
            plot_picture(on_white(pixels), ax, ticks=False)
            ax.set_title(title, fontsize=11)
            if title == SCENE:
                ax.plot(*self.values.pixel, "o", ms=9, mew=2, mfc="none", mec="#c84b00")
        legend_below(figure, label_keys(texts), columns=1)
        return Drawing(figure, f"Filter panel: {'; '.join(self.summary().splitlines())}", photo=True)

    def say_pace(self, seconds: float) -> str:
        """Return the settings and the time for the latest picture in words, or a hint if it is slow."""
        self._seconds = seconds or self._seconds  # the function is not called if only "Show" has changed
        pace = f"Your code labels a picture in {1000 * self._seconds:.0f} ms."
        if self._seconds > SLOW:
            return f"{pace} This is slow. Does your code loop over pixels?"
        return f"{self.say_values()}. {pace}"

    def __repr__(self) -> str:
        """Return the summary in one string."""
        return f"FilterPanel: {self.summary()}"

    # --- the student's functions ---

    @property
    def _scene(self) -> tuple[Pixels, Pixels]:
        return self._scenes[self.values.get("scene", next(iter(self._scenes)))]

    def _pressed(self, action: Action) -> None:
        colour = action.name.removeprefix("to_")
        if colour in self._examples:
            self.add(colour)
        else:
            super()._pressed(action)

    def _calibrated(self, colour: str) -> Limits:
        """Compute the limits of an example with all pixels that were added to it."""
        hue, saturation = self._examples[colour]
        added = np.array([each[1:] for each in self._added if each[0] == colour]).reshape(-1, 2)
        limits = self._student[CALIBRATE](
            np.append(hue, added[:, 0]), np.append(saturation, added[:, 1]), EPSILON[colour]
        )
        low, high = (float(each) % 360 for each in limits)
        return low, high

    def _label_scene(self, values: Values, student: StudentCode) -> Iterator[Any]:
        """Show the scene, its hues, the threshold and the labels; label again only if a parameter has changed."""
        known, self._known = self._known, None
        settings, (picture, truth) = self.settings, self._scene
        lit = values.get("scene"), settings.light
        shown, hue, saturation, counts, mean = self._kept(
            "light", lit, lambda: _lit(picture, truth, settings.light)
        )
        colour, title = SHOWN[values.shown], f"Your {values.shown[0].lower()}{values.shown[1:]}"
        title = TRUTH if values.shown == TRUTH else title
        marks = {"β": settings.beta, "mean": mean}
        yield {SCENE: shown, title: _unlabelled(truth.shape)}  # shown if the code below fails
        # The histogram replaces the first one below.
        yield {LIGHTNESS: shown, HUE: self._circle(lit, hue, saturation)}
        yield legend(colour)
        yield Legend({name: look[0] for name, look in MARKS.items()})
        yield {"Your labels": ScoreTable({})}
        words = f"Mean lightness {mean:.0f}. {self._say_pixel()}"
        try:
            if THRESHOLD in student:
                marks["threshold"] = float(student[THRESHOLD](mean, settings.beta))
                words = f"Threshold {marks['threshold']:.0f}. {words}"
        finally:  # if the threshold failed, the histogram is shown without it
            yield {LIGHTNESS: self._kept(LIGHTNESS, (lit, marks), lambda: histogram_picture(counts, marks))}
        yield words
        if known is not None and _only_looks_differ(known[0], values):
            self._known = values, known[1]
        else:
            s = settings
            given = student[FILTER](shown, s.green, s.yellow, s.beta, s.min_saturation)
            self._known = values, _checked(given, truth.shape)
        yield {title: painted(truth) if values.shown == TRUTH else self._coloured(colour)}
        yield {"Your labels": ScoreTable(self.scores)}

    def _kept(self, name: str, given: Any, make: Callable[[], Any]) -> Any:
        """Return a part of the display, and make it again only if it is made from other values than before."""
        if self._made.get(name, (None,))[0] != given:
            self._made[name] = given, make()
        return self._made[name][1]

    def _circle(self, lit: object, hue: npt.NDArray[Any], saturation: npt.NDArray[Any]) -> Any:
        """Draw the hues that are saturated enough, the limits, and the selected pixel."""
        (chosen, colourful, _), least = self.chosen_pixel, self.settings.min_saturation
        arcs = {LABEL_COLOURS[1]: self.settings.green, LABEL_COLOURS[2]: self.settings.yellow}
        marks = arcs, chosen if colourful > 0 else None, [each[1] for each in self._added]
        return self._kept(
            HUE,
            (lit, least, marks),
            lambda: circle_picture(hue_counts(hue, (saturation >= least) & (saturation > 0)), *marks),
        )

    def _say_pixel(self) -> str:
        (hue, saturation, lightness), (u, v) = self.chosen_pixel, self.values.pixel
        if not saturation:
            return f"The pixel ({u}, {v}) has lightness {lightness:.0f} and is grey: it has no hue."
        return f"The pixel ({u}, {v}) has hue {hue:.0f}°, saturation {saturation:.2f} and lightness {lightness:.0f}."

    def _coloured(self, colour: str) -> Pixels:
        """Return a picture of the labels or of the errors in one colour; all of class 0 if there are no labels."""
        labels, truth = self.labels, self._scene[1]
        if labels is None:
            return _unlabelled(truth.shape)
        if not colour:
            return painted(labels)
        label = LABELS.index(colour)
        return painted(error_classes(labels == label, truth == label), ERROR_COLOURS)


@cache
def _unlabelled(shape: tuple[int, int]) -> Pixels:
    """Return a picture in which every pixel has class 0."""
    return painted(np.zeros(shape, dtype=np.uint8))


def _only_looks_differ(before: Values, now: Values) -> bool:
    """Return True if only the display or the selected pixel has changed, but no argument of the filter."""
    looks = ("shown", "pixel")
    same = all(before[name] == value for name, value in now.items() if name not in looks)
    return same and any(before[name] != now[name] for name in looks)


def _lit(picture: Pixels, truth: Pixels, light: float) -> tuple[Any, ...]:
    """Return a picture in a light, its hues and saturations (H, W), its lightness counts and its mean lightness."""
    shown = in_light(picture, light)
    hue, saturation, lightness = _hsl(shown)
    return shown, hue, saturation, lightness_counts(lightness, truth), float(lightness.mean())


def _hsl(picture: Pixels) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]]:
    """Return hue in degrees, saturation and lightness, each (H, W), computed with OpenCV."""
    hue, lightness, saturation = cv2.split(cv2.cvtColor(picture.astype(np.float32) / 255, cv2.COLOR_RGB2HLS))
    return hue, saturation, 255 * lightness


def _examples(chosen: Mapping[str, Any], picture: Pixels) -> dict[str, tuple[Any, Any]]:
    """Return hue and saturation, each (N,), of the pixels of each colour's example."""
    if unknown := sorted(chosen.keys() - EPSILON.keys()):
        raise ValueError(f"examples must have the keys {list(EPSILON)}, got {unknown}")
    hue, saturation, _ = _hsl(picture)
    return {name: (hue[index].ravel(), saturation[index].ravel()) for name, index in chosen.items()}


def _checked(given: Any, shape: tuple[int, ...]) -> Pixels:
    """Return the answer as labels, or raise ValueError."""
    labels = np.asarray(given)
    if labels.shape != shape:
        raise ValueError(f"the labels must have shape {shape}, one for each pixel; got {labels.shape}")
    if labels.dtype.kind not in "iu":
        raise ValueError(f"the labels must be integers (uint8), got {labels.dtype}")
    if labels.min() < 0 or labels.max() >= len(LABELS):
        wrong = sorted(set(np.unique(labels).tolist()) - set(range(len(LABELS))))
        raise ValueError(f"the labels must be 0 other, 1 green, 2 yellow or 3 white; got {wrong[:5]}")
    return labels.astype(np.uint8)


def _paired(pictures: Any, truths: Any) -> dict[str, tuple[Pixels, Pixels]]:
    """Return the scenes by their names, each with its true labels."""
    named = dict(pictures) if isinstance(pictures, Mapping) else {"scene": pictures}
    if not named:
        raise ValueError("picture must contain at least one scene, got none")
    if isinstance(truths, Mapping) and set(truths) != set(named):
        raise ValueError(f"the scenes {list(named)} need true labels of the same names, got {list(truths)}")
    scenes = {}
    for name, each in named.items():
        truth = truths[name] if isinstance(truths, Mapping) else truths
        picture, labels = np.asarray(each), np.asarray(getattr(truth, "labels", truth))
        if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8 or not picture.size:
            raise ValueError(f"picture must be uint8 of shape (H, W, 3), got {picture.dtype} {picture.shape}")
        if labels.shape != picture.shape[:2]:
            raise ValueError(f"truth must have the picture's shape {picture.shape[:2]}, got {labels.shape}")
        scenes[str(name)] = (picture, labels.astype(np.uint8))
    return scenes
