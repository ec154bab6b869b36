"""The simulated world: the field, the robot's head and cameras, its pictures, and the robot itself."""
