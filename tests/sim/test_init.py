"""What tab completion shows of the simulator: its public names and its modules."""

import subprocess
import sys
from pkgutil import iter_modules

from nao_course import sim


def test_the_simulators_namespace_holds_its_public_names_and_modules_alone():
    code = "import nao_course.sim as sim; print(*(name for name in dir(sim) if not name.startswith('__')))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    modules = {module.name for module in iter_modules(sim.__path__)}
    assert set(shown.split()) - modules == set(sim.__all__) - modules
    assert set(sim.__all__) <= set(shown.split())
