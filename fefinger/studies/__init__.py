"""The parts of `study`: its grid, tasks and workers, its measures, and its tables and page."""
