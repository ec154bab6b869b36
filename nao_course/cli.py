"""The command line: what a student says to check and hand in, and an instructor to build and release."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn, track
from rich.table import Table

import nao_course.single_threaded  # noqa: F401 - before NumPy
from nao_course import homework
from nao_course.exercises import lesson_names
from nao_course.exercises.checking import read_public
from nao_course.student import notebooks, progress

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
new = typer.Typer(no_args_is_help=True, help="Begin an exercise or a lesson (instructors).")
# A student's copy: what is not in it is not in the help either.
_STUDENTS = find_spec("nao_course.instructor") is None
app.add_typer(new, name="new", hidden=_STUDENTS)
console = Console()
_SIGNS = {"right": "[green]✔ passes[/]", "not attempted": "○ not attempted", "not checked": "○ not checked"}


@app.callback()
def main() -> None:
    """The course's commands: check, submit and renew are for students."""


@contextmanager
def _plainly() -> Iterator[None]:
    """Say what is wrong in a sentence, without a traceback, and end with status 1."""
    try:
        yield
    except ModuleNotFoundError as error:
        if str(error.name).startswith("nao_course"):
            reason = "it is the instructor's side, which is not in a student's copy"
        else:
            reason = (
                f"it needs {error.name}: run `make test` once, or python -m pip install -e '.[instructor]'"
            )
        _refuse(f"This command is not available here: {reason}.")
    except (ValueError, OSError) as error:
        _refuse(str(error))


def _refuse(text: str) -> None:
    """Say what is wrong as it is, on any terminal, and end."""
    Console(stderr=True).print(text, style="red", markup=False, highlight=False, soft_wrap=True)
    raise typer.Exit(1)


def _say(text: str) -> None:
    console.print(text, markup=False, highlight=False, soft_wrap=True)


# --- students ---


@app.command()
def check(
    lesson_or_file: str = typer.Argument(
        "", metavar="[LESSON]", help="A number, or a notebook; without it, a table of all lessons."
    ),
) -> None:
    """Run the public checks on a lesson's notebook. The status is 0 when all of them pass."""
    if not lesson_or_file:
        _say(repr(progress(_notebooks())))
        return
    with _plainly():
        notebook = _notebook(lesson_or_file)
        lesson = notebook.stem
        public = read_public(lesson)
        found = notebooks.functions(lesson, notebook.parent)
        if found.problem:
            raise ValueError(found.problem)
    reports = {report.name: report for report in found.reports}
    table = Table("exercise", "points", "result", "what the check says", title=lesson)
    for exercise in public.exercises:
        report = reports.get(exercise.name)  # a report that says "wrong" is false
        state = "right" if report is None else report.state
        passed = ("All public checks pass.", *found.remarks.get(exercise.name, ()))
        lines = passed if report is None else report.lines
        sign = _SIGNS.get(state, f"[red]✘ {state}[/]")
        table.add_row(
            f"{exercise.number} {exercise.name}", f"{exercise.points:g}", sign, escape("\n".join(lines))
        )
    for question in public.written:
        sign, said = "○ nothing written", "A person marks it."
        if question.number not in found.unwritten:
            sign = "● written"
        table.add_row(f"{question.number} in your own words", f"{question.points:g}", sign, said)
    console.print(table)
    for each in found.skipped:
        _say(f"code cell {each.cell}, line {each.line}: {each.reason}")
    with _plainly():
        _say(progress(notebook.parent).total(lesson))
    raise typer.Exit(0 if found.complete else 1)


def _notebook(meant: str) -> Path:
    """The notebook that a number, a lesson's name or a path means."""
    there = {path.stem: path for path in sorted(_notebooks().glob(f"{lesson_names.PATTERN}.ipynb"))}
    found = [] if Path(meant).is_file() else lesson_names.meant(meant, there)
    if found:
        return there[found[0]]
    if not Path(meant).is_file():
        raise ValueError(f"there is no file {meant}; lessons here: {', '.join(there) or 'none'}")
    return Path(meant)


@app.command()
def submit(
    folder: Path | None = typer.Argument(
        None, help="Your notebooks; by default notebooks/, else this folder."
    ),
    out: Path = typer.Option(Path(), help="Folder for the zip."),
) -> None:
    """Pack your notebooks into a zip to hand in, with a receipt."""
    with _plainly():
        receipt = homework.submit(folder or _notebooks(), out)
    table = Table("file", "SHA-256", title=f"{receipt.path.name}, {receipt.time}")
    for name, digest in receipt.files.items():
        table.add_row(name, digest[:16])
    console.print(table)
    _say(", ".join(f"{name} {version}" for name, version in receipt.versions.items()))
    _say(f"Hand in {receipt.path} as your course says. Your receipt is in it, too: {receipt.code[:16]}")
    for name in receipt.files:  # last, for it runs the student's code
        if name.endswith(".ipynb"):
            _say(_state_of(Path(name).stem, folder or _notebooks()))


def _state_of(lesson: str, folder: Path) -> str:
    """Say how much of a lesson is done, as far as the public checks can tell."""
    try:
        public, found = read_public(lesson), notebooks.functions(lesson, folder)
    except ValueError as error:
        return f"{lesson}: {error}"
    missing = [f"{report.name} ({report.state})" for report in found.reports]
    missing += [f"{number} (nothing written)" for number in found.unwritten]
    done = f"{len(found)} of {len(public.exercises)} exercises pass their public checks"
    return f"{lesson}: {done}{'; not yet: ' + ', '.join(missing) if missing else ''}."


@app.command()
def renew(root: Path = typer.Argument(Path(), help="Where the release was unpacked.")) -> None:
    """Bring the lessons of a newer release into notebooks/, with your work. `make lab` does it for you."""
    with _plainly():
        for renewal in homework.renew(root):
            _say(str(renewal))


@app.command()
def demo(
    slam: str = typer.Option("both", help="ekf, graph or both."),
    seed: int = typer.Option(1, min=0, help="Of the drive: start, way, errors and room."),
    out: Path = typer.Option(Path("demo"), help="Folder for the figure, the film and the errors."),
    walk: Path | None = typer.Option(
        None,
        metavar="FOLDER",
        help="Recorded pictures of a real walk instead: the folder with amsterdam_2013.",
    ),
) -> None:
    """Let the robot drive and map the field by itself, with your own functions; figure, film and errors in a folder."""
    with _plainly():
        from nao_course.lessons.slam_on_the_field.system.demo import drive, film, report

        if slam not in (*drive.ALGORITHMS, "both"):
            raise ValueError(f"--slam must be ekf, graph or both, got {slam}")
        chosen = list(drive.ALGORITHMS) if slam == "both" else [slam]
        report.make_folder(out)
        solutions = Path("solutions")  # where they are, they drive
        functions = drive.demo_functions(chosen, solutions if solutions.is_dir() else _notebooks())
        sights, pictures, field = drive.route(seed, walk)
        story = drive.run_demo(functions, track(sights, "driving", pictures, console=console), chosen)
        for line in report.in_words(story, field):
            _say(line)
        for path in film.write_all(story, field, out):
            _say(f"wrote {os.path.relpath(path)}")


def _notebooks() -> Path:
    return homework.NOTEBOOKS if homework.NOTEBOOKS.is_dir() else Path()


# --- instructors ---

_PROVE: bool = typer.Option(
    False, "--prove", help="Prove every declaration again, also what is proven and has not changed."
)


@app.command(hidden=_STUDENTS)
def build(
    lessons: list[str] | None = typer.Argument(None, help="Numbers of lessons; by default all."),
    from_notebook: str = typer.Option(
        "", metavar="NN", help="First bring what was edited in solutions/NN_name.ipynb back into the text."
    ),
    execute: bool = typer.Option(
        True,
        "--execute/--no-execute",
        help="Whether solutions are run; without, while you write, it is quick.",
    ),
    prove: bool = _PROVE,
) -> None:
    """Make student copies, executed solutions and the checks' data from the lessons' texts (instructors)."""
    with _plainly(), _progress() as progress:
        from nao_course.instructor.authoring import build, stamps
        from nao_course.instructor.authoring.course import load_course

        course = load_course()
        texts = {}
        wanted = lessons or []
        if from_notebook:
            (name,) = wanted = course.names([from_notebook])
            texts[name] = build.text_from_notebook(course, name)
        else:
            stamps.refuse_to_lose_edits(course, course.names(wanted))
        tasks = {name: progress.add_task(name, total=None, step="") for name in course.names(wanted)}

        def tell(lesson: str, step: str) -> None:
            progress.update(tasks[lesson], step=step, total=1, completed=step == "done")

        changes = build.build(course, wanted, texts=texts, execute=execute, prove=prove, tell=tell).write()
    for path in changes:
        _say(f"{'wrote' if path.exists() else 'took away'} {path.as_posix()}")
    if not changes:
        _say("Nothing has changed.")


def _progress() -> Progress:
    return Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        TextColumn("{task.fields[step]}"),
        TimeElapsedColumn(),
        console=console,
        transient=True,
    )


@app.command(hidden=_STUDENTS)
def release(out: Path = typer.Option(..., help="Folder for the zip."), prove: bool = _PROVE) -> None:
    """Make the zip that students get; refused if any code of a solution is in it (instructors)."""
    with _plainly(), _progress() as progress:
        from nao_course.instructor.authoring.course import load_course
        from nao_course.instructor.authoring.release import make_release

        doing = progress.add_task("release", total=None, step="")
        path = make_release(
            load_course(),
            out,
            lambda lesson, step: progress.update(doing, description=lesson, step=step),
            prove=prove,
        )
    _say(f"{path}: {path.stat().st_size / 1e6:.1f} MB")


@app.command(hidden=_STUDENTS)
def mutate(lesson: str, jobs: int = typer.Option(os.cpu_count() or 2, help="Processes at a time.")) -> None:
    """Change a lesson's solutions a little, many times, and list the changes that no test notices (instructors)."""
    with _plainly():
        from nao_course.instructor.authoring.mutation import main as run_mutants

        raise typer.Exit(run_mutants(lesson, jobs))


# --- grading ---


@app.command(hidden=_STUDENTS)
def grade(
    submissions: Path = typer.Argument(
        ..., help="A folder of submissions, or the zip that Moodle or Canvas gives."
    ),
    out: Path = typer.Option(..., metavar="GRADES", help="Folder for the journal and the feedback."),
    lesson: list[str] = typer.Option([], help="Number of a lesson; by default all that were handed in."),
    jobs: int = typer.Option(os.cpu_count() or 2, min=1, help="Submissions at a time."),
    require_sandbox: str = typer.Option("", metavar="LEVEL", help="Refuse to run below this level."),
) -> None:
    """Grade what is missing or has changed (instructors). The status is 0 when all have a score or a reason."""
    with _plainly():
        from nao_course.instructor import commands

        commands.grade_folder(console, submissions, out, lesson, jobs, require_sandbox)


@app.command(hidden=_STUDENTS)
def regrade(
    grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal."),
    student: str = typer.Option(..., help="Whose submission."),
    lesson: str = typer.Option("", help="Number of the lesson, where the student handed in several."),
    points: str = typer.Option("", "--set", metavar="EXERCISE=POINTS", help="Points that count from now on."),
    reason: str = typer.Option("", help="Why these points; needed with --set."),
) -> None:
    """Grade a student's submission again, or give points by hand, with a reason (instructors)."""
    with _plainly():
        from nao_course.instructor import commands

        commands.regrade_student(console, grades, student, lesson, points, reason)


@app.command(hidden=_STUDENTS)
def export(
    grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal."),
    format_: str = typer.Option(..., "--format", help="csv, gradescope, moodle or canvas."),
    lesson: str = typer.Option("", help="Number of a lesson; by default all."),
    sheet: Path = typer.Option(None, help="Moodle's or Canvas's own sheet, to be filled in."),
    column: str = typer.Option("", help="Column of that sheet for the points, or how it begins."),
) -> None:
    """Write grades for another system into GRADES/exports (instructors)."""
    with _plainly():
        from nao_course.instructor import commands

        for line in commands.export(grades, format_, lesson, sheet, column):
            _say(line)


@app.command(hidden=_STUDENTS)
def marks(
    grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal."),
    file: Path | None = typer.Argument(
        None, help="A sheet that is filled in; without it, sheets are written."
    ),
) -> None:
    """Write sheets to mark written answers with, or read one back (instructors)."""
    with _plainly():
        from nao_course.instructor import commands

        for line in commands.marks(grades, file):
            _say(line)


@app.command(hidden=_STUDENTS)
def report(grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal.")) -> None:
    """Write a page about the class: scores, exercises, what was refused (instructors)."""
    with _plainly():
        from nao_course.instructor import commands

        for line in commands.report(grades):
            _say(line)


@new.command("exercise")
def new_exercise(
    lesson: str,
    name: str,
    a_class: bool = typer.Option(False, "--class", help="The student writes a class."),
) -> None:
    """Add an exercise to a lesson: a declaration and its cells, with TODO where work is needed."""
    with _plainly():
        from nao_course.instructor.authoring.course import load_course
        from nao_course.instructor.scaffolding import scaffold

        for path in scaffold.add_exercise(load_course(), lesson, name, a_class=a_class):
            _say(f"wrote {os.path.relpath(path)}")


@new.command("lesson")
def new_lesson(number: str, name: str) -> None:
    """Begin a lesson: a text and a declaration, with TODO where work is needed."""
    with _plainly():
        from nao_course.instructor.authoring.course import load_course
        from nao_course.instructor.scaffolding import scaffold

        for path in scaffold.add_lesson(load_course(), number, name):
            _say(f"wrote {os.path.relpath(path)}")


if __name__ == "__main__":
    app()
