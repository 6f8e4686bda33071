"""The extended Kalman filter of the published example."""
