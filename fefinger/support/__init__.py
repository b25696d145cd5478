"""Shared utilities: input checks, text, files, cache, child processes and progress."""
