"""Pictures: rendering, the figure around a model, structures and refused blocks."""
