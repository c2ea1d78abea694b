"""Masonry bridges: spans, rings, piers, walls and the fill between them."""
