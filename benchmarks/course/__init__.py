"""The course's own machinery: grading a class, and panels in a browser."""
