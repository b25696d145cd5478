"""Suite `fem`: finite elements against closed forms, exact layers and other programs."""
