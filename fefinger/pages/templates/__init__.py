"""The template and the style sheet of the report."""
