"""A sheet for a Jacobian that was derived with pen and paper: a field for each entry, checked by SymPy.

SymPy and ipywidgets are imported where they are used, because importing them takes long.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from html import escape
from typing import Any

import numpy as np

from nao_course.exercises.asking import styles_that_keep_keys
from nao_course.exercises.comparisons.jacobians import UNKNOWN_SLIP, Derivative, evaluated, jacobian
from nao_course.exercises.trying import Message

POINTS = 12  # number of points at which derivatives are compared
LONGEST = 300  # greatest number of characters in an entry
LARGEST = 10**12  # greatest number, also in a fraction: exact powers of larger numbers take too long
LARGEST_POWER = 20
# px: the greatest width of a field, and the width that a few fields share.
FIELD, SHEET = (190, 700)
TOO_LARGE = "It contains too large a number."
_FUNCTIONS = ("sin", "cos", "tan", "sqrt", "exp", "log", "atan", "atan2")
_NUMPY_NAMES = {"arctan": "atan", "arctan2": "atan2"}
_LIBRARIES = ("np", "numpy", "math", "sympy", "sp")
_SIGNS = {
    "\N{MINUS SIGN}": "-",
    "\N{EN DASH}": "-",
    "\N{MIDDLE DOT}": "*",
    "\N{DOT OPERATOR}": "*",
    "\N{MULTIPLICATION SIGN}": "*",
    "\N{SUPERSCRIPT TWO}": "**2",
    "^": "**",
    "θ": "theta",
    "ϑ": "theta",
    "α": "alpha",
    "β": "beta",
    "π": "pi",
    "ξ": "xi",
    "Δ": "d",
    "\N{INCREMENT}": "d",
}
_OPERATORS: Mapping[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_RIGHT, _WRONG, _PLAIN = (
    "2px solid var(--nao-right, #1a7f37)",
    "2px dashed var(--nao-wrong, #9a6700)",
    "1px solid #999",
)
_CSS = """
.nao-sheet input { font-family: monospace; }
.nao-sheet .widget-html-content { line-height: 20px; }
.nao-sheet .widget-htmlmath { min-height: 20px; margin: 0 2px; }
"""


def parse(typed: str, symbols: Mapping[str, Any]) -> Any:
    """Parse a typed entry: numbers, symbols, + - * / and powers, and functions such as sin.

    Both r^2 and r**2 are powers; `symbols` maps the names that may occur to their meanings. Raise a ValueError that
    explains what to write if it is not an expression.
    """
    text = _as_python(typed)
    if len(text) > LONGEST:
        raise ValueError(f"{text[:20]!r}... is too long: write at most {LONGEST} characters.")
    try:
        tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(
            f"{_short(typed)!r} is not an expression. Write it as in Python: -d*sin(theta), with a * for each product."
        ) from None
    return _expression(tree, symbols)


def _as_python(typed: str) -> str:
    """Return a typed entry with Python's signs, and with the names of Greek letters."""
    text = typed.strip()
    for sign, meaning in _SIGNS.items():
        text = text.replace(sign, meaning)
    return text


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."


def _expression(node: ast.expr, symbols: Mapping[str, Any]) -> Any:
    import sympy

    match node:
        case ast.Constant(int() | float() as number) if not isinstance(number, bool):
            return _moderate(sympy.sympify(number))
        case ast.Name("pi"):
            return sympy.pi
        case ast.Name(name) if name in symbols:
            return symbols[name]
        case ast.Name(name):
            raise ValueError(_unknown(name, symbols))
        case ast.UnaryOp(ast.USub(), operand):
            return -_expression(operand, symbols)
        case ast.UnaryOp(ast.UAdd(), operand):
            return _expression(operand, symbols)
        case ast.BinOp(left, sign, right) if type(sign) in _OPERATORS:
            parts = _expression(left, symbols), _expression(right, symbols)
            if isinstance(sign, ast.Pow) and parts[1].is_number and not _is_small(parts[1], LARGEST_POWER):
                raise ValueError(f"{_short(ast.unparse(right))} is too large a power.")
            return _moderate(_OPERATORS[type(sign)](*parts))
        case ast.Call(ast.Attribute(ast.Name(library), name), arguments, []) if library in _LIBRARIES:
            return _expression(ast.Call(ast.Name(name), arguments, []), symbols)
        case ast.Call(ast.Name(name), arguments, []) if _function(name):
            parts = tuple(_expression(each, symbols) for each in arguments)
            if _function(name) == "exp" and any(each.is_number and not _is_small(each, 50) for each in parts):
                raise ValueError(TOO_LARGE)
            return getattr(sympy, _function(name))(*parts)
        case ast.Call(ast.Name(name)) if name in symbols:
            raise ValueError(f"A * is missing after {name}.")
        case ast.Call(ast.Name(name)) if before := _before_function(name, symbols):
            raise ValueError(f"A * is missing after {before}.")
        case ast.Call(ast.Constant(number)):
            raise ValueError(f"A * is missing after {number!r}.")
    raise ValueError(
        f"{_short(ast.unparse(node))} is not supported: use + - * / and {', '.join(_FUNCTIONS)}."
    )


def _moderate(value: Any) -> Any:
    """Return a value; raise ValueError if it is a number too large for exact arithmetic."""
    if value.is_Rational and max(abs(value.p), value.q) > LARGEST:
        raise ValueError(TOO_LARGE)
    return value


def _is_small(number: Any, limit: float) -> bool:
    """Return whether an evaluated number is at most `limit`; False for a number that is not evaluated yet."""
    return bool(number.is_Number and number.is_finite and abs(number) <= limit)


def _function(name: str) -> str:
    """Return SymPy's name of a function, also for NumPy's name and capitals; "" for an unknown function."""
    name = _NUMPY_NAMES.get(name.lower(), name.lower())
    return name if name in _FUNCTIONS else ""


def _before_function(name: str, symbols: Mapping[str, Any]) -> str:
    """Return the symbol that precedes a function without an operator, such as d in dsin; "" without one."""
    return next((each for each in symbols if name.startswith(each) and _function(name[len(each) :])), "")


def _unknown(name: str, symbols: Mapping[str, Any]) -> str:
    for function in _FUNCTIONS:
        if name.startswith(function) and name[len(function) :] in symbols:
            return f"{function} needs brackets: write {function}({name[len(function) :]})."
    for symbol in symbols:
        if symbol.replace("_", "").lower() == name.replace("_", "").lower():
            return f"{_short(name)!r} is called {symbol} here."
    return f"{_short(name)!r} is not a symbol of this model; use {', '.join(symbols)}."


class DerivationSheet:
    """A sheet with a student's derivatives of a model, which checks them entry by entry.

    Parameters
    ----------
    title : str
        Title of the sheet.
    model : sympy.Matrix
        The R rows of the model.
    by : sequence of sympy.Symbol
        The C symbols to differentiate by.
    zero : sequence of sympy.Symbol
        Symbols that are 0 at the point of linearisation, such as a noise.
    rows : sequence of str
        Names of the model's rows; by default their numbers.
    known : sequence of sequences
        Entries (R, C) that are filled in at first, with an empty text for each open entry.
    short : mapping of str to sympy.Expr
        Abbreviations that may be typed: {"dx": l_x - x}; a Δ is read as d.
    slips : mapping of (int, int) to mapping of str to sympy.Expr
        Typical wrong entries by row and column, each with what is said about it.
    """

    def __init__(
        self,
        title: str,
        model: Any,
        by: Sequence[Any],
        zero: Sequence[Any] = (),
        rows: Sequence[str] = (),
        known: Sequence[Sequence[Any]] = (),
        short: Mapping[str, Any] | None = None,
        slips: Mapping[tuple[int, int], Mapping[str, Any]] | None = None,
    ) -> None:
        self._slips = slips or {}
        self.title, self.model, self.known = title, model, known
        self.by = [str(each) for each in by]
        self.rows = list(rows) or [f"row {number}" for number in range(1, len(model) + 1)]
        free = {str(each): each for each in sorted({*model.free_symbols, *by}, key=str)}
        self._zero = {str(each) for each in zero}
        self.symbols = {name: symbol for name, symbol in free.items() if name not in self._zero}
        self._short = set(short or {})
        self.symbols |= short or {}
        rng = np.random.default_rng(len(title))
        drawn = {name: rng.uniform(0.3, 2.4, POINTS) * rng.choice([-1, 1], POINTS) for name in free}
        self._points = {name: 0.0 * at if name in self._zero else at for name, at in drawn.items()}
        self._view: _SheetView | None = None

    def write(self, entries: Any) -> Message:
        """Check entries, and return a message that names the wrong ones.

        Parameters
        ----------
        entries : sequence of sequences, or sympy.Matrix
            Texts, numbers or expressions (R, C); an empty text is an entry that is not derived yet.
        """
        try:
            table = [list(row) for row in (entries.tolist() if hasattr(entries, "tolist") else entries)]
        except TypeError:
            table = []
        if [len(row) for row in table] != [len(self.by)] * len(self.rows):
            return Message(
                f"The entries do not form a matrix of {len(self.rows)} rows and {len(self.by)} columns."
            )
        said, marks = self._judged(table)
        if self._view is not None:
            self._view.show(table, marks, said)
        return Message(said)

    def _judged(self, table: list[list[Any]]) -> tuple[str, dict[tuple[int, int], str]]:
        """Return the message about all entries, and the error of each entry: an empty text if it is right."""
        import sympy

        read, marks = sympy.zeros(len(self.rows), len(self.by)), dict[tuple[int, int], str]()
        for at, entry in ((at, table[at[0]][at[1]]) for at in np.ndindex(*read.shape)):
            if isinstance(entry, str) and not entry.strip():
                continue
            try:
                read[at] = self._parsed(entry) if isinstance(entry, str) else self._sympified(entry)
                marks[at] = ""
            except (ValueError, TypeError, AttributeError, ZeroDivisionError) as error:
                marks[at] = str(error)
        if not marks:
            return "Write your derivatives into the fields, then check them.", marks
        with np.errstate(all="ignore"):
            try:
                answer = jacobian(lambda: (self.model, read), self._points, self.by)
                got = evaluated(answer, self._points, self.by)
                faults = Derivative(tuple(self.by)).faults(got)
                faults |= {at: self._slip(at, read[at], said) for at, said in faults.items()}
            except (ValueError, TypeError, OverflowError) as error:
                return f"These entries cannot be computed: {error}", marks
        # The model is the sheet's, not the student's
        found = {at: said.replace("your model", "the model") for at, said in faults.items()}
        marks = {at: said or found.get(at, "") for at, said in marks.items()}
        return self._summary_of(marks), marks

    def _parsed(self, entry: str) -> Any:
        """Return a typed entry as an expression; a symbol that is 0 at the point of linearisation raises ValueError."""
        for name in sorted(self._zero & set(re.findall(r"\w+", _as_python(entry)))):
            raise ValueError(f"{name} is 0 where this Jacobian is evaluated; set it to 0 in your entry.")
        return parse(entry, self.symbols)

    def formula(self, entry: str) -> str:
        """Return a typed entry as TeX between dollar signs, or an empty text for a number or an error."""
        import sympy

        letters = {name: sympy.Symbol(name) for name in (*self.symbols, *self._zero)}
        deltas = {letters[name]: f"\\Delta {name[1:]}" for name in self._short if name.startswith("d")}
        try:
            typed = parse(entry, letters)
        except (ValueError, TypeError, AttributeError, ZeroDivisionError):
            return ""
        if typed.is_Number:
            return ""
        return f"${sympy.latex(typed, symbol_names=deltas)}$"

    def _sympified(self, entry: Any) -> Any:
        """Return an entry that is a number or an expression in the model's symbols."""
        import sympy

        expression = sympy.sympify(entry, strict=True)
        if not isinstance(expression, sympy.Expr):
            raise ValueError(f"{_short(str(entry))} is not an expression.")
        for name in sorted(map(str, expression.free_symbols)):
            if name not in self._points:
                raise ValueError(_unknown(name, self.symbols))
        return expression

    def _slip(self, at: tuple[int, int], entry: Any, said: str) -> str:
        """Return the known mistake that produces a wrong entry, or else what the comparison said."""
        import sympy

        likely = list(self._slips.get(at, {}).items())
        if said == UNKNOWN_SLIP:
            likely += self._likely(*at)
        candidates = [entry, *(each for _, each in likely)]
        # NumPy has no complex infinity.
        finite = [each.xreplace({sympy.zoo: sympy.nan}) for each in candidates]
        compiled = sympy.lambdify(list(self._points), finite, "numpy")
        values = np.array(
            [compiled(*point) for point in zip(*self._points.values(), strict=True)], dtype=complex
        )
        return next(
            (
                text
                for (text, _), column in zip(likely, values.T[1:], strict=True)
                if np.allclose(column, values[:, 0], rtol=1e-5, atol=1e-5)
            ),
            said,
        )

    def _likely(self, row: int, column: int) -> Iterator[tuple[str, Any]]:
        """Yield the likely mistakes for an entry: a description and the wrong expression."""
        import sympy

        general = sympy.diff(self.model[row], sympy.Symbol(self.by[column]))
        nothing = dict.fromkeys(self._zero, 0)
        derivative = general.subs(nothing)
        for term in sympy.Add.make_args(sympy.expand(self.model[row].subs(nothing))):
            yield "it is a term of the model itself: differentiate it", term
        partner = {sympy.sin: sympy.cos, sympy.cos: sympy.sin}
        swapped = general.replace(
            lambda each: each.func in partner, lambda each: partner[each.func](*each.args)
        ).subs(nothing)
        yield "sine and cosine are swapped", swapped
        yield "sine and cosine are swapped, and the sign is wrong", -swapped
        for other, by in np.ndindex(len(self.rows), len(self.by)):
            elsewhere = sympy.diff(self.model[other], sympy.Symbol(self.by[by])).subs(nothing)
            if (other, by) != (row, column) and not elsewhere.is_number:
                yield f"it is the derivative of {self._place(other, by)}", elsewhere
        for symbol in sorted(derivative.free_symbols, key=str):
            yield f"the factor {symbol} is missing", derivative / symbol
            yield f"the factor {symbol} is missing, and the sign is wrong", -derivative / symbol
            yield f"the variable {symbol} is missing", derivative.subs(symbol, 0)
        for name in sorted(self._zero):
            yield f"it is evaluated at {name} = 1 instead of 0", general.subs(nothing | {name: 1})

    def _summary_of(self, marks: Mapping[tuple[int, int], str]) -> str:
        total, right = len(self.rows) * len(self.by), sum(not said for said in marks.values())
        if right == total:
            return f"✔ All {total} entries are correct."
        wrong = [f"{self._place(*at)}: {said.rstrip('.')}." for at, said in marks.items() if said]
        empty = f"{total - len(marks)} still empty." if len(marks) < total else ""
        return " ".join(filter(None, [f"{right} of {total} entries are correct.", *wrong, empty]))

    def _place(self, row: int, column: int) -> str:
        return f"{self.rows[row]} by {self.by[column]}"

    def __repr__(self) -> str:
        """Return the task as text, for places without widgets."""
        return (
            f"{self.title}: find the {len(self.rows)} x {len(self.by)} derivatives of {', '.join(self.rows)} by "
            f"{', '.join(self.by)}; symbols: {', '.join(self.symbols)}."
        )

    def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, Any]:
        """Return the fields, and the task as text for places without widgets."""
        if self._view is None:
            self._view = _SheetView(self)
            if self.known:
                self.write([list(map(str, row)) for row in self.known])
        return {**self._view.box._repr_mimebundle_(**kwargs), "text/plain": repr(self)}


class _SheetView:
    """The widgets of a sheet: a grid of fields, which are checked by Enter, by leaving a field, or by the button."""

    def __init__(self, sheet: DerivationSheet) -> None:
        import ipywidgets

        self.sheet = sheet
        self._filling = False  # while the code fills in the fields
        self.fields = [
            [
                ipywidgets.Text(placeholder="", tooltip=sheet._place(*at), continuous_update=False)
                for at in row
            ]
            for row in ([(r, c) for c in range(len(sheet.by))] for r in range(len(sheet.rows)))
        ]
        self.formulas = [[ipywidgets.HTMLMath() for _ in row] for row in self.fields]
        for field in (field for row in self.fields for field in row):
            field.layout = ipywidgets.Layout(width="auto", border=_PLAIN)
            field.observe(self.check, names="value")
        pairs = [zip(*rows, strict=True) for rows in zip(self.fields, self.formulas, strict=True)]
        cells = [[ipywidgets.VBox(pair) for pair in row] for row in pairs]
        heads = [ipywidgets.HTML(f"<b>by {escape(name)}</b>") for name in sheet.by]
        lines = [
            [ipywidgets.HTML(f"<b>{escape(name)}</b>"), *row]
            for name, row in zip(sheet.rows, cells, strict=True)
        ]
        widest = max(FIELD, SHEET // len(sheet.by))
        layout = ipywidgets.Layout(
            grid_template_columns=f"max-content repeat({len(sheet.by)}, minmax(90px, {widest}px))",
            grid_gap="4px 8px",
        )
        grid = ipywidgets.GridBox(
            [ipywidgets.HTML(), *heads, *(each for line in lines for each in line)], layout=layout
        )
        self.said = ipywidgets.HTML(
            Message("Write your derivatives into the fields, then check them.")._repr_html_()
        )
        button = ipywidgets.Button(
            description="Check", tooltip="Compare each entry with the model's derivative"
        )
        button.on_click(self.check)
        title = ipywidgets.HTML(f"{styles_that_keep_keys(_CSS)}<b>{escape(sheet.title)}</b>")
        self.box = ipywidgets.VBox([title, grid, button, self.said])
        self.box.add_class("nao-sheet").add_class("nao-asks")

    def check(self, _: Any = None) -> None:
        """Check the entries in the fields."""
        if not self._filling:
            self.sheet.write([[field.value for field in row] for row in self.fields])

    def show(self, table: list[list[Any]], marks: Mapping[tuple[int, int], str], said: str) -> None:
        """Show entries, frame each in the colour of its result, and show the message."""
        self._filling = True
        for row, line in enumerate(self.fields):
            for column, field in enumerate(line):
                found = marks.get((row, column))
                field.value = str(table[row][column])
                self.formulas[row][column].value = self.sheet.formula(field.value)
                field.layout.border = _PLAIN if found is None else _WRONG if found else _RIGHT
        self._filling = False
        self.said.value = Message(said)._repr_html_()


@cache  # a cell that is run again shows the same sheet with its entries
def _sheet(
    title: str,
    model: Any,
    by: tuple[Any, ...],
    zero: tuple[Any, ...],
    rows: tuple[str, ...],
    known: tuple[tuple[Any, ...], ...],
    short: tuple[tuple[str, Any], ...],
    slips: tuple[tuple[tuple[int, int], tuple[tuple[str, Any], ...]], ...],
) -> DerivationSheet:
    wrong = {at: dict(entries) for at, entries in slips}
    return DerivationSheet(title, model, by, zero, rows, known, dict(short), wrong)


def derivation(
    title: str,
    model: Any,
    by: Sequence[Any],
    *,
    zero: Sequence[Any] = (),
    rows: Sequence[str] = (),
    known: Sequence[Sequence[Any]] = (),
    short: Mapping[str, Any] | None = None,
    slips: Mapping[tuple[int, int], Mapping[str, Any]] | None = None,
) -> DerivationSheet:
    """Return a sheet that checks a Jacobian derived with pen and paper.

    Parameters
    ----------
    title : str
        Title of the sheet.
    model : sympy.Matrix
        The R rows of the model.
    by : sequence of sympy.Symbol
        The C symbols to differentiate by.
    zero : sequence of sympy.Symbol
        Symbols that are 0 at the point of linearisation, such as a noise.
    rows : sequence of str
        Names of the model's rows; by default their numbers.
    known : sequence of sequences
        Entries (R, C) that are filled in at first, with an empty text for each open entry.
    short : mapping of str to sympy.Expr
        Abbreviations that may be typed: {"dx": l_x - x}; a Δ is read as d.
    slips : mapping of (int, int) to mapping of str to sympy.Expr
        Typical wrong entries by row and column, each with what is said about it.

    Returns
    -------
    DerivationSheet
        The sheet; equal arguments give the same sheet. Its `write(entries)` fills it in without widgets.

    Examples
    --------
    >>> from sympy import Matrix, symbols
    >>> x, y = symbols("x y")
    >>> sheet = derivation("Derivatives of x y and x + y", Matrix([x * y, x + y]), [x, y], rows=("product", "sum"))
    >>> sheet.write([["y", "-x"], [1, ""]])
    2 of 4 entries are correct. product by y: its sign is wrong. 1 still empty.
    """
    return _sheet(
        title,
        model.as_immutable(),
        tuple(by),
        tuple(zero),
        tuple(rows),
        tuple(map(tuple, known)),
        tuple((short or {}).items()),
        tuple((at, tuple(entries.items())) for at, entries in (slips or {}).items()),
    )
