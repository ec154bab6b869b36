"""SLAM on the field from camera pictures: measurements with their covariance, data association, and whole drives.

Each picture becomes an `Observation`: bearings and ranges of corners and posts (`lines`, `observation`), the body
tilt and the heading from the field's lines (`compass`), and the lines and the centre circle (`line_observation`).
`association` assigns measurements to landmarks, and `hypotheses` keeps several associations with their `likelihood`.
`known_shapes.calibration` estimates the constant offset of a real camera. `joint_update` and `surest_first` wrap a SLAM
algorithm, `adaptive_noise` estimates the noise of the odometry, and `kidnapping` finds the pose of a robot that was
carried away, from all pictures of a stop. `drives` and `walk` provide simulated and real pictures.
`demo` runs everything together: the robot drives over the field and maps it (``nao-course demo``).
"""

__all__ = [
    "adaptive_noise",
    "association",
    "compass",
    "demo",
    "drives",
    "hypotheses",
    "joint_update",
    "kidnapping",
    "known_shapes",
    "likelihood",
    "line_observation",
    "lines",
    "observation",
    "surest_first",
    "walk",
]
