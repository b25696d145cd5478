"""Suite `extremes`: answers with invariants, or refusals, at the edges of every parameter."""
