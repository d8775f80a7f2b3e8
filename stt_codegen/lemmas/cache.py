"""A file with the outcomes of proofs that ran before, with the very same sources and libraries: it saves time and proves nothing.

`prove_all` of book.py reads and writes it. The key is the content of every module of this package and the versions of the
provers, so one changed byte has everything proved again. The file may be deleted at any time. Open lemmas are never stored.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
from importlib.metadata import version
from pathlib import Path

from stt_codegen.errors import BadInput
from stt_codegen.files import parse_json_object, read_input, write_files
from stt_codegen.lemmas.lemma import Outcome, Verdict

CACHE_SIZE_LIMIT = 16_000_000  # bytes
PROVERS = ("sympy", "mpmath", "python-flint", "casadi", "numpy")


def folder() -> Path:
    """Return the folder for caches on this machine (XDG Base Directory Specification)."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "stt_codegen"


def key() -> str:
    """Return the SHA-256 of the package's sources and the provers' versions."""
    root = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(f"{path.relative_to(root)}\0".encode() + path.read_bytes() + b"\0")
    digest.update(f"Python {platform.python_version()}\n".encode())
    digest.update("".join(f"{name} {version(name)}\n" for name in PROVERS).encode())
    return digest.hexdigest()


class Cache:
    """Outcomes by the name of their lemma. fresh: nothing is read from the file, and `save` overwrites it."""

    def __init__(self, fresh: bool) -> None:
        """Read the file, unless `fresh`; a file that is missing, damaged or of other sources counts as empty."""
        self.path = folder() / "lemmas.json"
        self.key = key()
        self.outcomes: dict[str, Outcome] = {}
        self.is_changed = False
        if fresh:
            return
        try:
            document = parse_json_object(read_input(self.path, CACHE_SIZE_LIMIT, "delete it"))
            if document["key"] == self.key:
                self.outcomes = {
                    name: Outcome(Verdict(verdict), method, tuple(lines))
                    for name, (verdict, method, lines) in document["outcomes"].items()
                }
        except (BadInput, ValueError, KeyError, TypeError, AttributeError):
            self.outcomes = {}

    def get(self, name: str) -> Outcome | None:
        return self.outcomes.get(name)

    def put(self, name: str, outcome: Outcome) -> None:
        if outcome.verdict is not Verdict.OPEN and self.outcomes.get(name) != outcome:
            self.outcomes[name] = outcome
            self.is_changed = True

    def save(self) -> None:
        """Write the file in one step; where the machine does not allow that, there is no cache."""
        if not self.is_changed:
            return
        outcomes = {name: (o.verdict.value, o.method, o.evidence) for name, o in self.outcomes.items()}
        try:
            write_files(self.path.parent, {self.path.name: json.dumps({"key": self.key, "outcomes": outcomes}).encode()})
        except BadInput:
            return
