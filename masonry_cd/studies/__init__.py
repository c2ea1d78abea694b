"""Many runs of one scene: error against run time, seeds, vibration sweeps."""
