"""Notes that several mechanics leave with their answers."""

from fefinger.theory.relaxation import Prony


def normalized(prony: Prony) -> tuple[str, ...]:
    """Return the note that published weights do not add up to 1, if they do not."""
    total = sum(prony.c)
    if abs(total - 1) <= 1e-12:
        return ()
    return (f"Published Prony weights sum to {total:.4g}; normalized as in (2.2).",)
