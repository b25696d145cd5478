"""From signals at end organs to spikes: drives, end-organ filters, generators and membranes.

Knows no mesh, no finite elements and no scene: it takes arrays.
"""
