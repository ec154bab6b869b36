"""Which tests a process of `pytest -n` runs together, and what begins first: no core waits at the end."""

from collections import Counter

from xdist.scheduler import LoadScopeScheduling
from xdist.workermanage import WorkerController

# Tests of one lesson each, of up to minutes, that share nothing: any process may take the next one.
APART = (
    "test_hidden_cases_catch_mutants_of_the_solutions",
    "test_what_is_committed_is_what_the_texts_say",
    "test_building_twice_makes_the_same_bytes",
    "test_nbgrader_makes_validates_and_grades_the_release",
    "test_nbval_finds_the_stored_outputs_again",
    "test_rubric_16_the_blank_student_copy_runs_to_its_end_and_scores_nothing",
    "test_the_three_verdicts_agree_or_the_difference_is_stated",
    "test_copies_of_one_submission_have_one_result",
)
# Those that take longest, each file with what it has prepared once, and then the tests above.
FIRST = (
    "tests/attacks/test_catalogue.py",
    "tests/test_cli.py",
    "tests/attacks/test_accidents.py",
    "tests/instructor/autograding/test_batch.py",
    "tests/instructor/autograding/cluster/test_dispatch.py",
    *APART,
    "tests/test_installed.py",
    "tests/deploy/test_real_hub.py",
    "tests/browser/test_lesson_panels.py",
    "tests/browser/test_panel_keys.py",
    "tests/attacks/test_mutations.py",
    "tests/browser/test_lab.py",
    "tests/instructor/test_docs.py",
    "tests/instructor/autograding/test_grader.py",
)


class LongestFirst(LoadScopeScheduling):
    """A process takes a whole file, whose tests share what is prepared for them, or a test that stands apart."""

    def _split_scope(self, nodeid: str) -> str:
        return unit_of(nodeid)

    def remove_node(self, node: WorkerController) -> str | None:
        """Report the test that ended its process once: xdist would start it again in one process after the other."""
        for unit in self.assigned_work[node].values():
            for nodeid, is_done in unit.items():
                if not is_done:
                    unit[nodeid] = True
                    super().remove_node(node)
                    return nodeid
        return super().remove_node(node)


def unit_of(nodeid: str) -> str:
    """What is run together with a test."""
    file, name = _file_and_name(nodeid)
    return nodeid if name in APART else file


def in_order(nodeids: list[str]) -> list[int]:
    """Places of the tests in the order in which they begin: the longest, then the files of the most tests."""
    sizes = Counter(map(unit_of, nodeids))

    def key(place: int) -> tuple[int, int, str]:
        nodeid = nodeids[place]
        found = [FIRST.index(each) for each in _file_and_name(nodeid) if each in FIRST]
        return min(found, default=len(FIRST)), -sizes[unit_of(nodeid)], unit_of(nodeid)

    return sorted(range(len(nodeids)), key=key)


def _file_and_name(nodeid: str) -> tuple[str, str]:
    file, _, rest = nodeid.partition("::")
    return file, rest.partition("[")[0]
