"""List the tests that mirror the files changed since the main branch: ``python -m tests.changed``."""

import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path

from tests.paths import PROJECT

LAWS = ("tests/test_structure.py", "tests/test_project.py", "tests/test_language.py")


def changed_files() -> list[str]:
    """Return the changed files: edited, new and, if this is another branch or clone, committed since it left."""
    remote = subprocess.run(
        ["git", "rev-parse", "-q", "--verify", "origin/main"], cwd=PROJECT, capture_output=True
    )
    base = "origin/main" if remote.returncode == 0 else "HEAD"
    commands = (
        ["git", "diff", "--name-only", "--merge-base", base],
        ["git", "ls-files", "--others", "--exclude-standard"],
    )
    found = (
        subprocess.run(each, cwd=PROJECT, capture_output=True, text=True, check=True).stdout
        for each in commands
    )
    return "".join(found).splitlines()


def mirrors_of(files: Iterable[str]) -> Iterator[str]:
    """Yield the tests that mirror some files, and the laws of the repository.

    A module is tested by the file of its name or, without one, by the folder of its package; a lesson's source by the
    lesson's folder.
    """
    yield from LAWS
    for path in map(Path, files):
        if path.parts[0] == "tests" and path.name.startswith("test_"):
            candidates = [path]
        elif path.parts[0] in ("nao_course", "benchmarks", "website", "deploy"):
            inside = path.parts[path.parts[0] == "nao_course" :]
            mirror = Path("tests", *inside)
            candidates = [mirror.with_name(f"test_{path.name}"), *mirror.parents]
        elif path.parts[0] == "solutions" and path.stem[:2].isdigit():
            candidates = [Path("tests", "lessons", path.stem.partition("_")[2])]
        else:
            continue
        yield from map(
            str, [each for each in candidates if each != Path("tests") and (PROJECT / each).exists()][:1]
        )


if __name__ == "__main__":
    print("\n".join(dict.fromkeys(mirrors_of(changed_files()))))
