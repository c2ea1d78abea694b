"""Elastic modes of companions built on the same blocks."""
