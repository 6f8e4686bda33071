"""The utilities of generation 1, by their published names."""
