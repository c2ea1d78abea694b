"""Reports of an assessment: a table, a tornado chart and a page."""
