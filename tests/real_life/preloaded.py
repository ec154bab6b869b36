"""What processes that run notebooks have imported before they are forked: what the lessons' set-up cells import."""

import ast

from nao_course.exercises.cells import source_of
from nao_course.exercises.checking import lessons, read_public
from tests.paths import PROJECT
from tests.real_life import verdicts
from tests.real_life.notebooks import read

verdicts.the_shell()
for lesson in lessons():
    read_public(lesson)
for path in sorted((PROJECT / "solutions").glob("*.ipynb")):
    for cell in read(path)[0]:
        if cell["metadata"].get("nao_course", {}).get("role") == "setup":
            body = [
                each
                for each in ast.parse(source_of(cell)).body
                if isinstance(each, ast.Import | ast.ImportFrom)
            ]
            exec(compile(ast.Module(body, []), "<set-up>", "exec"), {})
