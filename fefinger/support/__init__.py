"""What every room uses: checks, names, text, files, processes and progress."""
