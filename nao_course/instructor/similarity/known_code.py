"""Code that students may have in common: what a release gives them, and the course's own answers."""

import ast
from collections import Counter
from collections.abc import Iterator

from nao_course.exercises.notebook_text import read_cells
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import Course

_Definition = ast.FunctionDef | ast.ClassDef


def known_code(course: Course, lesson: str) -> list[str]:
    """Return the code of a lesson that students may have in common: what is given, and right answers."""
    answers = right_answers(course, lesson).values()
    return [*given_code(course, lesson), *(code for codes in answers for code in codes)]


def given_code(course: Course, lesson: str) -> list[str]:
    """Return the code cells of a lesson's notebook as it is released, with the stubs of its exercises."""
    return [source for _, source in read_cells(course.root / "notebooks" / f"{lesson}.ipynb")]


def right_answers(course: Course, lesson: str) -> dict[str, list[str]]:
    """Return the reference solution of each exercise of a lesson, then the alternatives in the declaration's order.

    Code that several alternatives of a declaration share, such as a function that adapts them, is in none of them.
    """
    notebook = lesson_text.read_lesson(course.text(lesson))
    answers = {
        lesson_text.exercise_name(cell): [cell.source]
        for _, cell in lesson_text.code_cells(notebook, "exercise")
    }
    file = course.declaration(lesson)
    for exercise, codes in alternatives(file.read_text(encoding="utf-8") if file.exists() else "").items():
        answers.setdefault(exercise, []).extend(codes)
    return answers


def model_answers(course: Course, lesson: str) -> dict[str, str]:
    """Return the course's own answers to the written questions of a lesson."""
    cells = lesson_text.written_cells(lesson_text.read_lesson(course.text(lesson)))
    return {lesson_text.exercise_name(cell): cell.source for _, cell in cells}


def alternatives(declaration: str) -> dict[str, list[str]]:
    r"""Return the code of the alternatives in a declaration's text, by exercise.

    >>> text = '''
    ... def _loop(x):
    ...     return sum(x)
    ... E = Exercise(name="total", alternatives={"a loop": _loop, "NumPy": lambda x: np.sum(x)})
    ... '''
    >>> alternatives(text)
    {'total': ['def _loop(x):\n    return sum(x)', 'lambda x: np.sum(x)']}
    """
    tree = ast.parse(declaration)
    definitions = {each.name: each for each in tree.body if isinstance(each, _Definition)}
    found = {
        exercise: [(value, _used(value, definitions)) for value in values]
        for exercise, values in _declared(tree)
    }
    # An alternative may be declared for two exercises
    users = {value: used for pairs in found.values() for value, used in pairs}
    count = Counter(name for used in users.values() for name in used)

    def code(value: ast.expr, used: set[str]) -> str:
        name = value.id if isinstance(value, ast.Name) else ""
        own = [definitions[each] for each in used if count[each] == 1 or each == name]
        parts: list[ast.AST] = [*sorted(own, key=lambda node: node.lineno)]
        if name not in definitions:
            parts.append(value)
        return "\n\n".join(ast.get_source_segment(declaration, part) or "" for part in parts)

    return {exercise: [code(*each) for each in pairs] for exercise, pairs in found.items()}


def _declared(tree: ast.Module) -> Iterator[tuple[str, list[ast.expr]]]:
    """Yield the name of each exercise with the expressions of its alternatives."""
    assigned: dict[str, ast.expr | None] = {}
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            assigned |= {each.id: node.value for each in targets if isinstance(each, ast.Name)}
    for call in ast.walk(tree):
        if not isinstance(call, ast.Call):
            continue
        options = {each.arg: each.value for each in call.keywords}
        name = call.args[0] if call.args else options.get("name")
        given = options.get("alternatives")
        if isinstance(given, ast.Name):
            given = assigned.get(given.id)
        if isinstance(name, ast.Constant) and isinstance(given, ast.Dict):
            yield str(name.value), given.values


def _used(node: ast.AST, definitions: dict[str, _Definition]) -> set[str]:
    """Return the names of a file's functions and classes that an expression uses, also indirectly."""
    used: set[str] = set()
    waiting: list[ast.AST] = [node]
    while waiting:
        for each in ast.walk(waiting.pop()):
            if isinstance(each, ast.Name) and each.id in definitions and each.id not in used:
                used.add(each.id)
                waiting.append(definitions[each.id])
    return used
