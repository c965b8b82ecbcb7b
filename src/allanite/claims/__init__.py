"""What configurations, simulators and data sheets claim, and what follows from it."""
