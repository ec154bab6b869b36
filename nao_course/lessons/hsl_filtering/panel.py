"""The filter panel: the student's colour filter on a picture, its limits on sliders, and how good its labels are."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

import ipywidgets
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from nao_course.lessons.hsl_filtering.scores import (
    COLOURS,
    ERROR_COLOURS,
    Score,
    error_classes,
    legend,
    score_table,
)
from nao_course.lessons.hsl_filtering.settings import HUE_MOST, SLIDERS, FilterSettings, Limits
from nao_course.plotting import Drawing, course_style, painted, plot_picture
from nao_course.plotting.legends import label_keys, legend_below
from nao_course.sim import LABELS
from nao_course.widgets.attempts import TIME_LIMIT, Attempt, attempt
from nao_course.widgets.parts import (
    LabelledImage,
    Newest,
    box,
    bundle,
    html_line,
    jpeg,
    png,
    status_box,
    styles,
)

Pixels = npt.NDArray[np.uint8]
Label = Callable[[Pixels, Limits, Limits, float, float], Any]

SLOW = 0.1  # s for one picture: from here on the panel says why it lags
SHOWN = {"labels": "Labels", **{colour: f"Errors in {colour}" for colour in COLOURS}}
_CSS = """
.nao-filter .nao-pictures { gap: 8px; overflow: visible; }
.nao-filter .nao-pictures > * { flex: 1 1 0; min-width: 0; max-width: 322px; overflow: visible; }
.nao-filter .nao-pictures img { width: 100%; height: auto; margin: 0; border: 1px solid #888; box-sizing: border-box; }
.nao-filter .nao-choices { gap: 10px; align-items: center; flex-wrap: wrap; overflow: visible; }
.nao-filter .nao-choices .widget-dropdown { width: auto; min-width: 200px; margin: 0; }
.nao-filter .nao-choices .widget-label { width: auto; }
.nao-filter .nao-choices button { margin: 0; }
.nao-filter .nao-below { gap: 24px; flex-wrap: wrap; align-items: flex-start; overflow: visible; margin-top: 2px; }
.nao-filter .nao-sliders { flex: 1 1 480px; overflow: visible; }
.nao-filter .nao-sliders .widget-slider { width: 100%; max-width: 560px; height: 26px; margin: 0; }
.nao-filter .nao-sliders .widget-label { width: 120px; }
.nao-filter .nao-hue .noUi-connects { background: linear-gradient(to right, hsl(0 85% 55%), hsl(60 85% 50%),
  hsl(120 85% 42%), hsl(180 85% 45%), hsl(240 85% 60%), hsl(300 85% 55%), hsl(359 85% 55%)); }
.nao-filter .nao-hue .noUi-connect { background: none; }
.nao-filter .noUi-handle:focus { outline: 2px solid #0b5fa5; outline-offset: 2px; }
.nao-filter .nao-scores { flex: 0 0 auto; }
.nao-filter .nao-scores table { border-collapse: collapse; font-size: 13px; line-height: 22px; margin: 0; }
.nao-filter .nao-scores th, .nao-filter .nao-scores td { padding: 1px 10px; text-align: right; }
.nao-filter .nao-scores caption { text-align: left; font-weight: 600; padding: 0 10px; color: inherit; }
.nao-filter .nao-scores tbody th { text-align: left; font-weight: normal; }
.nao-filter .nao-scores tbody td { font-variant-numeric: tabular-nums; min-width: 70px; }
.nao-filter .nao-key { display: inline-block; width: 11px; height: 11px; border: 1px solid #555; margin-right: 5px;
  vertical-align: -1px; }
.nao-filter .nao-legend { font-size: 12px; line-height: 18px; }
.nao-filter .nao-legend span { white-space: nowrap; margin-right: 12px; }
"""


class FilterPanel:
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
        self._label, self._unfinished = label, unfinished
        self._start = self._settings = FilterSettings(green, yellow, beta, min_saturation)
        self.time_limit = time_limit
        self._latest: Attempt[Pixels] = Attempt()
        self._error: BaseException | None = None
        self._moving_sliders = False
        self._one_at_a_time = threading.RLock()
        self._newest = Newest(self._relabel)
        self._build()
        self._show_scene()
        self._relabel()

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
        self._put(FilterSettings(**{**vars(self._settings), **settings}))

    def reset(self) -> None:
        """Set all sliders back to where they began."""
        self._put(self._start)

    @property
    def settings(self) -> FilterSettings:
        """Where the sliders stand."""
        return self._settings

    @property
    def labels(self) -> Pixels | None:
        """What your function gave for the present settings, (H, W); None where it failed."""
        return self._latest.value

    @property
    def scores(self) -> dict[str, Score]:
        """Precision and recall of green, yellow and white; empty where your function failed."""
        labels, truth = self.labels, self._scene[1]
        if labels is None:
            return {}
        return {name: Score.of(labels == i, truth == i) for i, name in enumerate(COLOURS, start=1)}

    @property
    def error(self) -> BaseException | None:
        """What your function raised last; ``raise panel.error`` shows where it came from."""
        return self._error

    def summary(self) -> str:
        """Return the settings and the scores, a line each, or why there are none."""
        scene = [f"scene: {self._scene_name}"] if len(self._scenes) > 1 else []
        scores = [f"{name}: {score}" for name, score in self.scores.items()]
        return "\n".join([*scene, str(self._settings), *(scores or [self._latest.message])])

    def drawing(self) -> Drawing:
        """Return what the panel shows as a figure, for where no widget can live."""
        picture, truth = self._scene
        scores = self.scores
        texts = [f"{name}: {scores[name]}" if name in scores else name for name in LABELS]
        with course_style():
            figure = Figure(figsize=(9.6, 3.2 * picture.shape[0] / picture.shape[1] + 0.95))
            shown = {"scene": picture, "your labels": self._coloured(), "true labels": painted(truth)}
            for ax, (title, pixels) in zip(figure.subplots(1, 3), shown.items(), strict=True):
                plot_picture(pixels, ax, ticks=False)
                ax.set_title(title, fontsize=11)
            legend_below(figure, label_keys(texts), columns=2)
        return Drawing(figure, f"Filter panel: {'; '.join(self.summary().splitlines())}", photo=True)

    def __repr__(self) -> str:
        """Say what the panel shows."""
        return f"FilterPanel: {self.summary()}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Show the widgets; beside them lie a picture and the summary for where they cannot live."""
        drawing = self.drawing()
        return bundle(self.widget, drawing, repr(self), drawing.alt)

    # --- the student's filter ---

    def _relabel(self) -> None:
        """Ask the student's function, and show what comes of it."""
        with self._one_at_a_time:  # a slider's thread and a cell's
            self._latest = Attempt(message="Interrupted.")  # unless what follows comes to its end
            self._latest = attempt(
                self._ask, "your filter", limit=self.time_limit, unfinished=self._unfinished, quiet=True
            )
            self._error = self._latest.error or self._error
            self._show_labels()

    def _ask(self) -> Pixels:
        picture, truth = self._scene
        s = self._settings
        labels = np.asarray(self._label(picture.copy(), s.green, s.yellow, s.beta, s.min_saturation))
        if labels.shape != truth.shape:
            raise ValueError(
                f"the labels must have shape {truth.shape}, one for each pixel; got {labels.shape}"
            )
        if labels.dtype.kind not in "iu":
            raise ValueError(f"the labels must be whole numbers (uint8), got {labels.dtype}")
        if labels.min() < 0 or labels.max() >= len(LABELS):
            wrong = sorted(set(np.unique(labels).tolist()) - set(range(len(LABELS))))
            raise ValueError(f"the labels must be 0 other, 1 green, 2 yellow or 3 white; got {wrong[:5]}")
        return labels.astype(np.uint8)

    # --- showing ---

    @property
    def _scene_name(self) -> str:
        return str(self._choice.value)

    @property
    def _scene(self) -> tuple[Pixels, Pixels]:
        return self._scenes[self._scene_name]

    def _coloured(self, shown: str = "labels") -> Pixels:
        """The labels, or the errors in one colour, as a picture; all of class 0 where there are none."""
        labels, truth = self.labels, self._scene[1]
        if labels is None:
            return painted(np.zeros_like(truth))
        if shown == "labels":
            return painted(labels)
        label = LABELS.index(shown)
        return painted(error_classes(labels == label, truth == label), ERROR_COLOURS)

    def _show_scene(self) -> None:
        picture, truth = self._scene
        self._images["scene"].value = jpeg(picture)
        self._images["truth"].value = png(painted(truth))

    def _show_labels(self) -> None:
        """Show the labels as they are, without asking again."""
        shown = str(self._shown.value)
        self._images["labels"].value = png(self._coloured(shown))
        self._captions[
            "labels"
        ].value = f"<b>Your {'labels' if shown == 'labels' else SHOWN[shown].lower()}</b>"
        self._legend.value = legend(shown)
        self._table.value = score_table(self.scores)
        self._status.value = self._said()

    def _said(self) -> str:
        latest = self._latest
        if not latest.done:
            where = latest.error is not None and not latest.unfinished
            facts = str(self._settings)
            return status_box(latest.message, facts, alarm=True, shows_where=where, printed=latest.printed)
        facts = f"Your code labels a picture in {1000 * latest.seconds:.0f} ms."
        if latest.seconds > SLOW:
            facts += " The panel follows slowly: a loop over pixels takes long, NumPy's whole arrays do not."
        return status_box(str(self._settings), facts, printed=latest.printed)

    # --- widgets ---

    def _build(self) -> None:
        self._sliders = {name: self._slider(name) for name in SLIDERS}
        names = {"scene": "The scene", "labels": "Your labels", "truth": "The true labels"}
        self._captions = {name: html_line(f"<b>{text}</b>", "nao-caption") for name, text in names.items()}
        self._images = {name: _image(name, text) for name, text in names.items()}
        columns = [box("V", "nao-column", self._captions[name], self._images[name]) for name in names]
        self._choice = ipywidgets.Dropdown(description="Scene", options=list(self._scenes))
        self._choice.tooltip = "Which picture is labelled"
        self._choice.observe(self._scene_chosen, "value")
        self._shown = ipywidgets.Dropdown(
            description="Show", options=[(text, name) for name, text in SHOWN.items()], value="labels"
        )
        self._shown.tooltip = "What the picture in the middle shows"
        self._shown.observe(lambda change: self._show_labels(), "value")
        again = ipywidgets.Button(description="Reset", tooltip="Set all sliders back to where they began")
        again.on_click(lambda pressed: self.reset())
        again.add_class("nao-do-reset")
        self._legend, self._table = html_line("", "nao-legend"), html_line("", "nao-scores")
        self._status = ipywidgets.HTML()
        choices = [self._choice] if len(self._scenes) > 1 else []
        self.widget = box(
            "V",
            "nao-panel",
            styles(_CSS),
            box("H", "nao-pictures", *columns),
            box("H", "nao-choices", *choices, self._shown, again, self._legend),
            box("H", "nao-below", box("V", "nao-sliders", *self._sliders.values()), self._table),
            self._status,
        )
        self.widget.add_class("nao-filter")

    def _slider(self, name: str) -> Any:
        label, tooltip, most, step, shape = SLIDERS[name]
        slider = ipywidgets.FloatSlider(
            value=self._settings.of_slider(name),
            min=0.0,
            max=most,
            step=step,
            description=label,
            readout_format=shape,
            tooltip=tooltip,
        )
        slider.add_class(f"nao-slider-{name.replace('_', '-').replace(' ', '-')}")
        if most == HUE_MOST:
            slider.add_class("nao-hue")
        slider.observe(self._slid, names="value")
        return slider

    def _slid(self, change: Any) -> None:
        if self._moving_sliders:
            return
        values = {name: float(slider.value) for name, slider in self._sliders.items()}
        self._settings = FilterSettings(
            (values["green low"], values["green high"]),
            (values["yellow low"], values["yellow high"]),
            values["beta"],
            values["min_saturation"],
        )
        self._newest.ask()

    def _put(self, settings: FilterSettings) -> None:
        """Take on settings, and move the sliders without a picture for each."""
        self._settings, self._moving_sliders = settings, True
        for name, slider in self._sliders.items():
            slider.value = settings.of_slider(name)
        self._moving_sliders = False
        self._relabel()

    def _scene_chosen(self, change: Any) -> None:
        self._show_scene()
        self._newest.ask()


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


def _image(name: str, text: str) -> Any:
    image = LabelledImage(format="jpeg" if name == "scene" else "png", tooltip=text)
    image.add_class(f"nao-image-{name}")
    return image
