"""Records of an answer, their files, and what is computed from them."""
