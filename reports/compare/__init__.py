"""Runs compared side by side."""
