"""Writing a course: lesson texts and plans into notebooks, their checks, mutants and releases."""
