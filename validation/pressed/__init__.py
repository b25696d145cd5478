"""Suite `pressed`: tabulated finite strain against `solid` on the same mesh."""
