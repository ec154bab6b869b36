"""Dimensions of fields, which are read from TOML files: of three rule books, of a laboratory, or of your own field."""

from nao_course.sim.fields.dimensions import DIMENSIONS, SHIPPED, FieldDimensions, read_field

__all__ = ["DIMENSIONS", "SHIPPED", "FieldDimensions", "read_field"]


def __dir__() -> list[str]:
    """Return the public names for tab completion, without the modules they come from."""
    return __all__
