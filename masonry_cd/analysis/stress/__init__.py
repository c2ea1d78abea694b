"""The stress of blocks and joints: largest values, compared with a strength."""
