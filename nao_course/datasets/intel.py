"""The pose graph of the Intel Research Lab, recorded by D. Hähnel; file and licence are from openslam_g2o."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nao_course.datasets.g2o import read_g2o
from nao_course.geometry import FloatArray
from nao_course.graphs import Graph

FILE = Path(__file__).with_suffix(".g2o")


def intel_graph(file: Path | str = FILE) -> tuple[Graph, FloatArray, FloatArray]:
    """Return the graph of a real building, a robot's drive with 943 poses and 1,837 edges.

    Parameters
    ----------
    file : path
        A graph of poses in g2o's format, by default the Intel Research Lab.

    Returns
    -------
    graph : Graph
        Poses and edges.
    stored : ndarray, shape (2829,)
        States as the file has them, m and rad.
    steps : ndarray, shape (942, 3)
        Measured motion from each pose to the next, m and rad, in the frame of the former.

    Raises
    ------
    FileNotFoundError, ValueError
        If there is no such file, or if it contains no graph.
    """
    graph, stored = read_g2o(file)
    follows = np.flatnonzero(graph.edges[:, 1] == graph.edges[:, 0] + 1)
    order = follows[np.argsort(graph.edges[follows, 0], kind="stable")]
    first = order[np.unique(graph.edges[order, 0], return_index=True)[1]]
    return graph, stored, graph.measurements[first]
