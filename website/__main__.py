"""``python -m website student`` builds the students' pages, ``python -m website instructor`` the instructors'."""

import argparse
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from nao_course.exercises import lesson_names
from nao_course.instructor.authoring.course import Course, LessonError, load_course
from nao_course.instructor.authoring.stamps import refuse_what_is_not_built
from website import ROOT
from website.checks import offences
from website.editions import BESIDE, EDITIONS, gather

BUILD = ROOT / "build" / "website"


def build(edition: str, folder: Path, lessons: Sequence[str] = ()) -> Path:
    """Make the pages of an edition, ``student`` or ``instructor``, and return the folder of index.html.

    Sources and pages get a folder each in `folder`; by default, the released lessons are shown. A lesson that is not
    built raises a LessonError, and a failure or warning of Sphinx a CalledProcessError.
    """
    course = load_course(ROOT)
    names = course.names(lessons or course.chosen)
    _refuse_what_has_no_pages(course, names)
    sources, pages = folder / "sources", folder / "pages"
    shutil.rmtree(folder, ignore_errors=True)
    gather(EDITIONS[edition], course, names, sources)
    options = (
        "--fail-on-warning",
        "--keep-going",
        "--quiet",
        "--fresh-env",
        "--conf-dir",
        str(ROOT / "website"),
    )
    command = [
        sys.executable,
        "-m",
        "sphinx",
        *options,
        *("-D", f"html_extra_path={sources / BESIDE}"),
        *("-d", str(folder / "doctrees")),
        str(sources),
        str(pages),
    ]
    subprocess.run(command, cwd=ROOT, check=True, env={**os.environ, "MPLBACKEND": "agg"})
    return pages


def _refuse_what_has_no_pages(course: Course, names: Sequence[str]) -> None:
    """Refuse lessons whose notebooks are missing or are not what their texts say; the message names the command."""
    refuse_what_is_not_built(course, names, executed=True)
    missing = [name for name in names if not (course.root / "notebooks" / f"{name}.ipynb").is_file()]
    if missing:
        raise LessonError(
            "\n".join(
                f"there is no notebooks/{name}.ipynb: run `nao-course build {lesson_names.number_of(name)}`"
                for name in missing
            )
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Build what the command line names and look through it; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m website", description="Build the course's pages.")
    parser.add_argument("edition", choices=list(EDITIONS))
    parser.add_argument("lessons", nargs="*", help="numbers or names; all that are released by default")
    chosen = parser.parse_args(arguments)
    try:
        pages = build(chosen.edition, BUILD / chosen.edition, chosen.lessons)
    except subprocess.CalledProcessError as error:
        return error.returncode
    except ValueError as error:  # a lesson that is not built, or whose first cell lacks a fact
        print(error, file=sys.stderr)
        return 1
    wrong = offences(pages)
    print(*wrong, f"The {chosen.edition} pages: {(pages / 'index.html').relative_to(ROOT)}", sep="\n")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
