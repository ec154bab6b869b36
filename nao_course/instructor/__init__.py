"""What an instructor uses: writing lessons, running students' code, grading and reports. No student code imports it."""

__all__ = ["authoring", "autograding", "collecting", "commands", "gradebook", "reports", "sandbox"]
