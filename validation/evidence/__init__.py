"""Scripts that measure the error and the cost of each mechanics: the evidence in reports/."""
