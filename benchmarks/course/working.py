"""What an author of the course waits for, in this build and in one before it: the tests, and an edited message.

``python -m benchmarks working`` takes half an hour. Seconds are of a processor, of the process and all that it started,
so that other programs change them little.
"""

import re
from pathlib import Path

from benchmarks import Result
from benchmarks.course.waiting import HOUR, compared, module_seconds

QUICK_TIER = ("-n", "2", "-p", "no:nbval", "-q", "-m", "not slow and not browser")
LESSON = "07_ekf_slam"
BUILD = ("nao_course.cli", "build", LESSON, "--no-execute")  # the older commit knows nothing shorter
MESSAGE = re.compile(r"^( +\S.* => .*\n +)([A-Z])", re.MULTILINE)


def measure(root: Path) -> dict[str, float]:
    """Return the costs of one build."""
    tests = module_seconds(root, "pytest", *QUICK_TIER, seconds=HOUR)
    declaration = root / "solutions" / "exercises" / f"{LESSON}.py"
    text = declaration.read_text(encoding="utf-8")
    edited, count = MESSAGE.subn(r"\1Look: \2", text, count=1)
    if count != 1:
        raise ValueError(f"no message of a mistake is found in {declaration}")
    module_seconds(root, *BUILD, seconds=HOUR, worst=0)
    declaration.write_text(edited, encoding="utf-8")
    message = module_seconds(root, *BUILD, seconds=HOUR, worst=0)
    return {"the quick tier, s": tests, f"an edited message of lesson {LESSON[:2]}, s": message}


def main() -> Result:
    """Measure both builds, one after the other."""
    return compared("working", "What an author waits for", measure, 1)
