"""Suite `waves`: inertia and vibration of the finger."""
