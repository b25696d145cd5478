"""Contact mechanics in closed form, and exact solutions for layered bodies."""
