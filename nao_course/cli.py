"""The command line: check and submit for students, build, release and grade for instructors."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from threading import Event
from typing import Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn, track
from rich.table import Table

import nao_course._internal.single_threaded
import nao_course.lab
from nao_course._internal.student_folders import NOTEBOOKS, RELEASE
from nao_course._internal.text_encodings import write_any_character

# A command imports what only it needs, so that the list of commands appears at once.


class _Commands(typer.Typer):
    """The commands, whose output reaches a pipe, file or console of any encoding."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        write_any_character(sys.stdout, sys.stderr)
        return super().__call__(*args, **kwargs)


app = _Commands(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
new = typer.Typer(no_args_is_help=True, help="Create an exercise or a lesson (instructors).")
# More than processors, because a submission waits for the grader a part of its time
DEFAULT_JOBS = (os.cpu_count() or 2) + 2
# A student's copy lacks the instructor's package, so its help omits the instructor's commands.
_STUDENTS = find_spec("nao_course.instructor") is None
app.add_typer(new, name="new", hidden=_STUDENTS)
robot = typer.Typer(no_args_is_help=True, help="Practise with an emulated NAO before you drive a real one.")
app.add_typer(robot, name="robot")
console = Console()
_SIGNS = {"right": "[green]✔ passes[/]", "not attempted": "○ not attempted", "not checked": "○ not checked"}


@app.callback()
def main() -> None:
    """Run a command of the course; check, submit and renew are for students."""


@contextmanager
def _errors_in_words() -> Iterator[None]:
    """Print an error as a sentence without a traceback, and exit with status 1."""
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name == "jupyterlab":
            _refuse(
                "This command needs JupyterLab, which is not installed. Install it with "
                "python -m pip install 'nao-course[lab]'."
            )
        if error.name in ("dask", "distributed"):
            _refuse(
                "Grading with several workers needs Dask, which is not installed. Install it with "
                "python -m pip install 'nao-course[scale]'."
            )
        _refuse(
            f"This command is for instructors and needs {error.name}, which is not installed. Install it with "
            "python -m pip install 'nao-course[instructor]' or, in the course's repository, with make test."
        )
    except (ValueError, OSError) as error:
        _refuse(str(error))


def _refuse(text: str) -> None:
    """Print an error without markup, and exit with status 1."""
    Console(stderr=True).print(text, style="red", markup=False, highlight=False, soft_wrap=True)
    raise typer.Exit(1)


def _say(text: str) -> None:
    console.print(text, markup=False, highlight=False, soft_wrap=True)


# --- students ---


@app.command()
def check(
    lesson_or_file: str = typer.Argument(
        "", metavar="[LESSON]", help="Number or notebook of a lesson; without it, a table of all lessons."
    ),
) -> None:
    """Run the public checks on a lesson's notebook. The status is 0 when all of them pass."""
    from nao_course.exercises.answered import notebooks_in, several_copies
    from nao_course.exercises.checking import read_public
    from nao_course.student import notebooks, progress

    if not lesson_or_file:
        _say(repr(progress(_notebooks())))
        return
    with _errors_in_words():
        lesson, notebook = _notebook(lesson_or_file)
        public = read_public(lesson)
        found = notebooks.functions(lesson, notebook.parent, notebook=notebook)
        if found.problem:
            raise ValueError(found.problem)
    reports = {report.name: report for report in found.reports}
    table = Table("exercise", "points", "result", "message", title=lesson)
    for exercise in public.exercises:
        report = reports.get(exercise.name)  # a report is false unless the exercise passes
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
    with _errors_in_words():
        for line in several_copies(lesson, notebooks_in(notebook.parent, [lesson]).get(lesson, [])):
            _say(line)
        _say(progress(notebook.parent).total(lesson))
    raise typer.Exit(0 if found.complete else 1)


def _notebook(meant: str) -> tuple[str, Path]:
    """Return the lesson and the notebook that a number, a lesson's name or the path of a notebook refers to."""
    from nao_course.exercises import lesson_names
    from nao_course.exercises.answered import lesson_of_notebook, notebooks_in
    from nao_course.exercises.checking import lessons

    path = Path(meant)
    if path.is_file():
        return lesson_of_notebook(path.name, lessons()) or path.stem, path
    there = notebooks_in(_notebooks(), lessons())
    if found := lesson_names.meant(meant, there):
        return found[0], there[found[0]][0]
    raise ValueError(f"there is no file {meant}; lessons here: {', '.join(there) or 'none'}")


@app.command()
def submit(
    folder: Path | None = typer.Argument(
        None, help="Your notebooks; by default notebooks/, else this folder."
    ),
    out: Path = typer.Option(Path(), help="Folder for the zip."),
) -> None:
    """Pack your notebooks into a zip to hand in, with a receipt."""
    from nao_course import homework
    from nao_course.exercises.answered import notebooks_in, several_copies
    from nao_course.exercises.checking import lessons

    with _errors_in_words():
        where = folder or _notebooks()
        receipt = homework.submit(where, out)
    table = Table("file", "SHA-256", title=f"{receipt.path.name}, {receipt.time}")
    for name, digest in receipt.files.items():
        table.add_row(name, digest[:16])
    console.print(table)
    _say(", ".join(f"{name} {version}" for name, version in receipt.versions.items()))
    _say(f"Now hand in {receipt.path}. It contains your receipt: {receipt.code[:16]}")
    there = notebooks_in(where, lessons())
    for line in [line for lesson, paths in there.items() for line in several_copies(lesson, paths)]:
        _say(line)
    for lesson in there:  # last, because it runs the student's code
        _say(_state_of(lesson, where))


def _state_of(lesson: str, folder: Path) -> str:
    """Return how much of a lesson is complete, according to the public checks."""
    from nao_course.exercises.checking import read_public
    from nao_course.student import notebooks

    try:
        public, found = read_public(lesson), notebooks.functions(lesson, folder)
    except ValueError as error:
        return f"{lesson}: {error}"
    missing = [f"{report.name} ({report.state})" for report in found.reports]
    missing += [f"{number} (nothing written)" for number in found.unwritten]
    done = f"{len(found)} of {len(public.exercises)} exercises pass their public checks"
    return f"{lesson}: {done}{'; not yet: ' + ', '.join(missing) if missing else ''}."


@app.command()
def renew(root: Path = typer.Argument(Path(), help="Folder in which the release was unpacked.")) -> None:
    """Update notebooks/ to a newer release and keep your work; `lab` does this automatically."""
    from nao_course import homework

    with _errors_in_words():
        for line in [*map(str, homework.renew(root))] or ["Your notebooks are up to date."]:
            _say(line)


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def lab(
    context: typer.Context,
    release: Path = typer.Option(
        RELEASE, envvar="NAO_COURSE_RELEASE", help="Folder of the release, if it is not here."
    ),
) -> None:
    """Open the lessons in JupyterLab; further arguments go to JupyterLab."""
    with _errors_in_words():
        if release.is_dir():
            from nao_course import homework

            for renewal in homework.renew(Path(), release):
                _say(str(renewal))
        command = nao_course.lab.command(_notebooks(), context.args)
    environment = nao_course.lab.environment()
    if nao_course.lab.on_a_hub():  # its server takes the place of this process, and of its memory
        os.execve(command[0], command, environment)
    raise typer.Exit(subprocess.run(command, env=environment, check=False).returncode)


@app.command()
def demo(
    slam: str = typer.Option("both", help="ekf, graph or both."),
    joint: bool = typer.Option(
        False, "--joint", help="Let your EKF use lines and the centre circle too, with several hypotheses."
    ),
    kidnap: bool = typer.Option(
        False, "--kidnap", help="Carry the simulated robot away half way; your EKF finds its pose again."
    ),
    seed: int = typer.Option(1, min=0, help="Seed of the drive: start, route, errors and room."),
    out: Path = typer.Option(Path("demo"), help="Folder for the figure, the film and the errors."),
    walk: Path | None = typer.Option(
        None,
        metavar="FOLDER",
        help="Use recorded pictures of a real walk: the folder that contains amsterdam_2013.",
    ),
    recording: Path | None = typer.Option(
        None,
        metavar="FOLDER",
        help="Use a drive that RealNao has recorded, from the halfway line toward the goal.",
    ),
    field: Path | None = typer.Option(
        None,
        metavar="FILE",
        help="TOML file of the field; or 2013, 2025 or lab. By default half the field of 2012.",
    ),
) -> None:
    """Let the robot map the field with your own functions; write a figure, a film and the errors into a folder."""
    with _errors_in_words():
        from nao_course.field_slam.demo import drive, film, report

        if slam not in (*drive.ALGORITHMS, "both"):
            raise ValueError(f"--slam must be ekf, graph or both, got {slam}")
        if joint and slam == "graph":
            raise ValueError("--joint works with the EKF: use it with --slam ekf or both")
        if kidnap and slam == "graph":
            raise ValueError("--kidnap works with the EKF: use it with --slam ekf or both")
        if kidnap and joint:
            raise ValueError(
                "--kidnap already lets the EKF use lines and the centre circle: leave out --joint"
            )
        chosen = list(drive.ALGORITHMS) if slam == "both" else [slam]
        report.make_folder(out)
        solutions = Path("solutions")  # in the course's repository, the solutions drive
        functions = drive.demo_functions(chosen, solutions if solutions.is_dir() else _notebooks())
        frames, pictures, ground = drive.route(seed, walk, field, recording, kidnap)
        for line in report.field_in_words(ground):
            _say(line)
        driving = track(frames, "driving", pictures, console=console)
        (x0, x1), (y0, y1) = ground.x_range, ground.y_range
        area = ((x0, y0), (x1, y1)) if kidnap else None
        story = drive.run_demo(functions, driving, chosen, joint, ground.dimensions, area)
        for line in report.in_words(story, ground):
            _say(line)
        if recording is not None:
            _say(report.keep_calibration(story, out / "cameras.toml"))
        for path in film.write_all(story, ground, out):
            _say(f"wrote {os.path.relpath(path)}")


@robot.command()
def serve(
    field: Path | None = typer.Option(
        None,
        metavar="FILE",
        help="TOML file of the field; or 2013, 2025 or lab. By default half the field of 2012.",
    ),
    port: int = typer.Option(9559, min=1, max=65535, help="Port of this computer."),
    host: str = typer.Option("127.0.0.1", help="Address to listen at; 0.0.0.0 for the whole network."),
    seed: int = typer.Option(1, min=0, help="Seed of the robot's errors."),
) -> None:
    """Make this computer a NAO for your notebooks: a simulated robot answers behind the real protocol."""
    with _errors_in_words():
        from nao_course.robot.emulated import EmulatedNao, served
        from nao_course.sim import Field, SimulatedNao

        nao = SimulatedNao(Field() if field is None else Field.from_toml(field), rng=seed)
        emulated = EmulatedNao(nao)
        with served(emulated, port, host) as address, suppress(KeyboardInterrupt):
            _say(f'a NAO V4 listens at {address}: RealNao("{address}", model="V4")')
            _say(f"Press Ctrl-C to end it. To practise, {emulated.practise('')}.")
            for line in sys.stdin:
                _say(emulated.practise(line))
            Event().wait()  # without a terminal
        os._exit(0)  # all is closed, and one end of Python in ten is an abort by libqi's own threads


def _notebooks() -> Path:
    """Return the folder of a release in which a student works, or the current one."""
    return NOTEBOOKS if NOTEBOOKS.is_dir() else Path()


# --- instructors ---

_PROVE: bool = typer.Option(False, "--prove", help="Prove every declaration again, including unchanged ones.")


@app.command(hidden=_STUDENTS)
def build(
    lessons: list[str] | None = typer.Argument(
        None, help="Numbers of lessons; by default the lessons of course.toml."
    ),
    from_notebook: str = typer.Option(
        "", metavar="NN", help="First copy the changes in solutions/NN_name.ipynb into the text."
    ),
    execute: bool = typer.Option(
        True,
        "--execute/--no-execute",
        help="Whether to run the solutions; --no-execute is faster while you write.",
    ),
    solutions: bool = typer.Option(
        True,
        "--solutions/--no-solutions",
        help="Whether to write the solution notebooks; --no-solutions only proves and writes student copies.",
    ),
    prove: bool = _PROVE,
) -> None:
    """Build student copies, executed solutions and check data from the lessons' texts (instructors)."""
    with _errors_in_words(), _progress() as progress:
        from nao_course.instructor.authoring import build, stamps
        from nao_course.instructor.authoring.course import load_course

        course = load_course()
        texts = {}
        wanted = lessons or []
        if from_notebook:
            (name,) = wanted = course.names([from_notebook])
            texts[name] = build.text_from_notebook(course, name)
        else:
            stamps.refuse_to_lose_edits(course, course.names(wanted or course.chosen))
        names = course.names(wanted or course.chosen)
        tasks = {name: progress.add_task(name, total=None, step="") for name in names}

        def tell(lesson: str, step: str) -> None:
            progress.update(tasks[lesson], step=step, total=1, completed=step == "done")

        built = build.build(
            course, wanted, texts=texts, execute=execute, solutions=solutions, prove=prove, tell=tell
        )
        changes = built.write()
    for warning in built.warnings:
        _say(f"warning: {warning}")
    for path in changes:
        _say(f"{'wrote' if path.exists() else 'deleted'} {path.as_posix()}")
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
def release(
    out: Path = typer.Option(..., help="Folder for the archive."),
    students: Path | None = typer.Option(
        None,
        help="Folder of grades, or file with a student's name in each line; each of them gets an archive with personal "
        "data.",
    ),
    prove: bool = _PROVE,
) -> None:
    """Make the students' zip archive; fail if it contains code of a solution (instructors)."""
    with _errors_in_words(), _progress() as progress:
        from nao_course.instructor.authoring.course import load_course
        from nao_course.instructor.authoring.release import make_release, read_students

        names = read_students(students) if students else []
        doing = progress.add_task("release", total=None, step="")
        path = make_release(
            load_course(),
            out,
            lambda lesson, step: progress.update(doing, description=lesson, step=step),
            prove=prove,
            students=names,
        )
    _say(f"{path}: {path.stat().st_size / 1e6:.1f} MB")
    if names:
        _say(f"{path.parent / 'students'}: {len(names)} archives, each with the name of its student")


@app.command(hidden=_STUDENTS)
def mutate(lesson: str, jobs: int = typer.Option(os.cpu_count() or 2, help="Processes at a time.")) -> None:
    """Make many small changes to a lesson's solutions, and list the changes that no test detects (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.authoring.mutation import main as run_mutants

        raise typer.Exit(run_mutants(lesson, jobs))


# --- grading ---

_BY: str = typer.Option("", metavar="NAME", help="Who decides; by default your login.")


@app.command(hidden=_STUDENTS)
def grade(
    submissions: Path = typer.Argument(
        ..., help="Folder of submissions, or the zip archive that Moodle or Canvas exports."
    ),
    out: Path = typer.Option(..., metavar="GRADES", help="Folder for the journal and the feedback."),
    lesson: list[str] = typer.Option(
        [], help="Number of a lesson; by default all lessons that were handed in."
    ),
    jobs: int = typer.Option(DEFAULT_JOBS, min=1, help="Submissions at a time."),
    require_sandbox: str = typer.Option("", metavar="LEVEL", help="Refuse to run below this level."),
    scheduler: str = typer.Option("", metavar="ADDRESS", help="Grade with the workers of a Dask scheduler."),
    workers: int = typer.Option(0, min=0, help="Grade with this many Dask workers on this machine."),
    sheet: Path | None = typer.Option(
        None, help="The platform's sheet of the class, with students and times, as for students."
    ),
    dry_run: bool = typer.Option(
        False,
        "--dry-run",
        help="Print what is recognised: students, attempts, times; grade and write nothing.",
    ),
) -> None:
    """Grade new and changed submissions (instructors). The status is 0 if each has a score or a reason."""
    with _errors_in_words():
        from nao_course.instructor.autograding.session import Machines
        from nao_course.instructor.commands import grading

        if scheduler and workers:
            raise ValueError("Give --scheduler or --workers, not both: a scheduler has its own workers.")
        machines = Machines(jobs, require_sandbox, scheduler, workers)
        grading.grade_folder(console, submissions, out, lesson, machines, sheet=sheet, dry_run=dry_run)


@app.command(hidden=_STUDENTS)
def students(
    grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal."),
    sheet: Path | None = typer.Option(
        None, help="Moodle's grading worksheet, Canvas's gradebook, or a CSV file of the class."
    ),
    lesson: str = typer.Option("", help="Number of the lesson whose times and Moodle numbers the sheet has."),
    same: tuple[str, str] | None = typer.Option(
        None, metavar="NAME STUDENT", help="A name in a download, or a student, who is this student."
    ),
    new: str = typer.Option("", metavar="NAME", help="A name in a download that is a new student's."),
    rename: tuple[str, str] | None = typer.Option(
        None, metavar="STUDENT NAME", help="Another name for a student, also in the gradebook."
    ),
    forget: str = typer.Option("", metavar="STUDENT", help="Delete a student's data, and list what remains."),
) -> None:
    """List the students of the class, and say who is who (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.commands import students

        for line in students.students(grades, sheet, lesson, same, rename, new, forget):
            _say(line)


@app.command(hidden=_STUDENTS)
def regrade(
    grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal."),
    student: str = typer.Option(..., help="Student whose submission is graded again."),
    lesson: str = typer.Option("", help="Number of the lesson, if the student handed in several."),
    points: str = typer.Option(
        "", "--set", metavar="EXERCISE=POINTS", help="New points of an exercise or a written answer."
    ),
    unset: str = typer.Option("", metavar="EXERCISE", help="Take back the points that people gave."),
    keep: str = typer.Option("", metavar="EXERCISE", help="Answer a request without a change of points."),
    reason: str = typer.Option("", help="Reason, which the student reads; required with --set and --keep."),
    by: str = _BY,
) -> None:
    """Grade a student's submission again, or set points by hand with a reason (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.commands import decisions, grading

        if sum(map(bool, (points, unset, keep))) > 1:
            raise ValueError("give one of --set, --unset and --keep at a time")
        if points:
            lines = decisions.set_points(grades, student, lesson, points, reason, by)
        elif unset:
            lines = decisions.unset_points(grades, student, lesson, unset, by)
        elif keep:
            lines = decisions.keep_points(grades, student, keep, reason, by)
        else:
            grading.regrade_student(console, grades, student, lesson)
            return
        for line in lines:
            _say(line)


@app.command(hidden=_STUDENTS)
def undo(grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal.")) -> None:
    """Take back the last marks, comments, points, requests or change of students (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.commands import decisions

        for line in decisions.undo(grades):
            _say(line)


@app.command(hidden=_STUDENTS)
def history(
    grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal."),
    student: str = typer.Option(..., help="Any name of the student."),
) -> None:
    """Write a page with everything that was graded and decided for a student (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.commands import decisions

        for line in decisions.history(grades, student):
            _say(line)


@app.command(hidden=_STUDENTS)
def requests(
    grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal."),
    submissions: Path | None = typer.Argument(
        None, help="Folder or zip with students' requests; without it, open requests are listed."
    ),
) -> None:
    """List the students' open requests to look at an exercise again (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.commands import classes

        for line in classes.requests(grades, submissions):
            _say(line)


@app.command(hidden=_STUDENTS)
def export(
    grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal."),
    format_: str = typer.Option(
        ..., "--format", help="csv, json, or a platform's name; another word lists all."
    ),
    lesson: str = typer.Option("", help="Number of a lesson; by default all."),
    sheet: Path = typer.Option(None, help="The platform's own sheet of grades, to be filled in."),
    column: str = typer.Option("", help="Column of that sheet for the points, or the beginning of its name."),
    scale: bool = typer.Option(False, "--scale", help="Scale points to the maximum in that sheet."),
) -> None:
    """Write grades for another system into GRADES/exports (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.commands import exporting

        for line in exporting.export(grades, format_, lesson, sheet, column, scale=scale):
            _say(line)


@app.command(hidden=_STUDENTS)
def marks(
    grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal."),
    file: Path | None = typer.Argument(
        None, help="Sheet with marks or comments to read; without it, sheets are written."
    ),
    comments: bool = typer.Option(
        False, "--comments", help="Write sheets and pages to comment on wrong answers, one kind at a time."
    ),
    lesson: str = typer.Option("", help="Number of the lesson to write sheets for; by default all."),
    anonymous: bool = typer.Option(False, "--anonymous", help="Write sheets with codes instead of names."),
    worlds: Path | None = typer.Option(
        None,
        help="Names in students' copies, if they differ: a CSV file with columns student and world, or the platform's "
        "sheet that release was given.",
    ),
    by: str = _BY,
    split: int = typer.Option(1, min=1, help="Divide each question's answers among this many markers."),
    double: bool = typer.Option(
        False,
        "--double",
        help="Write another sheet for a second marker; where two marks differ, it is listed.",
    ),
) -> None:
    """Write sheets for marking the written answers, or read a completed sheet (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.commands import marking
        from nao_course.instructor.reports.comment_sheets import is_comment_sheet

        if file and is_comment_sheet(file):
            lines = marking.read_comments(grades, file, by)
        elif comments and not file:
            lines = marking.write_comment_sheets(grades, anonymous=anonymous, lesson=lesson)
        else:
            lines = marking.marks(
                grades,
                file,
                anonymous=anonymous,
                worlds=worlds,
                by=by,
                parts=split,
                double=double,
                lesson=lesson,
            )
        for line in lines:
            _say(line)


@app.command(hidden=_STUDENTS)
def oral(
    grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal."),
    lesson: str = typer.Option("", help="Number of the lesson, if several were graded."),
    student: str = typer.Option("", help="Any name of a student; by default all."),
) -> None:
    """Write a page with questions for five minutes about each student's own submission (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.commands import marking

        for line in marking.write_oral_check(grades, lesson, student):
            _say(line)


@app.command(hidden=_STUDENTS)
def report(grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal.")) -> None:
    """Write a page about the class: scores, exercises and refused submissions (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.commands import classes

        for line in classes.report(grades):
            _say(line)


@app.command(hidden=_STUDENTS)
def status(grades: Path = typer.Argument(..., metavar="GRADES", help="Folder of the journal.")) -> None:
    """List who handed in, what waits for marks or answers, and what to do next; also as a page (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.commands import classes

        for line in classes.status(console, grades):
            _say(line)


@app.command(hidden=_STUDENTS)
def similar(
    submissions: Path = typer.Argument(..., help="Folder of submissions, or the zip archive, as for grade."),
    out: Path = typer.Option(..., metavar="FOLDER", help="Folder for the page."),
    lesson: list[str] = typer.Option(
        [], help="Number of a lesson; by default all lessons that were handed in."
    ),
) -> None:
    """Write a page with pairs of notebooks whose own code is suspiciously similar (instructors)."""
    with _errors_in_words():
        from nao_course.instructor.similarity.command import find_similar

        for line in find_similar(console, submissions, lesson, out):
            _say(line)


@new.command("exercise")
def new_exercise(
    lesson: str, name: str, a_class: bool = typer.Option(False, "--class", help="The student writes a class.")
) -> None:
    """Add an exercise to a lesson: a declaration and its cells, with a TODO for each open part."""
    with _errors_in_words():
        from nao_course.instructor.authoring import scaffold
        from nao_course.instructor.authoring.course import load_course

        for path in scaffold.add_exercise(load_course(), lesson, name, a_class=a_class):
            _say(f"wrote {os.path.relpath(path)}")


@new.command("lesson")
def new_lesson(
    number: str,
    name: str,
    short: bool = typer.Option(False, "--short", help="One function, one question and no figure."),
) -> None:
    """Create a lesson: a text and a declaration, with a TODO for each open part."""
    with _errors_in_words():
        from nao_course.instructor.authoring import scaffold
        from nao_course.instructor.authoring.course import load_course

        for path in scaffold.add_lesson(load_course(), number, name, short=short):
            _say(f"wrote {os.path.relpath(path)}")


if __name__ == "__main__":
    app()
