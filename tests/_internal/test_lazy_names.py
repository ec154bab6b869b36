"""The public names of packages and modules: all exist, and tab completion shows nothing else."""

import importlib
import subprocess
import sys

from tests.paths import PROJECT


def test_tab_completion_shows_the_public_names_and_a_lessons_module_is_imported_only_when_it_is_used():
    for path in sorted((PROJECT / "nao_course").rglob("*.py")):
        if "__dir__ = " in path.read_text(encoding="utf-8"):
            parts = path.relative_to(PROJECT).with_suffix("").parts
            module = importlib.import_module(".".join(parts).removesuffix(".__init__"))
            assert dir(module) == sorted(module.__all__)
            assert all(hasattr(module, name) for name in module.__all__), path
    code = (
        "import sys; from nao_course.lessons.goalposts import match_feet; "
        "print(*(name for name in sys.modules if name.startswith('nao_course.lessons.goalposts.')))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["nao_course.lessons.goalposts.measuring"]
