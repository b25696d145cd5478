"""Contact: obstacles, gaps, complementarity, friction, and its viscoelastic history."""
