"""Definitions and statements of proof/ that nothing uses, by their text: what is used stands as a word in what comes after.

A bound variable of the same name hides a dead definition from this; `unreferenced` reads coqc's own index, which knows better.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_']*")
# Hypotheses and variables are left out, for tactics use them unnamed.
DEFINES = re.compile(
    r"^[\s\-+*{}]*(?:(?:Local|Global)\s+)*(Definition|Fixpoint|Inductive|Record|Lemma|Theorem|Corollary|Let|Ltac|Notation)\s+"
    r"([A-Za-z_][A-Za-z0-9_']*)"
)
PLAIN = re.compile(
    r"^\s*(?:Section|End|Variables?|Hypothes[ie]s|Context|From|Require|Open|Set|Declare|Delimit|Arguments|Global|Local)\b"
)
# Names that come with a definition: by `with`, constructors, fields. A use of any is enough, for a record is taken apart by position.
BESIDE = {
    "Fixpoint": re.compile(r"\bwith\s+([A-Za-z_][A-Za-z0-9_']*)\s*[({:]"),
    "Inductive": re.compile(r"(?:\bwith\b|\|)\s*([A-Za-z_][A-Za-z0-9_']*)"),
    "Record": re.compile(r"(?:[{;]|:=)\s*([A-Za-z_][A-Za-z0-9_']*)\s*[:{]"),
}
KINDS = {"prf", "def", "ind", "rec", "constr", "abbrev", "scheme"}  # of coqc's index


@dataclass
class Part:
    """A sentence of a file, with its proof: the names that it defines, what it is called by first, and all words in it."""

    line: int
    names: list[str] = field(default_factory=list)
    words: set[str] = field(default_factory=set)


def without_comments(text: str) -> str:
    """The text with comments, which may be nested, and strings left blank; lines stay."""
    depth, result, in_string = 0, [], False
    for token in re.findall(r'\(\*|\*\)|"|\n|.', text):
        if token == '"':
            in_string = not in_string
        elif not in_string and token in ("(*", "*)"):
            depth += 1 if token == "(*" else -1
        else:
            result.append(token if token == "\n" or not (depth or in_string) else " ")
    return "".join(result)


def parts(text: str) -> Iterator[Part]:
    """The sentences of a file; those of a proof belong to what they prove."""
    part, line = Part(1), 1
    for sentence in re.split(r"(?<=\.)(?=\s)", without_comments(text)):
        head = DEFINES.match(sentence)
        if head or PLAIN.match(sentence):
            yield part
            blank = len(sentence) - len(sentence.lstrip())
            part = Part(line + sentence[:blank].count("\n"))
        if head:
            part.names = [head[2], *(BESIDE[head[1]].findall(sentence) if head[1] in BESIDE else ())]
        part.words |= set(WORD.findall(sentence))
        line += sentence.count("\n")
    yield part


def unused_in(texts: dict[str, str], outside: Iterable[str]) -> list[str]:
    """Names of files, in the order in which they are compiled, that are no word of a later sentence nor of the texts outside."""
    after = {word for text in outside for word in WORD.findall(text)}
    result = []
    for name, text in reversed(texts.items()):
        for part in reversed([*parts(text)]):
            if part.names and not after & set(part.names):
                result.append(f"{name}, line {part.line}: {part.names[0]}")
            after |= part.words - set(part.names)
    return result[::-1]


def unreferenced(compiled: Path, names: Iterable[str]) -> set[str]:
    """Names that coqc's index of the compiled library defines and refers to nowhere."""
    indices = {name: (compiled / f"{name}.glob").read_text() for name in names}
    used = {
        (match[1], match[2])
        for text in indices.values()
        for match in re.finditer(r"^R\d+:\d+ Stt\.(\S+) \S+ (\S+) \S+$", text, re.M)
    }
    defined = {
        (name, match[2])
        for name, text in indices.items()
        for match in re.finditer(r"^(\S+) \d+:\d+ \S+ (\S+)$", text, re.M)
        if match[1] in KINDS
    }
    return {f"{name}.{n}" for name, n in defined - used}
