"""The kinds of structure, one file each: from a table of keys to blocks."""
