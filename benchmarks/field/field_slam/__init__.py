"""Camera-only SLAM from rendered pictures: every variant on the same drives.

``python -m benchmarks field_slam`` renders the drives once (build/field_slam, 8 s of a core each) and runs all variants
on its detections.
"""

from benchmarks.field.field_slam.report import main

__all__ = ["main"]
