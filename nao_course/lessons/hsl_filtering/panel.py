"""The filter panel: the student's colour filter on a picture, its limits on sliders, and how good its labels are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from nao_course.lessons.hsl_filtering.scores import (
    COLOURS,
    ERROR_COLOURS,
    PrecisionRecall,
    ScoreTable,
    error_classes,
    legend,
)
from nao_course.lessons.hsl_filtering.settings import FilterSettings, Limits
from nao_course.plotting import Drawing, course_style, painted, plot_picture
from nao_course.plotting.legends import label_keys, legend_below
from nao_course.sim import LABELS
from nao_course.widgets import Choice, FunctionPanel
from nao_course.widgets.attempts import TIME_LIMIT, StudentCode
from nao_course.widgets.function_panel import SLOW
from nao_course.widgets.inputs import Values

Pixels = npt.NDArray[np.uint8]
Label = Callable[[Pixels, Limits, Limits, float, float], Any]

FILTER = "your filter"  # the student's function, in messages
SHOWN = {"Labels": "", **{f"Errors in {colour}": colour for colour in COLOURS}}
_HUES = """
.nao-filter .nao-hue .noUi-connects { background: linear-gradient(to right, hsl(0 85% 55%), hsl(60 85% 50%),
  hsl(120 85% 42%), hsl(180 85% 45%), hsl(240 85% 60%), hsl(300 85% 55%), hsl(359 85% 55%)); }
.nao-filter .nao-hue .noUi-connect { background: none; }
"""


class FilterPanel(FunctionPanel):
    """A picture, the labels your colour filter gives it, and the true ones; sliders for the filter's limits.

    The panel itself cannot filter: it asks your function, each time with a copy of the picture.

    Parameters
    ----------
    picture : array_like of uint8, shape (H, W, 3), or mapping of str to these
        What to label; several scenes with their names can be chosen from.
    truth : PictureTruth or array_like of int, shape (H, W), or mapping of str to these
        The true labels; one array serves for all scenes.
    label : callable
        ``label(picture, green, yellow, beta, min_saturation)`` returns labels (H, W): 0 other, 1 green, 2 yellow,
        3 white. The names of your functions in it are looked up at each call, so a mended one is used at once.
    green, yellow : (float, float)
        Limits of the hue at the start, degrees; the panel goes on with whole ones.
    beta : float
        At the start, 0 to 255.
    min_saturation : float
        At the start, 0 to 1.
    unfinished : str
        What to say while `label` raises NotImplementedError.
    time_limit : float
        Seconds for one picture; a function that takes longer is stopped, and the panel says so.

    Raises
    ------
    ValueError
        If pictures and labels do not fit together, or a limit is out of its range.

    Examples
    --------
    >>> bright = np.full((2, 2, 3), 250, dtype=np.uint8)
    >>> def label(picture, green, yellow, beta, min_saturation):
    ...     return np.where(picture[..., 0] > beta, 3, 0).astype(np.uint8)
    >>> panel = FilterPanel(bright, np.full((2, 2), 3), label, green=(105, 150), yellow=(45, 60))
    >>> panel.set(beta=250)
    >>> print(panel.summary())
    green 105° to 150°, yellow 45° to 60°, beta 250, least saturation 0.16
    green: precision -, recall -
    yellow: precision -, recall -
    white: precision -, recall 0.0 %
    """

    css = _HUES

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
        unfinished: str = "Finish exercises 1.1 to 1.6 to move this panel.",
        time_limit: float = TIME_LIMIT,
    ) -> None:
        """Label the first scene and build the widgets."""
        if not callable(label):
            raise ValueError(f"label must be a function that labels a picture, got {type(label).__name__}")
        self._scenes = _paired(picture, truth)
        self._known: tuple[Values, Pixels] | None = None  # labels, and where the controls stood
        self._seconds = 0.0
        scenes = [Choice("scene", "Scene", list(self._scenes), tooltip="Which picture is labelled")]
        super().__init__(
            "Filter panel",
            self._label_scene,
            [
                *(scenes if len(self._scenes) > 1 else ()),
                Choice("shown", "Show", list(SHOWN), tooltip="What the picture in the middle shows"),
                *FilterSettings(green, yellow, beta, min_saturation).sliders(),
            ],
            student={FILTER: label},
            unfinished=unfinished,
            time_limit=time_limit,
        )
        self.widget.add_class("nao-filter")

    # --- from code ---

    def set(self, **settings: Any) -> None:
        """Set some of green, yellow, beta and min_saturation, at once.

        Raises
        ------
        ValueError
            If a value is out of its range.
        TypeError
            For a setting that there is not.
        """
        changed = FilterSettings(**{**vars(self.settings), **settings})
        super().set(**changed.by_slider())

    @property
    def settings(self) -> FilterSettings:
        """Where the sliders stand."""
        return FilterSettings.of_sliders(self.values)

    @property
    def labels(self) -> Pixels | None:
        """What your function gave for the present settings, (H, W); None where it failed."""
        return None if self._known is None else self._known[1]

    @property
    def scores(self) -> dict[str, PrecisionRecall]:
        """Precision and recall of green, yellow and white; empty where your function failed."""
        labels, truth = self.labels, self._scene[1]
        if labels is None:
            return {}
        return {name: PrecisionRecall.of(labels == i, truth == i) for i, name in enumerate(COLOURS, start=1)}

    def say_values(self) -> str:
        """Say where the sliders stand."""
        return str(self.settings)

    def summary(self) -> str:
        """Return the settings and the scores, a line each, or why there are none."""
        scene = f"scene: {self.values.scene}\n" if len(self._scenes) > 1 else ""
        return scene + super().summary()

    def drawing(self) -> Drawing:
        """Return what the panel shows as a figure, for where no widget can live."""
        picture, truth = self._scene
        scores = self.scores
        texts = [f"{name}: {scores[name]}" if name in scores else name for name in LABELS]
        with course_style():
            figure = Figure(figsize=(9.6, 3.2 * picture.shape[0] / picture.shape[1] + 0.95))
            shown = {"scene": picture, "your labels": self._coloured(""), "true labels": painted(truth)}
            for ax, (title, pixels) in zip(figure.subplots(1, 3), shown.items(), strict=True):
                plot_picture(pixels, ax, ticks=False)
                ax.set_title(title, fontsize=11)
            legend_below(figure, label_keys(texts), columns=2)
        return Drawing(figure, f"Filter panel: {'; '.join(self.summary().splitlines())}", photo=True)

    def say_pace(self, seconds: float) -> str:
        """Say how long the latest picture took, and why the panel lags if it does."""
        self._seconds = seconds or self._seconds  # nothing is asked where only "Show" has changed
        facts = f"Your code labels a picture in {1000 * self._seconds:.0f} ms."
        if self._seconds > SLOW:
            facts += " The panel follows slowly: a loop over pixels takes long, NumPy's whole arrays do not."
        return facts

    def __repr__(self) -> str:
        """Say what the panel shows."""
        return f"FilterPanel: {self.summary()}"

    # --- the student's filter ---

    @property
    def _scene(self) -> tuple[Pixels, Pixels]:
        return self._scenes[self.values.get("scene", next(iter(self._scenes)))]

    def _label_scene(self, values: Values, student: StudentCode) -> Iterator[Any]:
        """Show the scene and the truth, then the labels between them; ask anew unless only "Show" has changed."""
        known, self._known = self._known, None
        picture, truth = self._scene
        colour, title = SHOWN[values.shown], f"Your {values.shown[0].lower()}{values.shown[1:]}"
        yield {"The scene": picture, title: self._coloured(colour), "The true labels": painted(truth)}
        yield legend(colour)
        yield {"Your labels": ScoreTable({})}
        if (
            known is not None
            and known[0].shown != values.shown
            and known[0] == {**values, "shown": known[0].shown}
        ):
            self._known = values, known[1]
        else:
            s = self.settings
            given = student[FILTER](picture, s.green, s.yellow, s.beta, s.min_saturation)
            self._known = values, _checked(given, truth.shape)
        yield {title: self._coloured(colour)}
        yield {"Your labels": ScoreTable(self.scores)}

    def _coloured(self, colour: str) -> Pixels:
        """The labels, or the errors in one colour, as a picture; all of class 0 where there are none."""
        labels, truth = self.labels, self._scene[1]
        if labels is None:
            return painted(np.zeros_like(truth))
        if not colour:
            return painted(labels)
        label = LABELS.index(colour)
        return painted(error_classes(labels == label, truth == label), ERROR_COLOURS)


def _checked(given: Any, shape: tuple[int, ...]) -> Pixels:
    """Labels as they must be, or a ValueError."""
    labels = np.asarray(given)
    if labels.shape != shape:
        raise ValueError(f"the labels must have shape {shape}, one for each pixel; got {labels.shape}")
    if labels.dtype.kind not in "iu":
        raise ValueError(f"the labels must be whole numbers (uint8), got {labels.dtype}")
    if labels.min() < 0 or labels.max() >= len(LABELS):
        wrong = sorted(set(np.unique(labels).tolist()) - set(range(len(LABELS))))
        raise ValueError(f"the labels must be 0 other, 1 green, 2 yellow or 3 white; got {wrong[:5]}")
    return labels.astype(np.uint8)


def _paired(pictures: Any, truths: Any) -> dict[str, tuple[Pixels, Pixels]]:
    """Scenes by name, each with its true labels."""
    named = dict(pictures) if isinstance(pictures, Mapping) else {"scene": pictures}
    if not named:
        raise ValueError("picture must hold at least one scene, got none")
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
