"""A light rim around text and marks, so that they can be read on every colour."""

from matplotlib.patheffects import withStroke

HALO = [withStroke(linewidth=2.5, foreground="white", alpha=0.8)]
