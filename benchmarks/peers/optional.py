"""Imports of packages that only the peers need, when they are first used."""

from __future__ import annotations

import importlib
from typing import Any

from stt_codegen.errors import MissingTool


def need(module: str) -> Any:
    """Import a module of an optional package. Raises `MissingTool`."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise MissingTool(f"{module} cannot be imported ({error}): make peers, or pip install stt-codegen[peers]") from error
