"""Tests of the laboratory, and other programs' results, to hold the program against: ``masonry-cd validate NAME`` repeats one."""
