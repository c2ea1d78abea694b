"""What is constant during a run, and the state: blocks, materials, positions and velocities."""
