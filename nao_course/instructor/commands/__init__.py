"""What the instructor's commands do: a module for each kind, under the command line."""

__all__: list[str] = ["classes", "decisions", "exporting", "grading", "marking", "students"]
