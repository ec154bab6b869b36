"""Make the pictures of README, docs and lessons, and the films: ``python images/make.py``, or some: ``... effects``.

``python images/make.py slides`` writes each lesson's figures for slides, with captions, into build/slides, and
``python images/make.py panels`` contact sheets of all panels into build/panels.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from rich.console import Console

from nao_course.instructor.authoring.course import load_course

ROOT = Path(__file__).resolve().parents[1]
Files = Mapping[Path, bytes]  # contents by the path under ROOT

# Each maker imports what it alone needs: all of it together takes five seconds.


def drawn_demo() -> Files:
    """The lessons' solutions drive the robot: figure, and film as pictures and as numbers."""
    from nao_course.cli import demo

    folder = Path("build", "demo")
    demo(slam="both", joint=False, kidnap=False, seed=1, out=folder, walk=None, recording=None, field=None)
    return {
        **{Path("images", name): (folder / name).read_bytes() for name in ("demo.png", "demo.webp")},
        Path("nao_course", "films", "recordings", "demo.json"): (folder / "film.json").read_bytes(),
    }


def screen(name: str) -> Files:
    """The course in a browser."""
    from images import screens

    return {Path("images", f"{name}.webp"): getattr(screens, name)()}


def effects() -> Files:
    """What each effect of the simulator's pictures does."""
    from images.effects import draw_effects

    return {Path("images", "effects.webp"): draw_effects()}


def own_fields() -> Files:
    """Three fields of the course, from above and through the robot's camera."""
    from images.fields import draw_fields

    return {Path("images", "own_fields.png"): draw_fields()}


def house() -> Files:
    """The three wings of the project."""
    from images.house import draw_house

    return {Path("images", "house.png"): draw_house()}


def real_building() -> Files:
    """A graph of a real building, relaxed by lesson 09's solution."""
    from nao_course.instructor.authoring.plans import load_solution
    from nao_course.lessons.pose_graphs import draw_real_building

    solution = load_solution(Path("solutions", "09_pose_graphs.ipynb"))
    return in_lessons("09_intel.png", draw_real_building(solution["gauss_newton"]).image())


def real_walk() -> Files:
    """The maps of a recorded walk, by lesson 11's solution."""
    from benchmarks.field import field_walk

    return in_lessons("11_real_walk.png", field_walk.draw_maps())


def slides() -> Files:
    """Return each lesson's figures for slides, with captions, in build/slides."""
    from images.slides import slides_of

    return {path: content for name in COURSE.names() for path, content in slides_of(COURSE, name).items()}


def panels() -> Files:
    """Contact sheets of all panels on the pages that students have, in build/panels."""
    from images.panels import contact_sheets

    return {Path("build", "panels", f"{name}.png"): content for name, content in contact_sheets()}


def film(name: str) -> Files:
    """Return the film of a lesson, recorded with its solution."""
    from images.films import record

    return {
        Path("nao_course", "films", "recordings", f"{name}.json"): (record(name).to_json() + "\n").encode()
    }


def sheet() -> Files:
    """The field on paper, for photographs by phone."""
    from nao_course.lessons.distance.phone import sheet_pdf

    return in_lessons("half_field_A3.pdf", sheet_pdf())


def payoff(lesson: str) -> Files:
    """What a lesson opens with: its own last cell draws it when it is built, so its other files come with it."""
    from nao_course.instructor.authoring.build import build

    return build(COURSE, [lesson]).files


def in_lessons(name: str, content: bytes) -> Files:
    """A file for the solutions and, as `nao-course build` would copy it, for the student copies."""
    return {Path(folder, "images", name): content for folder in ("solutions", "notebooks")}


COURSE = load_course(ROOT)
PICTURES: dict[str, Callable[[], Files]] = {
    "demo": drawn_demo,
    "my_nao": lambda: screen("my_nao"),
    "lesson": lambda: screen("lesson"),
    "effects": effects,
    "own_fields": own_fields,
    "house": house,
    "09_intel": real_building,
    "11_real_walk": real_walk,
    "half_field_A3": sheet,
    **{
        f"{name[:2]}_payoff": lambda name=name: payoff(name)
        for name in COURSE.names()
        if f"images/{name[:2]}_payoff." in COURSE.text(name).read_text(encoding="utf-8")
    },
}
FILMS: dict[str, Callable[[], Files]] = {
    f"{name}_film": lambda name=name: film(name)
    for name in (
        "07_ekf_slam",
        "08_graph_slam",
        "09_pose_graphs",
        "11_slam_on_the_field",
        "12_beyond",
        "12_particles",
    )
}
# Made only if named, because all solutions run for them, or all panels in a browser.
LARGE = {"slides": slides, "panels": panels}
MAKERS = PICTURES | FILMS | LARGE


def make(name: str) -> list[Path]:
    """Make a picture or a film, write what differs from what is there, and return that."""
    changed = [
        (ROOT / path, content)
        for path, content in MAKERS[name]().items()
        if not (ROOT / path).is_file() or (ROOT / path).read_bytes() != content
    ]
    for path, content in changed:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return [path.relative_to(ROOT) for path, _ in changed]


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the pictures that the command line names, all by default; return the exit status."""
    parser = argparse.ArgumentParser(prog="python images/make.py", description="Make the course's pictures.")
    parser.add_argument("name", nargs="*", choices=[*MAKERS, []], metavar="NAME", help=", ".join(MAKERS))
    names = parser.parse_args(arguments).name or list(PICTURES | FILMS)
    os.chdir(ROOT)  # where the solutions are
    console, missing = Console(highlight=False, soft_wrap=True), 0
    for number, name in enumerate(names, start=1):
        console.print(f"{number}/{len(names)} {name} ...")
        start = time.monotonic()
        try:
            said = ", ".join(map(str, make(name))) or "as it was"
        except FileNotFoundError as error:
            said, missing = f"not made: {error}", missing + 1
        console.print(f"    {said} ({time.monotonic() - start:.0f} s)")
    return int(missing > 0)


if __name__ == "__main__":
    sys.exit(main())
