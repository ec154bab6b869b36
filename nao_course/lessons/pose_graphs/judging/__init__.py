"""How answers to lesson 09's exercises are called for, and compared."""

__all__: list[str] = ["comparing", "drivers"]
