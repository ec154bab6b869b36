"""SLAM on the field: association, compass, whole drives, a real robot's walk."""
