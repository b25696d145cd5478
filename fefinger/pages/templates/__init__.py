"""Templates, style sheet and script of the pages; all templates extend `base.html`."""
