"""The Robotarium's Python API, both generations, over one headless simulator."""
