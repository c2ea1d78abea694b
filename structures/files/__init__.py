"""Blocks from and to files."""
