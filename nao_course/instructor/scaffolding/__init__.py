"""The beginnings of lessons and exercises, for an author to write over."""

__all__: list[str] = ["scaffold"]
