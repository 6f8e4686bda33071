"""The utilities of generation 2, by their published names."""
