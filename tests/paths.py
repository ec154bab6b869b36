"""Where the project is, for tests at any depth of the tree."""

from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
SOLUTIONS = PROJECT / "solutions"
