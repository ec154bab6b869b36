"""The view of the student's functions: their results for the chosen camera's picture, and how the panel shows them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nao_course.geometry import Pose
from nao_course.sim import Picture
from nao_course.widgets.control_panel.pipeline import VIEWS, Pipeline, Seen, View


class StudentView:
    """The results of the student's functions for the pictures, and where the panel shows them.

    Each picture is processed once. Another view of it shows the same results, because a filter that is updated twice
    with one picture becomes overconfident. `latest` are the results for the picture that was processed last, and `path`
    the estimated poses, oldest first.
    """

    def __init__(self, pipeline: Pipeline | None) -> None:
        """Begin with the view "over" if a function is ready, else with the picture alone."""
        self._pipeline = pipeline
        self._view: View = "over" if self.available else "picture"
        self.latest = Seen()
        self._results: dict[str, tuple[Picture, Seen]] = {}  # for the last processed picture of each camera
        self.path: list[Pose] = []

    @property
    def available(self) -> bool:
        """Whether any function is ready."""
        return self._pipeline is not None and bool(self._pipeline.stages)

    @property
    def estimates(self) -> bool:
        """Whether one of the functions estimates the robot's pose."""
        return self._pipeline is not None and self._pipeline.estimates

    @property
    def drives(self) -> bool:
        """Whether one of the functions chooses where the robot goes."""
        return self._pipeline is not None and self._pipeline.drives

    @property
    def view(self) -> View:
        """Where the results are shown: "over" the picture, "beside" it, or not at all ("picture")."""
        return self._view

    @view.setter
    def view(self, view: View) -> None:
        if view not in VIEWS:
            raise ValueError(f"view must be one of {list(VIEWS)}, got {view!r}")
        if self._pipeline is None or not self._pipeline.stages:
            raise ValueError(
                "this panel has none of your functions, so it can show only the picture: make it with my_nao()"
            )
        self._view = view

    @property
    def next_view(self) -> View:
        """The view that the button switches to."""
        views = list(VIEWS)
        return views[(views.index(self._view) + 1) % len(views)]

    def retry(self) -> None:
        """Run functions that took too long again, from the next picture on."""
        if self._pipeline is not None:
            self._pipeline.retry()

    def perceive(self, picture: Picture) -> BaseException | None:
        """Run the functions on a picture unless they have processed it already; return the last exception."""
        if self._pipeline is None or picture is self._results.get(picture.camera, (None,))[0]:
            return None
        self.latest = self._pipeline.process(picture)
        self._results[picture.camera] = picture, self.latest
        if self.latest.estimate is not None:
            self.path.append(self.latest.estimate.pose)
        return self.latest.error

    def _seen(self, camera: str) -> Seen:
        return self._results[camera][1] if camera in self._results else Seen()

    def hides(self, camera: str, chosen: str) -> bool:
        """Return whether the results replace a camera's picture."""
        return self._view == "beside" and camera != chosen and bool(self._seen(chosen).names)

    def shown(self, camera: str, chosen: str, pictures: Mapping[str, Picture]) -> tuple[Any, str]:
        """Return the pixels for a camera's place, and a caption if they show more than its picture."""
        pixels, seen = pictures[camera].pixels, self._seen(chosen)
        if seen.names and self._view == "over" and camera == chosen:
            return seen.over(pixels), f"{camera} camera, your {seen.names}"
        if self.hides(camera, chosen):
            return seen.alone(pictures[chosen].pixels), f"your {seen.names}"
        return pixels, ""

    def live(self, camera: str, chosen: str, pictures: Mapping[str, Picture]) -> tuple[Any, str]:
        """Return the same for the page, with a short caption for the inset and with marks on the large picture."""
        seen = self._seen(chosen)
        if camera == chosen and self._view == "beside" and seen.names:
            return seen.marked(pictures[camera].pixels), f"{camera} camera, your marks"
        pixels, caption = self.shown(camera, chosen, pictures)
        return pixels, "your view" if self.hides(camera, chosen) else caption

    def heading(self) -> list[str]:
        """Return short lines about the functions that run and those still to come."""
        return [] if self._pipeline is None else self._pipeline.heading()

    def ready(self) -> list[str]:
        """Return lines that list the functions that run and those still missing."""
        return [] if self._pipeline is None else self._pipeline.summary()
