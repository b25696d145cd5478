"""Texts in Braille, letter by letter: the dots of every cell.

Dots are counted down the left column, then down the right one. The table is that of the letters of
Louis Braille, shared by the languages with Latin letters; figures follow the number sign.
"""

from collections.abc import Iterator

from fefinger.support.checks import InputError


FIRST = "1 12 14 145 15 124 1245 125 24 245".split()
"""Dots of a to j, which are also the figures 1 to 9 and 0."""

LETTERS = {
    **dict(zip("abcdefghij", FIRST, strict=True)),
    **dict(zip("klmnopqrst", (f"{dots}3" for dots in FIRST), strict=True)),
    **dict(zip("uvxyz", (f"{dots}36" for dots in FIRST[:5]), strict=True)),
    "w": "2456",
}
SIGNS = {" ": "", ",": "2", ".": "256", "?": "236", "!": "235", "-": "36"}
NUMBER, LETTER = "3456", "56"
FIGURES = dict(zip("1234567890", FIRST, strict=True))


def cells(text: str) -> Iterator[tuple[int, ...]]:
    """Yield the dots of every cell of a text, from 0.

    Raises
    ------
    InputError
        For a character that the table lacks.
    """
    in_number = False
    for character in text.lower():
        if character in FIGURES:
            if not in_number:
                yield _dots(NUMBER)
            in_number = True
            yield _dots(FIGURES[character])
            continue
        if in_number and character in LETTERS:
            yield _dots(LETTER)
        in_number = False
        if character not in LETTERS and character not in SIGNS:
            signs = " ".join(sign for sign in SIGNS if sign.strip())
            raise InputError(
                f"indenter.text: expected letters a to z, figures, blanks and {signs}, received "
                f"{character!r}"
            )
        yield _dots(LETTERS.get(character, SIGNS.get(character, "")))


def _dots(digits: str) -> tuple[int, ...]:
    return tuple(sorted(int(digit) - 1 for digit in digits))
