"""Do the simulator's pictures look like the real ones? The same instruments measure both.

Every instrument takes a picture and its geometry, so that it knows where lines, posts and carpet are. The real
pictures' geometry is fitted (benchmarks/simulator/reality) and then moved, a little, onto the white lines themselves;
the simulator renders the whole field from the same view and pose (`simulated_twin`), and one table compares the two.

``python -m benchmarks realism`` measures all 94 pictures, ``python -m benchmarks.simulator.realism --quick`` some of
them; `compare` is for a script that tunes the renderer.
"""

from benchmarks.simulator.realism.carpet import noise_sd
from benchmarks.simulator.realism.comparison import QUICK, compare, compare_by_set, summarise
from benchmarks.simulator.realism.detector import compare_detector
from benchmarks.simulator.realism.geometry import FIELD, Geometry
from benchmarks.simulator.realism.markings import fringes, line_edges, lines_by_distance
from benchmarks.simulator.realism.measuring import STATISTICS, measure
from benchmarks.simulator.realism.profiles import Picture, line_profiles
from benchmarks.simulator.realism.report import main, quick
from benchmarks.simulator.realism.scenes import RealScene, real_scenes, simulated_twin

__all__ = [
    "FIELD",
    "QUICK",
    "STATISTICS",
    "Geometry",
    "Picture",
    "RealScene",
    "compare",
    "compare_by_set",
    "compare_detector",
    "fringes",
    "line_edges",
    "line_profiles",
    "lines_by_distance",
    "main",
    "measure",
    "noise_sd",
    "quick",
    "real_scenes",
    "simulated_twin",
    "summarise",
]
