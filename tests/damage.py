"""Damage to the files of cached entries, as of a bad disk."""

from pathlib import Path


def flip(file: Path, *, at: float = 0.5) -> None:
    """Flip one bit of a file, at a part of its length."""
    content = bytearray(file.read_bytes())
    content[int(at * (len(content) - 1))] ^= 0x40
    file.write_bytes(content)
