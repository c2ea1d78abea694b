"""Crack maps: joints coloured by what they suffered, cut open, in sequence, with lines of thrust."""
