"""A finger of finite elements under an object: placement, sites, materials, steps, limits."""
