"""The derivation sheet: what is typed is read as on paper, each wrong entry is named, right ones are framed green."""

import pytest
import sympy
from sympy import Matrix, atan2, cos, sin

from nao_course.widgets.derivation_sheet import _RIGHT, _WRONG, DerivationSheet, derivation, parse

x, theta, d, e = sympy.symbols("x theta d e")
MODEL = Matrix([x + (d + e) * cos(theta), theta + e**2])
RIGHT = [["1", "-d*sin(theta)"], ["0", "1"]]


def sheet(**options):
    return DerivationSheet("F", MODEL, [x, theta], zero=[e], rows=("new x", "new theta"), **options)


@pytest.mark.parametrize(
    ("typed", "value"),
    [
        ("-d*sin(theta)", -d * sin(theta)),
        (" - d * sin(θ) ", -d * sin(theta)),
        ("\N{MINUS SIGN}d·sin(theta)", -d * sin(theta)),
        ("d^2/x**2", d**2 / x**2),
        ("1.5", sympy.Float(1.5)),
        ("atan2(x, d)", atan2(x, d)),
        ("np.arctan2(x, d)", atan2(x, d)),
        ("d×Sin(ϑ)²⋅x", d * sin(theta) ** 2 * x),
    ],
)
def test_an_entry_is_read_as_it_is_written_on_paper(typed, value):
    assert parse(typed, {"x": x, "theta": theta, "d": d}) == value


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("d sin(theta)", r"with a \* for each product"),
        ("d(theta)", r"A \* is missing after d"),
        ("phi", "'phi' is not a symbol of this model; use x, theta, d"),
        ("X", "'X' is called x here"),
        ("__import__('os')", "not supported|is not an expression"),
        ("x.diff", "not supported|is not an expression"),
        ("-d*sintheta", r"sin needs brackets: write sin\(theta\)"),
        ("9**9**9", "too large a power"),
        ("2**exp(exp(exp(exp(3))))", "too large a number"),
        ("2**sin(1)", "too large a power"),
        ("sqrt(10**15 + 1)", "too large a number"),
        ("+".join(["x"] * 400), "too long"),
        ("(" * 140 + ")" * 140, "not supported|is not an expression"),
    ],
)
def test_what_cannot_be_read_is_said(typed, said):
    with pytest.raises(ValueError, match=said):
        parse(typed, {"x": x, "theta": theta, "d": d})


def test_right_entries_are_right_in_any_form_and_wrong_missing_and_impossible_ones_are_named():
    for entries in (RIGHT, [[1, "-d*sin(theta)"], [0.0, 1]], MODEL.jacobian([x, theta]).subs(e, 0)):
        assert repr(sheet().write(entries)) == "✔ All 4 entries are correct."
    said = repr(sheet().write([["1", "d*sin(theta)"], ["", "theta"]]))
    assert said.startswith("1 of 4 entries are correct. new x by theta: its sign is wrong. new theta by")
    assert said.endswith("1 still empty.")
    assert "e is 0 where this Jacobian is evaluated" in repr(sheet().write([["1", "e"], ["0", "1"]]))
    assert repr(sheet().write([["", ""], ["", ""]])).startswith("Write your derivatives")
    assert repr(sheet().write([["1", "1"]])) == "The entries do not form a matrix of 2 rows and 2 columns."
    said = repr(sheet().write([["1/(x - x)", "-d*sin(theta)"], ["0", "1"]]))
    assert said.startswith("3 of 4 entries are correct. new x by x:")


MOTION = Matrix([x + (d + e) * cos(theta) - e * sin(theta), 2 * d * x * sin(theta + x)])


@pytest.mark.parametrize(
    ("at", "entry", "said"),
    [
        ((0, 1), "d*cos(theta)", "a term of the model itself: differentiate it"),
        ((0, 1), "d*sin(theta)", "its sign is wrong"),
        ((0, 1), "-sin(theta)", "the factor d is missing"),
        ((0, 1), "sin(theta)", "the factor d is missing, and the sign is wrong"),
        ((0, 1), "-d*sin(theta) - cos(theta) - sin(theta)", "it is evaluated at e = 1 instead of 0"),
        ((1, 1), "-2*d*x*sin(theta + x)", "sine and cosine are swapped, and the sign"),
        ((1, 1), "2*d*x*cos(x)", "the variable theta is missing"),
        ((1, 1), "2.001*d*x*cos(theta + x)", "close, but rounded"),
        ((1, 1), "d*exp(x)", "a small change of that variable"),
        ((1, 1), "-d*sin(theta)", "it is the derivative of a by theta"),
    ],
)
def test_the_likely_slip_is_named(at, entry, said, recwarn):
    entries = MOTION.jacobian([x, theta]).subs(e, 0).tolist()
    entries[at[0]][at[1]] = entry
    marked = DerivationSheet("F", MOTION, [x, theta], zero=[e], rows=("a", "b")).write(entries)
    assert said in repr(marked) and "3 of 4 entries are correct" in repr(marked)
    assert not recwarn.list


def test_a_sheets_own_slips_are_named_first_also_where_nothing_changes():
    slips = {(0, 1): {"that is the whole turn": 2 * d * cos(theta)}, (1, 0): {"theta keeps still": x}}
    said = repr(sheet(slips=slips).write([["1", "2*d*cos(theta)"], ["x", "1"]]))
    assert "new x by theta: that is the whole turn. new theta by x: theta keeps still." in said


def test_sine_and_cosine_are_swapped_before_their_angle_is_0():
    turned = DerivationSheet("R", Matrix([x * cos(e) - d * sin(e)]), [e], zero=[e], rows=("a",))
    assert "sine and cosine are swapped." in repr(turned.write([["-x"]]))


def test_only_names_that_may_be_typed_are_offered():
    assert "use d, theta, x." in repr(sheet().write([["phi", ""], ["", ""]]))


@pytest.mark.parametrize("entry", [None, sympy.Symbol("phi"), print, float("nan"), sympy.Matrix([1])])
def test_whatever_comes_from_code_is_the_one_wrong_entry(entry):
    said = repr(sheet().write([[1, entry], [0, 1]]))
    assert said.startswith("3 of 4 entries are correct. new x by theta: ") and len(said) < 200
    assert repr(sheet().write(None)) == "The entries do not form a matrix of 2 rows and 2 columns."


def test_the_fields_are_framed_and_keep_what_is_typed():
    shown = sheet()
    assert "F: find the 2 x 2 derivatives" in shown._repr_mimebundle_()["text/plain"]
    view = shown._view
    for row, texts in zip(view.fields, [["1", "d*sin(theta)"], ["0", ""]], strict=True):
        for field, text in zip(row, texts, strict=True):
            field.value = text
    borders = [field.layout.border_top for row in view.fields for field in row]
    assert borders[:3] == [_RIGHT, _WRONG, _RIGHT] and borders[3] not in (_RIGHT, _WRONG)
    assert "2 of 4 entries are correct" in view.said.value and view.fields[0][1].value == "d*sin(theta)"


@pytest.mark.parametrize(
    ("entry", "shown"),
    [
        ("d*sin(theta)", r"$d \sin{\left(\theta \right)}$"),
        ("-dx/q^2", r"$- \frac{\Delta x}{q^{2}}$"),
        ("d*", ""),
        ("1.5", ""),
        ("", ""),
    ],
)
def test_a_typed_entry_is_shown_as_a_formula_below_its_field(entry, shown):
    q = sympy.Symbol("q")
    one = DerivationSheet("F", sympy.Matrix([d * sympy.sin(theta) / q]), [theta], short={"dx": theta - q})
    assert one._repr_mimebundle_()
    one._view.fields[0][0].value = entry
    assert one._view.formulas[0][0].value == shown


def test_entries_from_code_stand_in_the_fields_and_a_cell_run_again_shows_the_sheet_as_it_was(monkeypatch):
    shown = sheet()
    shown._repr_mimebundle_()
    judged = []
    monkeypatch.setattr(shown, "_judged", lambda table: judged.append(table) or ("judged", {}))
    shown.write(RIGHT)
    assert [[field.value for field in row] for row in shown._view.fields] == RIGHT
    assert judged == [RIGHT] and "judged" in shown._view.said.value
    shown._view.check()
    assert len(judged) == 2
    first = derivation("kept", MODEL, [x, theta])
    assert derivation("kept", Matrix(MODEL), [x, theta]) is first
    assert derivation("another", MODEL, [x, theta]) is not first
    known = sheet(known=[[1, ""], ["", 1]])
    view = known._repr_mimebundle_() and known._view
    assert [[field.value for field in row] for row in view.fields] == [["1", ""], ["", "1"]]
    assert "2 of 4 entries are correct. 2 still empty." in view.said.value
    view.fields[0][1].value = "-d*sin(theta)"
    assert "3 of 4 entries are correct. 1 still empty." in view.said.value


def test_a_name_may_stand_for_something_longer_and_a_delta_is_a_d():
    y = sympy.Symbol("y")
    short = DerivationSheet("Away", Matrix([(y - x) * theta]), [x, theta], rows=("row",), short={"dx": y - x})
    for typed in ("dx", "Δx", "\N{INCREMENT}x", "y - x"):
        assert str(short.write([["-theta", typed]])) == "✔ All 2 entries are correct."
    assert "use theta" in str(short.write([["-theta", "dz"]])) and "dx" in str(short.write([["", "dz"]]))
    assert "repeat(2, minmax(90px, 350px))" in _layout(short)
    assert "190px" in _layout(DerivationSheet("Many", Matrix([x + d]), [x, d, e, theta, y], rows=("row",)))


def _layout(sheet):
    sheet._repr_mimebundle_()
    return sheet._view.box.children[1].layout.grid_template_columns
