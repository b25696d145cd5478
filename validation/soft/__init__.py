"""Suite `soft`: soft objects against meshed ones at finite strain."""
