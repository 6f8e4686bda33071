"""As in the published package, there is nothing in here: its version is not told."""
