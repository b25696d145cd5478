"""Suite `tradeoff`: stated errors and the planner's picks, against held-out runs."""
