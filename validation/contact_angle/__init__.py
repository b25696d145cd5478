"""The study of contact angle against the asymmetry of the pressure, with its page."""
