"""Read JSON that another program may have written: certificates, manifests, caches."""

from __future__ import annotations

import json
from typing import Any


def parse_json_object(data: bytes | str) -> dict[str, Any]:
    """Return the object that a JSON text is. Raises `ValueError` where it is none, or is nested too deeply to be read."""
    try:
        document = json.loads(data)
    except RecursionError:
        raise ValueError("is nested too deeply") from None
    if not isinstance(document, dict):
        raise ValueError("is no JSON object")
    return document
