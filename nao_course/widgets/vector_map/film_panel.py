"""Films in a notebook: recorded before, or recorded by a student's functions when the cell runs."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from typing import Any

import anywidget
import ipywidgets
import traitlets

from nao_course.films import Film, recorded_film, script, style_sheet
from nao_course.plotting import Drawing
from nao_course.widgets.attempts import TIME_LIMIT, Attempt, StudentCode, attempt, newest_definition
from nao_course.widgets.parts import box, bundle, status_box, styles

_RENDER = """
export default {
  render({ model, el }) {
    let player = null;
    const root = document.createElement("div");
    el.append(root);
    const build = () => {
      const film = model.get("film"), plays = Boolean(player?.direction);
      player?.remove();
      player = film.captions ? new NaoFilm.Player(root, structuredClone(film)) : null;
      if (player) player.onPlay = () => model.send({ ask: "newest" });
      if (plays) player?.toggle(1);
    };
    model.on("change:film", build);
    build();
    return () => { model.off("change:film", build); player?.remove(); };
  },
};
"""


class FilmWidget(anywidget.AnyWidget):
    """The widget of a film's player."""

    _esm = script("map", "player") + _RENDER
    _css = style_sheet()
    film = traitlets.Dict().tag(sync=True)


class VectorFilmPanel:
    """A film that a student's functions record once; the browser then plays it without Python.

    If a cell defines a function again, the next press of Play records the film again.

    Parameters
    ----------
    title : str
        Name of the panel, in messages.
    record : callable
        ``record(student)`` returns the `Film`.
    student : mapping of str to callable
        The student's functions, by the names under which `record` finds them.
    unfinished : mapping of str to str
        Message for each function that raises NotImplementedError.
    still : callable
        ``still(student)`` returns a `Drawing` of the same drive, for places without widgets.
    time_limit : float
        Seconds after which the recording is stopped.

    Attributes
    ----------
    film : Film or None
        The film; None if the recording failed.
    """

    def __init__(
        self,
        title: str,
        record: Callable[[StudentCode], Film],
        *,
        student: Mapping[str, Callable[..., Any]],
        unfinished: Mapping[str, str],
        still: Callable[[StudentCode], Drawing],
        time_limit: float = TIME_LIMIT,
    ) -> None:
        """Record the film and build the widgets."""
        self.title, self._record, self._still = title, record, still
        self._functions, self._student, self._unfinished = dict(student), StudentCode(student), unfinished
        self._limit = time_limit
        self._player, self._status = FilmWidget(film={}), ipywidgets.HTML()
        self._player.on_msg(self._asked)
        self.widget = box("V", "nao-panel", styles(""), self._player, self._status)
        self.record()

    def record(self) -> None:
        """Record the film with the newest definitions of the functions."""
        self._definitions = self._newest()
        self._student.begin()
        self._latest: Attempt[Film] = attempt(
            lambda: self._record(self._student),
            lambda: f"{self._student.called}()" if self._student.called else "the film",
            limit=self._limit,
            unfinished=lambda: self._unfinished.get(
                self._student.called, "Finish the exercise to see the film."
            ),
            quiet=True,
        )
        self.film = self._latest.value
        self._player.film = {} if self.film is None else self.film.data()
        latest = self._latest
        shows_where = latest.error is not None and not latest.unfinished
        self._status.value = (
            f'<div class="nao-facts">{self._say_pace()}</div>'
            if latest.done
            else status_box(latest.message, "", kind="alarm", shows_where=shows_where, printed=latest.printed)
        )

    @property
    def error(self) -> BaseException | None:
        """The exception of the student's code; ``raise panel.error`` shows where it was raised."""
        return self._latest.error

    def summary(self) -> str:
        """Return the first and last captions, or why there is no film."""
        return (
            self._latest.message
            if self.film is None
            else f"{self.film.captions[0]}\n{self.film.captions[-1]}"
        )

    def __repr__(self) -> str:
        """Return the panel's contents as text."""
        return f"{self.title}: {self.summary()}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the widgets, and a figure and the summary for places without widgets."""
        if self.film is None:
            return {**self.widget._repr_mimebundle_(), "text/plain": repr(self)}
        drawing = self._still(self._student)
        return bundle(self.widget, drawing, repr(self), drawing.alt)

    def _newest(self) -> list[Any]:
        return [newest_definition(each) for each in self._functions.values()]

    def _asked(self, widget: Any, message: Any, buffers: Any) -> None:
        if (
            isinstance(message, dict)
            and message.get("ask") == "newest"
            and self._newest() != self._definitions
        ):
            self.record()

    def _say_pace(self) -> str:
        return f"Your code took {1000 * self._student.seconds:.0f} ms for the whole film."


class RecordedFilm:
    """A film that the course ships, one of `nao_course.films.recorded_names`; another name raises a ValueError."""

    def __init__(self, name: str) -> None:
        """Read the film."""
        self._film = recorded_film(name)
        self.widget = box("V", "nao-panel", styles(""), FilmWidget(film=self._film))

    def __repr__(self) -> str:
        """Return the title and the last caption."""
        return f"Film: {self._film['title']}. At its end: {self._film['captions'][-1]}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the player, and a sentence for places without widgets."""
        return {
            **self.widget._repr_mimebundle_(),
            "text/plain": repr(self),
            "text/html": f"<p>{html.escape(repr(self))}</p>",
        }


def show_film(name: str) -> RecordedFilm:
    """Return a film that the course ships, such as "08_graph_slam", to be played in the notebook."""
    return RecordedFilm(name)
