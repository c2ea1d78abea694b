"""The Moreau-Jean step: motion, contact rows, impacts, joint laws, islands, energy."""
