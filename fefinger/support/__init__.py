"""What every room uses: checks, files, messages, names, processes; and the version."""

VERSION = "0.2.0"
