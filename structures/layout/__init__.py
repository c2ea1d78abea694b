"""How masonry is laid out: profiles of arches, openings, courses, walls in plan."""
