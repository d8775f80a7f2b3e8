"""Outcomes of proofs that ran before with the very same sources and libraries: to be quick, never to be believed instead.

The key is the content of every module of this package and the versions of what proves; one changed byte and all is proved again.
The file may be deleted at any time. Lemmas that were open are never kept.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import tempfile
from importlib.metadata import version
from pathlib import Path

from stt_codegen.lemmas.lemma import Outcome, Verdict

PROVERS = ("sympy", "mpmath", "python-flint", "casadi", "numpy")


def folder() -> Path:
    """Where caches go on this machine (XDG Base Directory Specification)."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "stt_codegen"


def key() -> str:
    """SHA-256 of the package's sources and the provers' versions."""
    root = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(f"{path.relative_to(root)}\0".encode() + path.read_bytes() + b"\0")
    digest.update(f"Python {platform.python_version()}\n".encode())
    digest.update("".join(f"{name} {version(name)}\n" for name in PROVERS).encode())
    return digest.hexdigest()


class Cache:
    """The outcomes by lemma; fresh: nothing is taken from the file, but it is written anew."""

    def __init__(self, fresh: bool) -> None:
        self.path = folder() / "lemmas.json"
        self.key = key()
        self.known: dict[str, Outcome] = {}
        self.changed = False
        if fresh:
            return
        try:
            kept = json.loads(self.path.read_bytes())
            if kept["key"] == self.key:
                self.known = {name: Outcome(Verdict(v), m, tuple(lines)) for name, (v, m, lines) in kept["outcomes"].items()}
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            self.known = {}

    def get(self, name: str) -> Outcome | None:
        return self.known.get(name)

    def put(self, name: str, outcome: Outcome) -> None:
        if outcome.verdict is not Verdict.OPEN and self.known.get(name) != outcome:
            self.known[name] = outcome
            self.changed = True

    def keep(self) -> None:
        """Write the file, whole or not at all; a machine without a place for it does without."""
        if not self.changed:
            return
        outcomes = {name: (o.verdict.value, o.method, o.evidence) for name, o in self.known.items()}
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile("w", dir=self.path.parent, delete=False) as file:
                json.dump({"key": self.key, "outcomes": outcomes}, file)
            os.replace(file.name, self.path)
        except OSError:
            return
