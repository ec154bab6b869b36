"""How the functions of lesson 09 are called, and how their answers are compared."""

__all__: list[str] = ["comparing", "drivers"]
