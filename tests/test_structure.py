"""The laws of the house: who may import whom, no circles, rooms of a size that one can live in.

Each law is a function that lists its offences, so that it can be tried on a broken example too.
"""

import ast
import importlib
import re
import subprocess
import sys
import warnings
from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from nao_course.exercises.checking import read_public
from tests.paths import PROJECT

PACKAGE = "nao_course"

ORDER = "_internal codec, geometry, slam graphs, sim, datasets metrics robot, plotting, films, field_slam, widgets"
LAYERS = [set(each.split()) for each in f"{ORDER}, challenges, lessons".split(",")]
LAYER = {part: number for number, parts in enumerate(LAYERS) for part in parts}
WORLD = set().union(*LAYERS[LAYER["sim"] :])

# What the grader may know of the course.
CONTRACT = {"exercises", "codec", "homework", "_internal"}

MOST_MODULES = 11  # of a folder, its __init__ and the folders in it not counted
MOST_LINES = 500  # of a module


def module_files() -> dict[str, Path]:
    """Dotted name under nao_course ("sim.field", "" for the package itself) -> file."""
    package = PROJECT / PACKAGE
    names = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).with_suffix("").parts
        names[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return names


def sources() -> dict[str, str]:
    return {name: path.read_text(encoding="utf-8") for name, path in module_files().items()}


def packages() -> set[str]:
    return {name for name, path in module_files().items() if path.name == "__init__.py"}


def part_of(module: str) -> str:
    return module.split(".")[0]


@cache  # each law asks it of each module
def imported_names(module: str, source: str, *, is_package: bool = False) -> frozenset[str]:
    """What a module imports of nao_course, anywhere in it, as dotted names under it ("sim.field.Field")."""
    here = [PACKAGE, *filter(None, module.split("."))]
    package = here if is_package else here[:-1]
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            start = ".".join([*base, *filter(None, [node.module])])
            names |= {f"{start}.{alias.name}" for alias in node.names}
    return frozenset(name.removeprefix(f"{PACKAGE}.") for name in names if name.startswith(f"{PACKAGE}."))


def imported_parts(module: str, source: str, *, is_package: bool = False) -> set[str]:
    """The parts of nao_course (sim, plotting, ...) that a module imports, its own left out."""
    names = imported_names(module, source, is_package=is_package)
    return {part_of(name) for name in names} - {part_of(module)}


def import_graph(texts: Mapping[str, str], package_names: Iterable[str]) -> dict[str, set[str]]:
    """Module -> the modules it imports; a name of a package that is no module is the package's own."""
    known, inside = set(texts), set(package_names)

    def module_of(name: str) -> str:
        while name not in known:
            name = name.rpartition(".")[0]
        return name

    return {
        module: {module_of(name) for name in imported_names(module, text, is_package=module in inside)}
        - {module}
        for module, text in texts.items()
    }


def layer_offences(module: str, imports: Iterable[str]) -> list[str]:
    part, offences = part_of(module), []
    for other in imports:
        upwards = part in LAYER and other in LAYER and LAYER[other] >= LAYER[part]
        into_instructor = other == "instructor" and part != "cli"
        into_cli = other == "cli" and part != "__main__"
        exercises_see_the_world = part == "exercises" and other in WORLD
        beyond_the_contract = part == "instructor" and other not in CONTRACT
        if upwards or into_instructor or into_cli or exercises_see_the_world or beyond_the_contract:
            offences.append(f"nao_course.{module} imports {other}")
    return offences


def lesson_offences(module: str, names: Iterable[str]) -> list[str]:
    """No lesson's folder imports another's."""
    own = module.split(".")[:2]
    if own[0] != "lessons" or len(own) < 2:
        return []
    others = {".".join(name.split(".")[:2]) for name in names if name.startswith("lessons.")}
    return [f"nao_course.{module} imports {other}" for other in sorted(others - {".".join(own)})]


def test_declarations_import_of_the_grader_only_what_reads_mistakes():
    for path in (PROJECT / "solutions" / "exercises").glob("*.py"):
        names = imported_names("plan", path.read_text(encoding="utf-8"))
        parts = {name for name in names if part_of(name) in ("instructor", "cli", "homework")}
        assert all(name.startswith("instructor.authoring.mistakes") for name in parts), path.name


def test_modules_import_only_what_stands_below_them():
    inside = packages()
    offences = []
    for module, text in sources().items():
        names = imported_names(module, text, is_package=module in inside)
        offences += layer_offences(module, {part_of(name) for name in names} - {part_of(module)})
        offences += lesson_offences(module, names)
    assert offences == []


@pytest.mark.parametrize(
    ("module", "line", "wrong"),
    [
        ("codec.registry", "from nao_course.geometry import Pose", True),
        ("sim.nao", "from ..plotting import field_map", True),
        ("metrics", "def f():\n    from nao_course.datasets import read_g2o", True),
        ("exercises.check", "from nao_course.sim import Field", True),
        ("instructor.reports.html", "from nao_course.plotting import course_style", True),
        ("student", "from nao_course.instructor.sandbox import level", True),
        ("lessons.distance.panels.tilt", "from nao_course import instructor", True),
        ("widgets.panel", "from nao_course import cli", True),
        ("sim.nao", "from .field import Field\nfrom ..geometry import Pose", False),
        ("lessons.distance.panels.tilt", "from nao_course import plotting, widgets", False),
        ("exercises.check", "from nao_course.geometry import wrap_angle\nimport numpy", False),
        ("cli", "from nao_course import instructor", False),
        ("instructor.sandbox.worker", "from nao_course.instructor import sandbox", False),
    ],
)
def test_an_import_upwards_is_found_out_and_one_downwards_is_fine(module, line, wrong):
    assert bool(layer_offences(module, imported_parts(module, line))) == wrong


def test_a_lesson_that_imports_another_is_found_out():
    module = "lessons.distance.figures"
    assert lesson_offences(module, ["lessons.distance.drivers", "plotting.maps"]) == []
    assert lesson_offences(module, ["lessons.goalposts.figures.draw"]) == [
        f"nao_course.{module} imports lessons.goalposts"
    ]
    assert lesson_offences("instructor.build", ["lessons.goalposts"]) == []


def test_the_world_is_imported_without_the_exercises():
    world = ["geometry", "slam", "graphs", "sim", "datasets", "metrics", "plotting"]
    code = f"import sys, {', '.join(f'{PACKAGE}.{part}' for part in world)}; print(*sys.modules)"
    command = [sys.executable, "-c", code]
    loaded = subprocess.run(command, capture_output=True, text=True, check=True, cwd=PROJECT).stdout.split()
    assert f"{PACKAGE}.geometry" in loaded
    assert [name for name in loaded if name.startswith(f"{PACKAGE}.exercises")] == []


def circle_in(graph: Mapping[str, Iterable[str]]) -> list[str]:
    """The modules of a circle, or nothing."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def children_of(package: str, graph: Mapping[str, Iterable[str]]) -> dict[str, set[str]]:
    """What stands directly in a package, folders as one, and what of it each imports."""

    def child(module: str) -> str:
        rest = module.removeprefix(f"{package}.") if package else module
        return rest.split(".")[0] if (rest and rest != module) or not package else ""

    inside: dict[str, set[str]] = {}
    for module, others in graph.items():
        if name := child(module):
            mine = inside.setdefault(name, set())
            mine |= {other for each in others if (other := child(each)) and other != name}
    return inside


def test_no_modules_or_folders_import_each_other_in_a_circle():
    graph = import_graph(sources(), packages())
    assert circle_in(graph) == []
    circles = {package: circle_in(children_of(package, graph)) for package in packages()}
    assert {package: circle for package, circle in circles.items() if circle} == {}


def test_a_circle_is_found_out():
    texts = {
        "": "",
        "a": "",
        "a.one": "def f():\n    from nao_course.a.two import g",
        "a.two": "from nao_course.b import three",
        "b": "",
        "b.three": "from nao_course.a import one",
        "b.four": "",
    }
    graph = import_graph(texts, {"", "a", "b"})
    assert set(circle_in(graph)) == {"a.one", "a.two", "b.three"}
    assert set(circle_in(children_of("", graph))) == {"a", "b"}
    assert circle_in(children_of("a", graph)) == []
    assert children_of("a", graph) == {"one": {"two"}, "two": set()}
    graph["b.three"] = set()
    assert circle_in(graph) == []


def large_and_crowded(lines: Mapping[str, int]) -> list[str]:
    """Name modules of too many lines, and folders of too many modules."""
    folders = Counter(module.rpartition(".")[0] or PACKAGE for module in lines)
    return [
        *(f"{name} has {count} lines" for name, count in lines.items() if count > MOST_LINES),
        *(f"{name} holds {count} modules" for name, count in folders.items() if count > MOST_MODULES),
    ]


@pytest.mark.filterwarnings("default::UserWarning")
def test_large_modules_and_crowded_folders_are_named():
    # A warning, because a limit that fails makes people split what belongs together.
    inside = packages()
    for each in large_and_crowded({k: v.count("\n") for k, v in sources().items() if k not in inside}):
        warnings.warn(f"{each}: does it have more than one subject?", stacklevel=1)
    lines = {f"a.m{number}": 500 for number in range(MOST_MODULES)}
    assert large_and_crowded(lines) == []
    assert large_and_crowded(lines | {"a.n": 501}) == ["a.n has 501 lines", "a holds 12 modules"]


FACING = "geometry slam datasets student homework sim plotting films widgets challenges exercises".split()  # noqa: SIM905


def test_every_package_says_what_is_public():
    modules = [importlib.import_module(f"{PACKAGE}.{name}".rstrip(".")) for name in packages()]
    assert [each.__name__ for each in modules if not isinstance(getattr(each, "__all__", None), list)] == []


@pytest.mark.parametrize("name", FACING)
def test_tab_completion_shows_the_courses_names_and_nothing_else(name):
    module = importlib.import_module(f"{PACKAGE}.{name}")
    assert sorted(dir(module)) == sorted(module.__all__)
    assert [each for each in module.__all__ if not hasattr(module, each)] == []
    own = {
        each
        for each, value in vars(module).items()
        if not each.startswith("_") and getattr(value, "__module__", "") == module.__name__
    }
    assert own - set(module.__all__) == set()


def private_imports(names: Iterable[str]) -> list[str]:
    """Return the names with a private part; `nao_course._internal` itself is open to the whole package."""
    return sorted(
        name
        for name in names
        if any(part.startswith("_") for part in name.removeprefix("_internal.").split("."))
    )


def test_no_module_imports_what_is_private_to_another():
    inside = packages()
    found = {
        module: private_imports(imported_names(module, text, is_package=module in inside))
        for module, text in sources().items()
    }
    assert {module: names for module, names in found.items() if names} == {}
    assert private_imports(["sim.nao._World", "sim.nao.Truth"]) == ["sim.nao._World"]
    assert private_imports(["_internal.time_limits.TooSlow", "_internal.time_limits._Watchdog"]) == [
        "_internal.time_limits._Watchdog"
    ]


def test_a_test_module_stands_where_its_module_stands():
    own = {"attacks", "browser", "real_life", "toy", "versions", "benchmarks", "deploy", "website"}
    folders = {name.replace(".", "/") for name in packages()} | own
    astray = [
        path.relative_to(PROJECT).as_posix()
        for path in sorted((PROJECT / "tests").rglob("test_*.py"))
        if (folder := path.parent.relative_to(PROJECT / "tests").as_posix()) != "." and folder not in folders
    ]
    assert astray == []


CHECKS = sorted((PROJECT / PACKAGE / "exercises" / "checks").glob("*.bin"))


@cache
def exercises() -> set[str]:
    return {exercise.name for path in CHECKS for exercise in read_public(path.stem).exercises}


# What the world and the judging need, the library may hold: wrapping, composing, range and bearing, scoring.
NEEDED_BY_THE_WORLD = {
    *("warp2pi", "predict_pose", "expected_measurement", "ground_to_measurement"),
    *("nees", "nis", "evaluate_landmarks", "detection_cost"),
}
Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def public_definitions(inside: ast.AST) -> Iterator[Definition]:
    """Functions and classes of a module or class that have no underscore first, under `if` and `try` too."""
    waiting = [inside]
    while waiting:
        for node in ast.iter_child_nodes(waiting.pop()):
            if isinstance(node, Definition):
                if not node.name.startswith("_"):
                    yield node
            else:
                waiting.append(node)


def answers_in(source: str) -> list[str]:
    defined = {node.name for node in public_definitions(ast.parse(source))}
    return sorted(defined & (exercises() | entries_of_challenges()) - NEEDED_BY_THE_WORLD)


@cache
def entries_of_challenges() -> frozenset[str]:
    """Return the names of the functions that the lessons enter for their challenges."""
    texts = (path.read_text(encoding="utf-8") for path in sorted((PROJECT / "solutions").glob("*.md")))
    return frozenset(
        name for text in texts for name in re.findall(r'challenge\("\d\d"\)\.enter\((\w+)', text)
    )


def without_docstring(source: str) -> list[str]:
    public = [(node.name, node) for node in public_definitions(ast.parse(source))]
    for name, node in public:
        if isinstance(node, ast.ClassDef):
            public += [(f"{name}.{inner.name}", inner) for inner in public_definitions(node)]
    return sorted(
        name for name, node in public if not ast.get_docstring(node) and not is_told_elsewhere(node)
    )


def is_told_elsewhere(node: Definition) -> bool:
    """Whether it is a property's setter or an overload, whose docstring stands at the first definition."""
    names = {ast.unparse(decorator).split(".")[-1] for decorator in node.decorator_list}
    return bool(names & {"setter", "deleter", "overload"})


def test_the_library_defines_nothing_that_is_an_exercise_or_an_entry_of_a_challenge():
    found = {name: answers_in(source) for name, source in sources().items()}
    assert {name: answers for name, answers in found.items() if answers} == {}


def test_an_answer_in_the_library_is_found_out():
    broken = "if True:\n    def kalman_update(x): ...\nclass EkfSlam: ...\ndef tilt_from_lines(lines): ..."
    fine = "class Panel:\n    def update(self): ...\ndef _fuse(): ...\ndef nees(): ..."
    assert answers_in(broken) == ["EkfSlam", "kalman_update", "tilt_from_lines"]
    assert answers_in(fine) == []


def test_every_public_function_class_and_method_says_what_it_is_for():
    found = {name: without_docstring(source) for name, source in sources().items()}
    assert {name: missing for name, missing in found.items() if missing} == {}
    methods = "    def b(self): ...\n    def _c(self): ...\n"
    source = f'class A:\n    """Yes."""\n{methods}async def d(): ...\n'
    assert without_docstring(source) == ["A.b", "d"]
    assert without_docstring('class A:\n    """Yes."""\n    @b.setter\n    def b(self, b): ...') == []


SECTIONS = re.compile(r"^(Parameters|Returns|Yields|Raises|Attributes)\n-+$", re.MULTILINE)


def sections_of_internals(source: str, exported: Container[str]) -> list[str]:
    """Definitions in whose docstrings, or a method's, sections describe parameters although no package exports them."""
    return [
        node.name
        for node in ast.parse(source).body
        if isinstance(node, Definition) and node.name not in exported
        if any(
            isinstance(each, Definition) and SECTIONS.search(ast.get_docstring(each) or "")
            for each in ast.walk(node)
        )
    ]


def test_only_what_a_package_exports_has_docstrings_with_sections():
    """What no package exports has a sentence: types say the rest, and a sentence keeps shape, unit and frame."""
    texts = sources()
    facades = packages() | {"geometry", "graphs", "homework", "slam"}
    exported = {
        each.value
        for name in facades
        for each in ast.walk(ast.parse(texts[name]))
        if isinstance(each, ast.Constant)
    }
    found = {name: sections_of_internals(source, exported) for name, source in texts.items()}
    assert {name: internals for name, internals in found.items() if internals} == {}
    broken = 'class A:\n    def b(self):\n        """Do.\n\n        Returns\n        -------\n        int\n        """'
    assert sections_of_internals(broken, set()) == ["A"] and sections_of_internals(broken, {"A"}) == []
