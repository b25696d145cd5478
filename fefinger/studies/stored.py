"""Records of a study on disk, as JSON with a checksum.

What was damaged or edited is computed again, so that nothing needs to look at its types.
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fefinger.support import atomic_write
from fefinger.support.checks import InputError
from fefinger.support.inputs import read_json


CHECKSUM = "sha256"


def write(path: Path, record: Mapping[str, Any]) -> None:
    """Write a record of plain values into a folder that exists; InputError where it cannot be."""
    text = json.dumps({**record, CHECKSUM: _checksum(record)}, allow_nan=False)
    atomic_write.write(path.parent, {path.name: text})


def read(path: Path) -> dict[str, Any] | None:
    """Read a record; None if it is missing or not as it was written."""
    try:
        record = read_json(path)
    except InputError:
        return None
    if not isinstance(record, dict) or record.pop(CHECKSUM, None) != _checksum(record):
        return None
    return record


def _checksum(record: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(record, sort_keys=True).encode()).hexdigest()
