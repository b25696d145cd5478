"""HTML pages: reports and the viewer of fields."""
