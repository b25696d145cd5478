"""Ready-made finger meshes, each with a sidecar that says recipe, versions, hash and quality."""
