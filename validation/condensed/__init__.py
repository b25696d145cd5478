"""Suite `condensed`: the condensed finger against the whole mesh."""
