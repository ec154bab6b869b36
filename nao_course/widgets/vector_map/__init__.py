"""Maps that the browser draws from numbers: the live map of a panel, and films in a notebook."""

from nao_course.widgets.vector_map.contents import MapContents, ShortAxis
from nao_course.widgets.vector_map.film_panel import VectorFilmPanel, show_film
from nao_course.widgets.vector_map.live import VectorMap

__all__ = ["MapContents", "ShortAxis", "VectorFilmPanel", "VectorMap", "show_film"]
