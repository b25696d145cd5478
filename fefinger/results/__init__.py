"""Records of a result, their file formats, and quantities computed from them."""
