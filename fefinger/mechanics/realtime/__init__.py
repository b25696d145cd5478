"""Fingers for real-time loops: each call advances them by one time step."""
