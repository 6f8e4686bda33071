"""Safety filters for teams of mobile robots, as small exact quadratic programs."""
