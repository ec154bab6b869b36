"""The course as static pages: ``python -m website`` gathers lessons and docs, and Sphinx makes pages of them."""

from pathlib import Path

__all__ = ["ROOT"]

ROOT = Path(__file__).resolve().parents[1]
