"""Gradescope's autograder: a zip that runs this grader there, and what runs in it.

Paths and file names follow Gradescope's autograder documentation: the unpacked zip is in /autograder/source,
a submission in /autograder/submission, and the result in /autograder/results/results.json.
"""

import os
import shutil
import sys
import tempfile
import tomllib
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console

from nao_course.homework import zipped
from nao_course.instructor.authoring.course import Course, LessonError
from nao_course.instructor.authoring.course_file import NAME
from nao_course.instructor.authoring.release import LIBRARY_KINDS, library_files
from nao_course.instructor.autograding.assignment import lessons_used
from nao_course.instructor.autograding.secret import keyed, load_secret
from nao_course.instructor.autograding.session import open_session
from nao_course.instructor.collecting.submissions import gather, of_lessons, with_earlier
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.scores import score
from nao_course.instructor.reports.exports import as_text, gradescope_results
from nao_course.instructor.reports.html import visible, write_whole
from nao_course.instructor.sandbox.layers import probe

ROOT = Path("/autograder")
ROOT_VARIABLE = "NAO_COURSE_AUTOGRADER"  # another root, for trying it out elsewhere
LOCK = "requirements-dev.lock"
_INSTRUCTOR = "nao_course/instructor"  # a distribution of its own
_AS_THEY_ARE = (NAME, "pyproject.toml", f"{_INSTRUCTOR}/pyproject.toml", "LICENSE", LOCK)
# Layers; each keeps the solution from being read
_CLOSING = {"landlock", "mount namespace", "unprivileged user"}
_SETUP = f"""#!/usr/bin/env bash
# Runs once, as root, when Gradescope builds the image: a Python that is new enough, and the libraries.
set -euo pipefail
root="${{{ROOT_VARIABLE}:-{ROOT}}}"

find_python() {{
    for each in python3.13 python3.12 python3.11 python3; do
        if "$each" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' 2> /dev/null; then
            echo "$each"
            return
        fi
    done
    return 1
}}

if ! python="$(find_python)"; then
    apt-get update
    apt-get install -y python3-venv
    find_python > /dev/null || apt-get install -y python3.11 python3.11-venv
    python="$(find_python)"
fi
"$python" -m venv "$root/venv"
"$root/venv/bin/python" -m pip install --require-hashes -r "$root/source/{LOCK}"
"$root/venv/bin/python" -m pip install --no-deps --no-build-isolation "$root/source" "$root/source/{_INSTRUCTOR}"
"""
_RUN = f"""#!/usr/bin/env bash
# Runs at each submission. What a student's code may not read is closed first.
set -euo pipefail
root="${{{ROOT_VARIABLE}:-{ROOT}}}"
chmod -R go-rwx "$root/source/solutions" "$root/source/secret"
mkdir -p "$root/results"
chmod go-rwx "$root/results"
export NAO_COURSE_SECRET="$root/source/secret"
cd "$root/source"
exec "${{NAO_COURSE_PYTHON:-$root/venv/bin/python}}" -P -m nao_course.instructor.commands.gradescope LESSON
"""


# Scripts as such; the secret for its owner
_MODES = {"setup.sh": 0o755, "run_autograder": 0o755, "secret": 0o600}


def write_autograder(course: Course, lesson: str, secret: bytes, folder: Path) -> Path:
    """Write the zip to upload as a lesson's autograder. It holds the solution: it is for Gradescope only.

    It is autograder_NN_name.zip, the same bytes for the same course, which is built, and secret. The zip gets a secret
    derived from the instructor's, so its hidden cases are different. Raise a LessonError if there is no such lesson, or
    it is not built.
    """
    (name,) = course.names([lesson])
    return write_whole(folder / f"autograder_{name}.zip", zipped(contents(course, name, secret), _MODES))


def contents(course: Course, lesson: str, secret: bytes) -> dict[str, bytes]:
    """Gather the files of a lesson's autograder by their path in the zip."""
    wanted = [course.root / name for name in _AS_THEY_ARE]
    for each in (*lessons_used(course, lesson), lesson):
        wanted += [course.solutions / f"{each}{kind}" for kind in (".md", ".ipynb")]
        wanted.append(course.root / "notebooks" / f"{each}.ipynb")
        declaration = course.solutions / "exercises" / f"{each}.py"
        wanted += [declaration] if declaration.exists() else []
    missing = [path.relative_to(course.root).as_posix() for path in wanted if not path.is_file()]
    if missing:
        raise LessonError(f"there is no {', '.join(missing)}: run `nao-course build` first")
    wanted += library_files(course.root, LIBRARY_KINDS | {".bin"})
    files = {path.relative_to(course.root).as_posix(): path.read_bytes() for path in wanted}
    files[NAME] = without_extensions(files[NAME].decode()).encode()
    files["setup.sh"] = _SETUP.encode()
    files["run_autograder"] = _RUN.replace("LESSON", lesson).encode()
    files["secret"] = keyed(secret, "gradescope", lesson).encode()
    return files


def without_extensions(course_file: str) -> str:
    r"""Return the text of a course.toml without its tables of extensions, which name students.

    Raise a LessonError if the extensions are written in a way that this cannot remove.

    >>> without_extensions('title = "x"\n[extensions."Ada"]\n01 = 2026-11-27\n[points]\n')
    'title = "x"\n[points]\n'
    """
    kept, inside = list[str](), False
    for line in course_file.splitlines(keepends=True):
        if line.lstrip().startswith("["):
            inside = line.lstrip(" \t[").startswith("extensions")
        if not inside:
            kept.append(line)
    text = "".join(kept)
    if "extensions" in tomllib.loads(text):
        raise LessonError(
            f"{NAME} contains extensions, which name students, and they would go to Gradescope. Write each as "
            'a table [extensions."NAME"], so that they can be left out'
        )
    return text


# --- what runs there ---


def grade_submission(root: Path, course: Course, lesson: str) -> Path:
    """Grade what is in ROOT/submission and write ROOT/results/results.json; ROOT is /autograder.

    The course is the unpacked zip. If the grader itself fails, there are no results, so that Gradescope informs the
    instructor. Raise a RuntimeError if it failed, or a submission could read the solution here.
    """
    path = root / "results" / "results.json"
    path.unlink(missing_ok=True)
    if not probe().on & _CLOSING:
        raise RuntimeError(
            "on this machine a submission could read the solution beside it, so nothing was graded. Use a "
            f"machine with one of {', '.join(sorted(_CLOSING))}."
        )
    with tempfile.TemporaryDirectory(prefix="nao_course_") as scratch:
        return write_whole(path, as_text(_results(root / "submission", Path(scratch), course, lesson)))


def _results(handed_in: Path, scratch: Path, course: Course, lesson: str) -> dict[str, Any]:
    """Grade the submission as a class of one student."""
    shutil.copytree(handed_in, scratch / "class" / "submission", symlinks=True)
    (scratch / "unpacked").mkdir()
    given = partial(gather, scratch / "class", one_student=True)
    found = given(scratch / "unpacked", [lesson])
    used = lessons_used(course, lesson)
    (scratch / "earlier").mkdir()
    before = given(scratch / "earlier", course.names(), used).submissions if used else ()
    waiting = with_earlier(
        of_lessons(found, [lesson]), {(each.student, each.lesson): each for each in before}, lambda _: used
    )
    if not waiting:
        others = "".join(f"\n{each.removeprefix('submission/')}" for each in found.unknown)
        return {
            "score": 0.0,
            "output": visible(f"There is no {lesson}.ipynb among the files that were handed in.{others}"),
            "output_format": "text",
        }
    with (
        Journal(scratch / "grades") as journal,
        open_session(
            course, [lesson], load_secret(), say=Console(markup=False, highlight=False, soft_wrap=True).print
        ) as session,
    ):
        summary = session.grade(waiting, journal, scratch / "feedback")
        if summary.failed:
            raise RuntimeError("\n".join(summary.failed))
        (result,) = journal.results()
    return gradescope_results(score(result))


def main() -> None:
    """Grade a submission where Gradescope has put it; the argument is the lesson."""
    from nao_course.instructor.authoring.course import load_course

    root = Path(os.environ.get(ROOT_VARIABLE) or ROOT)
    grade_submission(root, load_course(root / "source"), sys.argv[1])


if __name__ == "__main__":
    main()
