"""Suite `finger`: the finger against theory, and what each assumption costs."""
