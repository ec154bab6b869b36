"""Lesson 12: particles, two cameras, exploration, the choice of moves."""
