"""A view of the world in three dimensions, in the browser or as a picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from types import EllipsisType
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray, Pose, finite
from nao_course.plotting import Drawing, PathLike
from nao_course.plotting.style import style_of
from nao_course.sim import NAO_V4, Field, NaoModel, Reality
from nao_course.sim.camera import check_size
from nao_course.slam import Estimate
from nao_course.widgets.parts import RateLimited, bundle, jpeg
from nao_course.widgets.world.canvas import Pixels
from nao_course.widgets.world.contents import Ray, WorldContents, positions
from nao_course.widgets.world.picture import render_world
from nao_course.widgets.world.scene import PRESETS, Preset, Viewpoint, WorldScene
from nao_course.widgets.world.widget import WorldWidget

CONE_QUALITY = 75  # of a JPEG file: the pictures in the view cones are small
PATH_STEP = 0.05  # m: a path is sent to the browser with about this distance between its points


class WorldView:
    """A view of the field, its room and the robot in three dimensions, which one can turn with the mouse or keys.

    Write the view in the last line of a cell to show it. Without widgets, or in a browser without WebGL, it is a
    picture.

    Parameters
    ----------
    field : Field, optional
        The field; by default half a field of 2012.
    size : (int, int)
        Largest width and height, px; a narrower page makes it smaller.
    model : NaoModel
        The robot's dimensions.
    reality : Reality, optional
        Appearance; its seed and its clutter choose the room, so that it is the one in the robot's pictures.
    source : "ekf" or "graph"
        Source whose colour the estimate has.
    viewpoint : "behind", "above" or "goal"
        First viewpoint: behind the robot, above the field, or from the goal.

    Raises
    ------
    ValueError
        If the size, the source or the viewpoint is not possible.

    Examples
    --------
    >>> world = WorldView()
    >>> world.update(truth=Pose(1.0, 0.5, 0.0), head=(0.5, 0.2))
    >>> world
    WorldView: robot at (1.00, 0.50) m, heading 0 deg; head yaw 29 deg, pitch 11 deg
    """

    def __init__(
        self,
        field: Field | None = None,
        size: tuple[int, int] = (640, 400),
        *,
        model: NaoModel = NAO_V4,
        reality: Reality | None = None,
        source: Literal["ekf", "graph"] = "ekf",
        viewpoint: Preset = "behind",
    ) -> None:
        """Begin with an empty field."""
        self.scene = WorldScene(field or Field(), reality or Reality(), model)
        self.size = check_size(size)
        style_of(source)
        self.source = source
        self.contents = WorldContents()
        self._viewpoint = self._preset(viewpoint)
        self._still = RateLimited(self._send_still)

    # --- from code ---

    def update(
        self,
        truth: Pose | EllipsisType | None = ...,
        estimate: Estimate | Pose | EllipsisType | None = ...,
        *,
        head: tuple[float, float] | EllipsisType = ...,
        tilt: tuple[float, float] | EllipsisType = ...,
        pictures: Mapping[str, npt.NDArray[np.uint8]] | EllipsisType = ...,
        rays: Iterable[Ray] | EllipsisType = ...,
        paths: Mapping[str, PathLike] | EllipsisType = ...,
    ) -> None:
        """Change what the view shows; arguments that are not given leave their part as it is.

        The browser moves the robots smoothly from one update to the next, and lets their legs walk. One update takes
        about one kilobyte, and the pictures as JPEG files.

        Parameters
        ----------
        truth : Pose or None
            True pose of the robot in the world frame; None hides it.
        estimate : Estimate, Pose or None
            Estimate in the world frame, drawn as a translucent robot with its map and ellipses of 95 %; None hides it.
        head : (float, float)
            Yaw and pitch of the head, rad; positive to the left and down.
        tilt : (float, float)
            Pitch and roll of the true robot's body, rad; positive to the front and to the right.
        pictures : mapping of str to ndarray of uint8, shape (H, W, 3)
            Pictures of the cameras "top" and "bottom", which are shown in their view cones. A camera that is left out
            keeps its picture, and an array of size 0 removes it.
        rays : iterable of Ray
            Rays from the cameras to points.
        paths : mapping of str to sequence of Pose, or to array_like of shape (N, 2) or (N, 3)
            Paths in the world frame by source: "truth", "odometry", "ekf" or "graph".

        Raises
        ------
        ValueError
            If a value has the wrong type or shape, or an angle is beyond the limits of its joint. The view then stays
            as it was.
        """
        changes: dict[str, Any] = {}
        if truth is not ...:
            changes["truth"] = _checked_pose(truth)
        if estimate is not ...:
            changes["estimate"] = _as_estimate(estimate)
        if head is not ...:
            changes["head"] = self.scene.model.check_head(*head)
        if tilt is not ...:
            changes["tilt"] = tuple(finite("tilt (rad)", each) for each in tilt)
        if pictures is not ...:
            for camera in pictures:
                self.scene.model.check_camera(camera)
            both = {**self.contents.pictures, **pictures}
            changes["pictures"] = {name: each for name, each in both.items() if np.size(each)}
        if rays is not ...:
            changes["rays"] = tuple(rays)
            for ray in changes["rays"]:
                self.scene.model.check_camera(ray.camera)
        if paths is not ...:
            changes["paths"] = {name: positions(path) for name, path in paths.items()}
            for name in paths:
                style_of(name)
        before, self.contents = self.contents, replace(self.contents, **changes)
        if "widget" in vars(self):
            self._send(before)

    def view_from(self, preset: Preset) -> None:
        """Look from "behind" the robot, from "above", or from the "goal".

        Raises
        ------
        ValueError
            If there is no such viewpoint.
        """
        self._viewpoint = self._preset(preset)
        if "widget" in vars(self):
            self.widget.viewpoint = self._viewpoint.data()

    @property
    def viewpoint(self) -> Viewpoint:
        """The place from which the scene is seen, also after the reader moved it."""
        return self._viewpoint

    @property
    def pixels(self) -> Pixels:
        """The view as a picture (H, W, 3), by the course's own renderer."""
        return render_world(self.scene, self.contents, self._viewpoint, self.source, self.size)

    def drawing(self) -> Drawing:
        """Return the view as a figure."""
        return drawing_of(self.pixels, self.summary())

    def summary(self) -> str:
        """Return the contents as text."""
        return self.contents.summary()

    def __repr__(self) -> str:
        """Return the contents as text."""
        return f"WorldView: {self.summary()}"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """Return the widget, and a picture and the summary for places without widgets."""
        return bundle(self.widget, self.drawing(), repr(self), f"3-D view of the field. {self.summary()}")

    # --- the browser ---

    @cached_property
    def widget(self) -> WorldWidget:
        """The view as a widget, for a layout with other widgets; it is made when it is first used."""
        widget = WorldWidget(
            scene=self.scene.data(),
            size=list(self.size),
            source=self.source,
            contents=self.contents.data(),
            trails=_trails(self.contents.paths),
            viewpoint=self._viewpoint.data(),
            summary=self.summary(),
            **{camera: jpeg(pixels, CONE_QUALITY) for camera, pixels in self.contents.pictures.items()},
        )
        widget.observe(self._moved, names="viewpoint")
        widget.observe(lambda change: self._still.ask(), names="needs_still")
        return widget

    def _send(self, before: WorldContents) -> None:
        """Send what changed in one message."""
        now = self.contents
        with self.widget.hold_sync():
            self.widget.summary = self.summary()
            self.widget.contents = now.data()
            if now.paths is not before.paths:
                self.widget.trails = _trails(now.paths)
            for camera in self.scene.model.cameras:
                picture = now.pictures.get(camera)
                if picture is not before.pictures.get(camera):
                    setattr(self.widget, camera, b"" if picture is None else jpeg(picture, CONE_QUALITY))
        if self.widget.needs_still:
            self._still.ask()

    def _moved(self, change: Any) -> None:
        values = dict(change["new"])
        self._viewpoint = Viewpoint(**{**values, "target": tuple(values["target"])})
        if self.widget.needs_still:
            self._still.ask()

    def _send_still(self) -> None:
        self.widget.still = jpeg(self.pixels)

    def _preset(self, name: Preset) -> Viewpoint:
        if name not in PRESETS:
            raise ValueError(f"the viewpoint must be one of {', '.join(map(repr, PRESETS))}, got {name!r}")
        return self.scene.presets[name]


def drawing_of(pixels: Pixels, alt: str) -> Drawing:
    """Return a picture (H, W, 3) as a figure of the same size."""
    height, width = pixels.shape[:2]
    figure = Figure(figsize=(width / 100, height / 100), dpi=100)
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    ax.set_axis_off()
    ax.imshow(pixels, interpolation="none")
    return Drawing(figure, alt, photo=True)


def _checked_pose(pose: Pose | None) -> Pose | None:
    if pose is not None and not isinstance(pose, Pose):
        raise ValueError(f"truth must be a Pose or None, got {type(pose).__name__}")
    return pose


def _as_estimate(given: Estimate | Pose | None) -> Estimate | None:
    """Return an estimate; a pose alone has no ellipse."""
    if given is None or isinstance(given, Estimate):
        return given
    if not isinstance(given, Pose):
        raise ValueError(f"estimate must be an Estimate, a Pose or None, got {type(given).__name__}")
    return Estimate(given, np.full((3, 3), np.nan), np.empty((0, 2)), np.empty((0, 2, 2)))


def _trails(paths: Mapping[str, FloatArray]) -> dict[str, list[int]]:
    """Return paths in millimetres, [x, y, x, y, ...], without points that are close to the one before."""
    return {name: np.rint(1000 * _thinned(path)).astype(int).ravel().tolist() for name, path in paths.items()}


def _thinned(path: FloatArray) -> FloatArray:
    """Return the first point, the last one, and those in between that begin another `PATH_STEP`."""
    sound = path[np.isfinite(path).all(axis=1)]
    if len(sound) < 3:
        return sound
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(sound, axis=0), axis=1))])
    begins = np.diff(np.floor(along / PATH_STEP), prepend=-1.0) > 0
    begins[-1] = True
    return np.asarray(sound[begins])
