"""Camera-only SLAM from rendered pictures: every way of it on the same drives.

``python -m benchmarks field_slam`` renders the drives once (build/field_slam, 8 s of a core each) and runs all ways on
what was seen.
"""

from benchmarks.field.field_slam.report import main

__all__ = ["main"]
