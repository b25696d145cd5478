"""Description of a scene: finger, indenter, motion and requested outputs."""
