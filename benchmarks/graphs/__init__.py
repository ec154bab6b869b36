"""Graph SLAM: time by size, other solvers, and the EKF on the same drives."""
