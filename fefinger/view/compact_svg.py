"""Rewrites the SVG text of matplotlib in fewer characters, with the same picture.

Coordinates have two decimals, which are 0.01 pt. Paths are relative, repeated styles become
classes, and what a browser does not need (metadata, names of groups) is left out. The SVG embeds
in a page: its links have no namespace, which only viewers of SVG 2 read.
"""

import re
from collections import Counter
from collections.abc import Iterator
from itertools import count, product
from string import ascii_letters
from xml.etree.ElementTree import Element, fromstring, tostring


SVG = "http://www.w3.org/2000/svg"
LINK = r"(^|url\()#([^)]+)"
DECIMALS = 2
LENGTHS = ("x", "y", "width", "height", "x1", "x2", "y1", "y2", "cx", "cy", "r")
PAIRS = {"M": 1, "L": 1, "Q": 2, "C": 3, "Z": 0}
"""Points that a command of matplotlib's paths takes; all are absolute."""


def compact(text: str) -> str:
    """Return the SVG text of a matplotlib figure without its invisible parts."""
    root = fromstring(text)
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
        # Text that only indents; a no-break space stays.
        element.text = (element.text or "").strip(" \n\t") and element.text
        element.tail = (element.tail or "").strip(" \n\t") and element.tail
    for child in root.findall("metadata"):
        root.remove(child)
    _rename_links(root)
    _merge_groups(root)
    for element in root.iter():
        _round(element)
    _share_styles(root)
    root.set("xmlns", SVG)
    written = tostring(root, "unicode").replace(" />", "/>").replace("'", "&apos;")
    return re.sub(r"<[^>]*>", lambda tag: tag[0].replace('"', "'"), written)


def _rename_links(root: Element) -> None:
    """Give elements that are referred to short ids, drop all other ids, and shorten links."""
    elements = list(root.iter())
    for element in elements:
        for key in [key for key in element.attrib if key.endswith("}href")]:
            element.set("href", element.attrib.pop(key))
    values = [value for element in elements for value in element.attrib.values()]
    targets = {link for value in values for _, link in re.findall(LINK, value)}
    ids = [element.get("id", "") for element in elements]
    short = dict(zip((i for i in ids if i in targets), _short_names(), strict=False))
    for element in elements:
        name = element.attrib.pop("id", "")
        if name in short:
            element.set("id", short[name])
        for key in ("href", "clip-path", "style", "fill"):
            if "#" in (value := element.get(key, "")):
                linked = re.sub(LINK, lambda m: f"{m[1]}#{short.get(m[2], m[2])}", value)
                element.set(key, linked)


def _short_names() -> Iterator[str]:
    """Give a, b, ..., aa, ab, ... without end."""
    for length in count(1):
        for letters in product(ascii_letters, repeat=length):
            yield "".join(letters)


def _merge_groups(parent: Element) -> None:
    """Join neighboring groups of one clip path; drop empty groups and unwrap bare ones."""
    merged: list[Element] = []
    for child in parent:
        _merge_groups(child)
        bare = child.tag == "g" and not child.attrib
        for each in child if bare else [child]:
            last, clipped = merged[-1] if merged else None, set(each.attrib) == {"clip-path"}
            alike = last is not None and last.tag == each.tag == "g"
            if last is not None and alike and clipped and last.attrib == each.attrib:
                last.extend(each)
            else:
                merged.append(each)
    parent[:] = merged


def _round(element: Element) -> None:
    """Round the coordinates of an element, and squeeze its path, style and transform."""
    # The size and the viewBox of the figure itself stay exact: they set its place in the page.
    if element.tag != "svg":
        for key in LENGTHS:
            if key in element.attrib:
                element.set(key, _rounded(element.attrib[key]))
    if "d" in element.attrib:
        element.set("d", path(element.attrib["d"]))
    if "style" in element.attrib:
        style = re.sub(r"\s*([:;,])\s*", r"\1", element.attrib["style"].replace("'", "")).strip(";")
        element.set("style", re.sub(r"\d+\.\d{4,}", lambda match: f"{float(match[0]):.3f}", style))
    if "transform" in element.attrib:
        element.set("transform", _transform(element.attrib["transform"]))
        if not element.attrib["transform"]:
            del element.attrib["transform"]


def _transform(text: str) -> str:
    """Return a transform with rounded shifts and turns; scales keep their digits."""
    rounded = re.sub(
        r"(translate|rotate)\(([^)]*)\)",
        lambda match: f"{match[1]}({' '.join(map(_rounded, re.split('[ ,]+', match[2].strip())))})",
        text,
    )
    return re.sub(r"rotate\(0 [^)]*\)", "", rounded).strip()


def _rounded(text: str) -> str:
    """Return a number with DECIMALS; other texts (percentages) as they are."""
    try:
        return _number(round(float(text), DECIMALS))
    except ValueError:
        return text


def _number(value: float) -> str:
    """Return a rounded number without redundant zeros."""
    text = f"{value:.{DECIMALS}f}".rstrip("0").rstrip(".")
    text = re.sub(r"^(-?)0\.", r"\1.", text)
    return "0" if text in ("", "-", "-0") else text


def path(data: str) -> str:
    """Return path data (absolute M, L, Q, C, Z) as relative data with rounded coordinates.

    Points are rounded before their differences are taken, so that errors do not add up.
    """
    written: list[str] = []
    last, here, start = "", (0, 0), (0, 0)
    for command, points in _commands(data):
        if command == last == "L" and points[0] == here:
            continue
        implied = (command == last and command in "LQC") or (last + command == "ML")
        shifts = [new - old for point in points for new, old in zip(point, here, strict=True)]
        written.append(_joined("" if implied else command.lower(), shifts))
        start = points[0] if command == "M" else start
        here, last = points[-1] if points else start, command
    return "".join(written)


def _commands(data: str) -> Iterator[tuple[str, list[tuple[int, int]]]]:
    """Give the commands of path data with their points in whole units of the last decimal."""
    tokens = re.findall(r"[A-Za-z]|[-+.\d][-+.\deE]*", data)
    position = 0
    while position < len(tokens):
        command = tokens[position].upper()
        end = position + 1 + 2 * PAIRS[command]
        units = [round(10**DECIMALS * float(token)) for token in tokens[position + 1 : end]]
        yield command, list(zip(units[::2], units[1::2], strict=True))
        position = end


def _joined(letter: str, units: list[int]) -> str:
    """Return a command in few characters: a minus sign separates as a space does."""
    numbers = [_number(unit / 10**DECIMALS) for unit in units]
    text = "".join(number if number.startswith("-") else f" {number}" for number in numbers)
    return letter + text.lstrip() if letter else text


def _share_styles(root: Element) -> None:
    """Turn every style that is there more than once into a class of the style sheet."""
    counts = Counter(each.attrib["style"] for each in root.iter() if "style" in each.attrib)
    repeated = [style for style, count in counts.most_common() if count > 1]
    classes = dict(zip(repeated, _short_names(), strict=False))
    for element in root.iter():
        if element.get("style", "") in classes:
            element.set("class", classes[element.attrib.pop("style")])
    sheet = root.find(".//style")
    if sheet is not None:
        rules = "".join(f".{name}{{{style}}}" for style, name in classes.items())
        sheet.text = re.sub(r"\s*([:;{}])\s*", r"\1", sheet.text or "") + rules
