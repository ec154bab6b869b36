"""Detectors of lines, posts, corners and colours, and what pictures tell of distance and tilt."""
