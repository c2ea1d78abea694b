"""Geometry of blocks: prisms, cuts, convex parts, overlaps, gaps, soundness."""
