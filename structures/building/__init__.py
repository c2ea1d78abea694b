"""Buildings from a plan: walls of any direction, their junctions and openings, vaults, columns and arcades."""
