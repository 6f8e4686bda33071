"""Generation 2 of the Robotarium's Python API (GTernal robots, since 2026: ``debug``)."""
