"""Seismic analysis of block masonry by non-smooth contact dynamics (Moreau-Jean)."""

from __future__ import annotations

__version__ = "0.1.0"
