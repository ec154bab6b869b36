"""The panels of all lessons, made from the solutions' own cells without running the rest of a lesson."""

import ast
import builtins
import re
from functools import cache
from typing import Any

import nbformat

from nao_course.exercises.earlier import resolved_by
from nao_course.instructor.authoring.plans import load_solution, solutions_beside
from tests.browser.lab import Lab
from tests.paths import SOLUTIONS

# The robot without a solved lesson, and with all lessons solved
MY_NAO = "from nao_course.student import my_nao\nmy_nao()"
MY_SOLVED_NAO = f"%cd -q {SOLUTIONS}\nmy_nao()"
PANELS = ("Panel", "Lab", "Dial")  # ends of the names of the classes whose call ends a cell
# No panel of a busy machine is stopped for being late, and nothing is imported before the limit is known. The filter
# panel calls every function slow, so that its text, and with it its height, is the same on every machine.
IMPORT = """%env NAO_COURSE_TIME_LIMIT=240
import nao_course.lessons.hsl_filtering.panel
from tests.browser.lesson_panels import panel_of
nao_course.lessons.hsl_filtering.panel.SLOW = 0"""


@cache
def code_cells(lesson: str) -> list[str]:
    """Return the code cells of a lesson's solution."""
    notebook = nbformat.read(SOLUTIONS / f"{lesson}.ipynb", as_version=4)
    return [cell.source for cell in notebook.cells if cell.cell_type == "code"]


def panel_cells() -> list[tuple[str, int]]:
    """Return (lesson, number of the code cell) of each cell that ends with a panel."""
    lessons = sorted(path.stem for path in SOLUTIONS.glob("*.ipynb"))
    return [
        (lesson, number)
        for lesson in lessons
        for number, source in enumerate(code_cells(lesson))
        if _ends_with_panel(source)
    ]


def further_cells() -> list[tuple[str, int]]:
    """Return (lesson, number of the code cell) of each derivation sheet, and of each panel that has a name."""
    return [
        (path.stem, number)
        for path in sorted(SOLUTIONS.glob("*.ipynb"))
        for number, source in enumerate(code_cells(path.stem))
        if re.search(r"^(\w+\.\w+_sheet\(\)|panel)$", source.rstrip().split("\n")[-1])
    ]


def panels_by_kind() -> dict[str, tuple[str, int]]:
    """Return (lesson, number of the code cell) of the first panel of each kind, by the name of its class."""
    cells = {(lesson, number): code_cells(lesson)[number] for lesson, number in reversed(panel_cells())}
    return {_called(_parsed(source)[-1]): place for place, source in cells.items()}


def panel_of(lesson: str, number: int) -> Any:
    """Return the panel of a code cell: its names come from the solution and, if needed, from earlier cells."""
    with resolved_by(solutions_beside(SOLUTIONS / f"{lesson}.ipynb")):
        return _panel_of(lesson, number)


def _panel_of(lesson: str, number: int) -> Any:
    cells = [_parsed(source) for source in code_cells(lesson)]
    names = {"__name__": f"lesson_{lesson}", **load_solution(SOLUTIONS / f"{lesson}.ipynb")}
    imports = [each for cell in cells for each in cell if isinstance(each, ast.Import | ast.ImportFrom)]
    _run(imports, names)
    _run_with_earlier(cells[: number + 1], names)
    return eval(compile(ast.Expression(cells[number][-1].value), lesson, "eval"), names)


class PanelPage:
    """A page with the panels and derivation sheets of all lessons, and `my_nao()`, below each other."""

    def __init__(self, lab: Lab, page: Any) -> None:
        self.page = page
        places = panel_cells() + further_cells()
        self.labels = [f"{lesson[:2]}, code cell {number}" for lesson, number in places]
        self.labels += ["my_nao(), nothing solved", "my_nao(), everything solved"]
        cells = [f"panel_of({lesson!r}, {number})" for lesson, number in places]
        lab.write("panels.ipynb", IMPORT, *cells, MY_NAO, MY_SOLVED_NAO)
        lab.open(page, "panels.ipynb")
        page.evaluate("window.jupyterapp.commands.execute('application:toggle-left-area').then(() => null)")
        lab.run_all(page)
        assert lab.errors(page) == []

    def choose(self, theme: str) -> None:
        """Choose JupyterLab's theme, "Light" or "Dark"."""
        command = (
            "theme => window.jupyterapp.commands.execute('apputils:change-theme', {theme}).then(() => null)"
        )
        self.page.evaluate(command, f"JupyterLab {theme}")

    def show(self, index: int, width: int) -> Any:
        """Return a panel on a page of this width in px, scrolled to, when its pictures are there."""
        self.page.set_viewport_size({"width": width, "height": 1200})
        self.page.evaluate(
            """index => { const notebook = window.jupyterapp.shell.currentWidget.content;
            notebook.activeCellIndex = index; return notebook.scrollToItem(index, 'start'); }""",
            index + 1,
        )
        cell = self.page.locator(f'.jp-Cell[data-windowed-list-index="{index + 1}"]')
        root = cell.locator(".jp-OutputArea-output .jupyter-widgets").first
        root.locator("img, canvas, input").first.wait_for(timeout=240_000)
        self.page.wait_for_function(
            "root => [...root.querySelectorAll('img')].every(each => each.complete && each.naturalWidth)",
            arg=root.element_handle(),
        )
        return root

    def photograph(self, index: int, width: int) -> bytes:
        """Return a picture of a panel as PNG."""
        root = self.show(index, width)
        self.page.wait_for_timeout(500)
        return bytes(root.screenshot())


def _run_with_earlier(cells: list[list[Any]], names: dict[str, Any]) -> None:
    """Run the last of some cells without its last expression, after the cells that define the names it uses."""
    *before, cell = cells
    used = set().union(*(_names(each, ast.Load) for each in cell))
    for name in sorted(used - names.keys() - set(dir(builtins))):
        places = [place for place, each in enumerate(before) if any(name in _defined(line) for line in each)]
        if places and name not in names:
            _run_with_earlier(before[: places[-1] + 1], names)
    _run(cell[:-1] if isinstance(cell[-1], ast.Expr) else cell, names)


def _parsed(source: str) -> list[Any]:
    return ast.parse("\n".join("" if line[:1] in "%!" else line for line in source.split("\n"))).body


def _ends_with_panel(source: str) -> bool:
    return bool(statements := _parsed(source)) and _called(statements[-1]).endswith(PANELS)


def _called(statement: Any) -> str:
    """Return the name of what a statement only calls, without the module before it; "" if it does anything else."""
    call = statement.value if isinstance(statement, ast.Expr) else None
    function = call.func if isinstance(call, ast.Call) else None
    return getattr(function, "attr", getattr(function, "id", ""))


def _run(statements: list[Any], names: dict[str, Any]) -> None:
    exec(compile(ast.Module(statements, []), "lesson", "exec"), names)


def _defined(statement: Any) -> set[str]:
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return {statement.name}
    return _names(statement, ast.Store)


def _names(tree: Any, kind: type) -> set[str]:
    return {each.id for each in ast.walk(tree) if isinstance(each, ast.Name) and isinstance(each.ctx, kind)}
