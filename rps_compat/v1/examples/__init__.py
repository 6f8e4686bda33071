"""The published examples are scripts, to be run as files: there is no module among them."""
