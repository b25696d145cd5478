"""The pressure array of the source document, and the fit of its theory to such data."""
