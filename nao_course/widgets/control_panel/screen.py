"""The display of the control panel: its pictures, its map and its status."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from typing import Any, Literal

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.plotting import Drawing
from nao_course.sim import SimulatedNao
from nao_course.slam import Estimate
from nao_course.widgets.control_panel.accuracy import Accuracy, accuracy, numbers_html, say_length
from nao_course.widgets.control_panel.cockpit import CAMERAS, LIVE_SIZE, Cockpit
from nao_course.widgets.control_panel.controls import Controls
from nao_course.widgets.control_panel.pipeline import VIEWS
from nao_course.widgets.control_panel.still import draw_still
from nao_course.widgets.control_panel.student_view import StudentView
from nao_course.widgets.parts import StatusKind, jpeg, status_box
from nao_course.widgets.vector_map import MapContents, VectorMap
from nao_course.widgets.world import WorldView

WORLD_SIZE = (480, 340)  # px
WORLD_HINT = "Drag to turn, Shift and the wheel zoom."  # short, for a narrow panel; keys drive the robot


class Screen:
    """The display of a control panel.

    `names` has each path's name in the map's legend by its source, and the estimate has the colours of `source`.
    `waiting` returns a sentence about the motions that still wait.
    """

    def __init__(
        self,
        cockpit: Cockpit,
        controls: Controls,
        own: StudentView,
        field_map: VectorMap,
        names: Mapping[str, str],
        source: Literal["ekf", "graph"],
        waiting: Callable[[], str],
    ) -> None:
        """Store the parts; the first `refresh` adds pictures."""
        self._cockpit, self._controls, self._own, self._map = cockpit, controls, own, field_map
        self._names, self._source, self._waiting = names, source, waiting
        self._world: WorldView | None = None  # made when it is first chosen
        self._in_3d = False

    @property
    def _camera(self) -> str:
        return str(self._controls.camera.value)

    @property
    def _with_truth(self) -> bool:
        return bool(self._controls.show_truth.value)

    def refresh(self) -> None:
        """Take a picture with the chosen camera, perceive it, and show everything."""
        self._cockpit.photograph(self._camera)
        self.show_chosen()

    def show_chosen(self) -> None:
        """Run the functions on the chosen camera's picture unless that was done already, and show everything."""
        self._cockpit.glance(self._camera)
        error = self._own.perceive(self._cockpit.pictures[self._camera])
        self._cockpit.error = error or self._cockpit.error
        self.show()

    def show(self) -> None:
        """Show the latest pictures, the map and the status, the small picture last: it must still be taken."""
        if self._controls.view is not None:
            self._controls.view.description = VIEWS[self._own.view]
        self._show_picture(self._camera)
        self._show_map()
        self.show_status()
        for camera in CAMERAS:
            if camera != self._camera:
                self._show_picture(camera)

    def show_status(self) -> None:
        """Show the numbers, the messages of the drive and of the student's functions, and the facts."""
        cockpit, seen = self._cockpit, self._own.latest
        self._show_numbers()
        alarm = cockpit.alarm or bool(seen.complaints)
        finish = "" if alarm else self._finish()
        message = "\n".join(
            filter(None, [finish or cockpit.message, self._waiting(), *seen.complaints, *seen.pace()])
        )
        board = seen.board[:1].upper() + seen.board[1:]
        printed = cockpit.printed + seen.printed
        kind: StatusKind = "alarm" if alarm else "finish" if finish else ""
        _show(
            self._controls.status,
            status_box(message, "", kind=kind, shows_where=alarm, printed=printed, board=board),
        )
        lines = [*cockpit.facts(self._with_truth), *seen.lines(), *self._own.ready()]
        facts = "".join(f"<li>{html.escape(line)}</li>" for line in lines)
        _show(self._controls.facts, f'<div class="nao-facts"><ul>{facts}</ul></div>')

    def _show_numbers(self) -> None:
        shown, estimated = self._accuracy(), self.estimate() is not None
        _show(self._controls.numbers, numbers_html(shown, self._hidden(), estimated))

    def _hidden(self) -> str:
        """Say how to see how far off the estimate is, where that is not shown."""
        if self._cockpit.truth is not None:
            return "tick Show the truth"
        simulated = isinstance(self._cockpit.nao, SimulatedNao)
        return "this panel has no truth" if simulated else "measure it: panel.measured_pose"

    def _accuracy(self) -> Accuracy:
        cockpit = self._cockpit
        truth = cockpit.truth.pose if self._with_truth and cockpit.truth is not None else cockpit.measured
        return accuracy(self.estimate() or cockpit.odometry[-1], truth)

    def _finish(self) -> str:
        """Return what is complete and what it took; empty if nothing is."""
        cockpit, finish = self._cockpit, self._own.latest.finish
        if not finish or not cockpit.moves:
            return ""
        said = f"{finish}: {cockpit.walked:.1f} m in {say_count(cockpit.moves, 'move')}"
        estimate = self.estimate()
        if estimate is None or not self._with_truth or cockpit.truth is None:
            return f"{said}."
        estimated, odometry = (
            say_length(accuracy(each, cockpit.truth.pose).error or 0.0)
            for each in (estimate, cockpit.odometry[-1])
        )
        return f"{said}, {estimated} off; odometry alone is {odometry} off."

    def summary(self) -> str:
        """Return the display's contents as text."""
        *facts, status = self._cockpit.summary(self._with_truth).splitlines()
        seen = self._own.latest
        return "\n".join([*facts, *self._own.ready(), *seen.lines(), *seen.complaints, status])

    def drawing(self) -> Drawing:
        """Return the display's contents as a figure, for places without widgets."""
        views = [(camera, *self.shown(camera)) for camera in CAMERAS]
        pictures = {whose or f"{camera} camera": pixels for camera, pixels, whose in views}
        alt = f"Control panel: {'; '.join(self.summary().splitlines())}"
        return draw_still(pictures, self._cockpit.nao.field, self.contents(), self._names, alt)

    def shown(self, camera: str) -> tuple[Any, str]:
        """Return the pixels for a camera's place, and a caption if they show more than its picture."""
        return self._own.shown(camera, self._camera, self._cockpit.pictures)

    def _show_picture(self, camera: str) -> None:
        if not self._own.hides(camera, self._camera):
            self._cockpit.glance(camera)
        image, caption = self._controls.images[camera], self._controls.captions[camera]
        pixels, whose = self._own.live(camera, self._camera, self._cockpit.pictures)
        alt = f"Live picture: {whose or f'{camera} camera'}"
        image.show(jpeg(pixels), alt, waits=camera == self._camera)
        width, height = size = self._cockpit.pictures[camera].view.size
        live = "live" if size == LIVE_SIZE else f"{width} × {height}"
        name = html.escape((whose or f"{camera} camera").capitalize())
        _show(caption, f"<b>{name}</b><span>, {live}</span>")

    def is_behind(self) -> bool:
        """Return whether a page is more than one picture of the chosen camera behind."""
        return bool(self._controls.images[self._camera].is_behind)

    def give_up(self) -> None:
        """Stop waiting for a page that does not answer, until one does."""
        for image in self._controls.images.values():
            image.shown = 0

    def switch_face(self) -> None:
        """Show the field in three dimensions in the map's place, or the map again."""
        nao = self._cockpit.nao
        if self._world is None:
            reality = nao.reality if isinstance(nao, SimulatedNao) else None
            self._world = WorldView(
                nao.field, WORLD_SIZE, model=nao.model, reality=reality, source=self._source
            )
            self._world.widget.hint = WORLD_HINT
        self._in_3d = not self._in_3d
        self._show_map()
        self._controls.show_face(self._world.widget if self._in_3d else None)

    def _show_map(self) -> None:
        if self._world is not None and self._in_3d:
            self._show_world(self._world)
        else:
            self._map.update(self.contents())

    def _show_world(self, world: WorldView) -> None:
        cockpit, contents = self._cockpit, self.contents()
        truth = cockpit.truth.pose if "truth" in contents.paths and cockpit.truth is not None else None
        nothing = np.empty((0, 0, 3), dtype=np.uint8)
        name = self._names["odometry" if self.estimate() is None else self._source]
        world.widget.estimate_name = name
        world.update(
            truth,
            self.estimate() or cockpit.odometry[-1],
            head=cockpit.head,
            pictures={
                each: cockpit.pictures[each].pixels if each == self._camera else nothing for each in CAMERAS
            },
            paths=contents.paths,
        )

    def estimate(self) -> Estimate | None:
        """Return the estimate of the panel's algorithm, else of the student's functions; None without one."""
        return self._cockpit.estimate if self._cockpit.slam is not None else self._own.latest.estimate

    def contents(self) -> MapContents:
        """Return the contents of the map."""
        cockpit, own = self._cockpit, self._own
        paths: dict[str, Any] = {}
        if self._with_truth and cockpit.truth is not None:
            paths["truth"] = cockpit.truth.path
        if "odometry" in self._names:
            paths["odometry"] = cockpit.odometry
        estimate = self.estimate()
        if cockpit.slam is not None:
            paths[self._source] = cockpit.estimated
        elif estimate is not None:
            paths[self._source] = own.path
        observer = self._source if paths.get(self._source) else "odometry"
        view = cockpit.pictures[self._camera].view
        ground = view.visible_ground()
        shown = self._accuracy()
        return MapContents(
            {name: tuple(path) for name, path in paths.items()},
            estimate,
            cockpit.seen,
            observer,
            own.latest.points,
            own.latest.cells,
            (view.yaw, view.hfov / 2, ground[1] if ground else np.inf),
            shown.short if shown.verdict == "overconfident" else None,
        )


def _show(widget: Any, value: str) -> None:
    """Set a widget's value if it is another one, so that the page gets no needless message."""
    if widget.value != value:
        widget.value = value
