"""Generation 1 of the Robotarium's Python API (the GRITSBot years: ``call_at_scripts_end``)."""
