"""Dimensions of fields, which are read from TOML files: of three rule books, of a laboratory, or of your own field."""

from nao_course._internal.lazy_names import list_public
from nao_course.sim.fields.dimensions import DIMENSIONS, SHIPPED, FieldDimensions, read_field

__all__ = ["DIMENSIONS", "SHIPPED", "FieldDimensions", "read_field"]
__dir__ = list_public(__name__)
