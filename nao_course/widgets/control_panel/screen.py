"""The display of the control panel: its pictures, its map and its status."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from typing import Any

from nao_course.plotting import Drawing
from nao_course.widgets.control_panel.cockpit import CAMERAS, LIVE_SIZE, Cockpit
from nao_course.widgets.control_panel.controls import Controls
from nao_course.widgets.control_panel.live_map import LiveMap
from nao_course.widgets.control_panel.pipeline import VIEWS
from nao_course.widgets.control_panel.still import draw_still
from nao_course.widgets.control_panel.student_view import StudentView
from nao_course.widgets.parts import jpeg, png, status_box
from nao_course.widgets.vector_map import MapContents


class Screen:
    """The display of a control panel.

    Parameters
    ----------
    cockpit : Cockpit
        The robot, its pictures and its paths.
    controls : Controls
        The widgets.
    own : StudentView
        The results of the student's functions.
    names : mapping of str to str
        Name of each path in the map's legend, by its source.
    source : "ekf" or "graph"
        Source whose colours the estimate has.
    waiting : callable
        Returns a sentence about the motions that still wait.
    """

    def __init__(
        self,
        cockpit: Cockpit,
        controls: Controls,
        own: StudentView,
        names: Mapping[str, str],
        source: str,
        waiting: Callable[[], str],
    ) -> None:
        """Draw the empty field; the first `refresh` adds pictures."""
        self._cockpit, self._controls, self._own = cockpit, controls, own
        self._names, self._source, self._waiting = names, source, waiting
        self._map = LiveMap(cockpit.nao.field, names)
        self._stale: set[str] = set()  # cameras whose latest picture is older than the latest step

    @property
    def _camera(self) -> str:
        return str(self._controls.camera.value)

    @property
    def _with_truth(self) -> bool:
        return bool(self._controls.show_truth.value)

    def refresh(self) -> None:
        """Take the pictures that are visible, the chosen camera's first, and show everything."""
        for camera in sorted(CAMERAS, key=lambda each: each != self._camera):
            if self._own.hides(camera, self._camera):
                self._stale.add(camera)
            else:
                self._cockpit.photograph(camera)
                self._stale.discard(camera)
            if camera == self._camera:
                self._perceive()
            self._show_picture(camera)
        self._show_map()
        self.show_status()

    def show_chosen(self) -> None:
        """Show everything again after a new choice of camera, view or size, or after a picture was taken."""
        for camera in sorted(self._stale):
            self._cockpit.photograph(camera)
        self._stale.clear()
        self._perceive()
        self.show()

    def show(self) -> None:
        """Show the latest pictures, the map and the status."""
        if self._controls.view is not None:
            self._controls.view.description = VIEWS[self._own.view]
        for camera in CAMERAS:
            self._show_picture(camera)
        self._show_map()
        self.show_status()

    def show_status(self) -> None:
        """Show the facts and the messages of the drive and of the student's functions."""
        cockpit, seen = self._cockpit, self._own.seen
        lines = [line for line in seen.lines() if line != seen.board]
        facts = " · ".join([*cockpit.facts(self._with_truth), *lines, *seen.pace()])
        alarm = cockpit.alarm or bool(seen.complaints)
        message = "\n".join(filter(None, [cockpit.message, self._waiting(), *seen.complaints]))
        printed = cockpit.printed + seen.printed
        board = seen.board[:1].upper() + seen.board[1:]
        status = status_box(message, facts, alarm=alarm, shows_where=alarm, printed=printed, board=board)
        if self._controls.status.value != status:
            self._controls.status.value = status

    def summary(self) -> str:
        """Return the display's contents as text."""
        *facts, status = self._cockpit.summary(self._with_truth).splitlines()
        seen = self._own.seen
        return "\n".join([*facts, *self._own.ready(), *seen.lines(), *seen.complaints, status])

    def drawing(self) -> Drawing:
        """Return the display's contents as a figure, for places without widgets."""
        views = [(camera, *self.shown(camera)) for camera in CAMERAS]
        pictures = {whose or f"{camera} camera": pixels for camera, pixels, whose in views}
        alt = f"Control panel: {'; '.join(self.summary().splitlines())}"
        return draw_still(pictures, self._cockpit.nao.field, self.contents(), self._names, alt)

    def _perceive(self) -> None:
        error = self._own.perceive(self._cockpit.pictures[self._camera])
        self._cockpit.error = error or self._cockpit.error

    def shown(self, camera: str) -> tuple[Any, str]:
        """Return the pixels for a camera's place, and a caption if they show more than its picture."""
        return self._own.shown(camera, self._camera, self._cockpit.pictures)

    def _show_picture(self, camera: str) -> None:
        image, caption = self._controls.images[camera], self._controls.captions[camera]
        pixels, whose = self.shown(camera)
        image.value = jpeg(pixels)
        width, height = size = self._cockpit.pictures[camera].view.size
        live = "live" if size == LIVE_SIZE else f"{width} × {height}"
        said = f"<b>{html.escape((whose or f'{camera} camera').capitalize())}</b>, {live}"
        if caption.value != said:
            caption.value = said

    def _show_map(self) -> None:
        self._controls.map.value = png(self._map.draw(self.contents()))

    def contents(self) -> MapContents:
        """Return the contents of the map."""
        cockpit, own = self._cockpit, self._own
        paths: dict[str, Any] = {}
        if self._with_truth and cockpit.truth is not None:
            paths["truth"] = cockpit.truth.path
        paths["odometry"] = cockpit.odometry
        if cockpit.slam is not None:
            paths[self._source] = cockpit.estimated
        estimate = cockpit.estimate
        if cockpit.slam is None and own.seen.estimate is not None:
            estimate = own.seen.estimate
            paths[self._source] = own.path
        observer = self._source if paths.get(self._source) else "odometry"
        return MapContents(paths, estimate, cockpit.seen, observer, own.seen.points)
