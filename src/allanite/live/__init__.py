"""Live streams: curve and coefficients of a sensor while it records."""
