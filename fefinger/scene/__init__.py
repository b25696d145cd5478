"""The scene: which finger, which object, how it moves, and what is asked."""
