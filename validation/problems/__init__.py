"""Bodies with known answers that suites, tests and benchmarks share."""
