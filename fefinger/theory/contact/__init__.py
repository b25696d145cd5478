"""Closed forms and exact layers of contact mechanics."""
