"""Files of a run: results, checkpoints, the lock of a folder; and those of friction problems."""
