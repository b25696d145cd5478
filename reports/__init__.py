"""What validation and benchmarks last produced: evidence, with command, commit and versions."""
