"""The remedies that a refusal names, read from its text, and the tasks that follow from them."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from stt_codegen.errors import NotCertified
from stt_codegen.pipeline import build_task
from stt_codegen.task import Task
from stt_codegen.task.task import document_digest, document_of

Remedy = dict[str, Any]  # keys of a task file and their new values; None for a key or an entry that is left out
ASSIGNMENT = r"([a-z_.\[\]0-9]+) = (\[[^\]]*\]|\"[^\"]*\"|[\d.e+-]*\d)"
REFUSALS: dict[str, str] = {}  # messages by the digest of what the task states
LEFT_OUT = r"without ([a-z_]+(?:\.[a-z_]+)?(?:\[\d+\])?)"


def refusal_of(task: Task) -> str:
    """Return the message with which the task is refused; it is worked out once. Raises `AssertionError` for a certified task."""
    digest = document_digest(task.as_stated)
    if digest not in REFUSALS:
        try:
            build_task(task)
        except NotCertified as refusal:
            REFUSALS[digest] = str(refusal)
        else:
            raise AssertionError(f"{task.name} is certified")
    return REFUSALS[digest]


def remedies_of(refusal: str) -> list[Remedy]:
    """Return what each remedy of a refusal changes."""
    _, named, text = refusal.partition("; certified ")
    if not named:
        return []
    remedies = []
    for part in re.split(r", or (?=with )|, or (?=without )", text.partition("; the time was over")[0]):
        remedy = {key: tomllib.loads(f"v = {value}")["v"] for key, value in re.findall(ASSIGNMENT, part)}
        remedies.append(remedy | dict.fromkeys(re.findall(LEFT_OUT, part)))
    return remedies


def with_remedy(task: Task, remedy: Remedy) -> Task:
    """Return the task whose file has the changes of a remedy."""
    document = document_of(task.as_stated)
    for key, value in remedy.items():
        table: Any = document
        names = [int(name) if name.isdigit() else name for name in re.findall(r"[a-z_]+|\d+", key)]
        for name in names[:-1]:
            table = table.setdefault(name, {}) if isinstance(name, str) else table[name]
        if value is None:
            del table[names[-1]]
        else:
            table[names[-1]] = value
    return Task(**document)


def follow_remedies(task: Task) -> list[Remedy]:
    """Return the remedies of a refused task, each of which was followed to a certificate. Raises where one is not true."""
    message = refusal_of(task)
    remedies = remedies_of(message)
    assert remedies, message
    for remedy in remedies:
        assert build_task(with_remedy(task, remedy)).certificate.holds, (remedy, message)
    return remedies
