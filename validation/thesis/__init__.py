"""Suite `thesis`: the source document, number by number."""
