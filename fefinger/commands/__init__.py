"""The commands of `fefinger`; a command imports what it needs when it runs."""
