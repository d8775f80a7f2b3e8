"""Finds definitions and statements of proof/ (Coq) that nothing uses, for tests/test_unused.py.

`unused_definitions` reads the text: a used name is a word of a later sentence. A bound variable of the same name hides an unused
definition from it. `unreferenced_names` reads the index that coqc writes, which has no such gap.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_']*")
# Hypotheses and variables are left out, because tactics use them without their names.
DEFINES = re.compile(
    r"^[\s\-+*{}]*(?:(?:Local|Global)\s+)*(Definition|Fixpoint|Inductive|Record|Lemma|Theorem|Corollary|Let|Ltac|Notation)\s+"
    r"([A-Za-z_][A-Za-z0-9_']*)"
)
NO_DEFINITION = re.compile(
    r"^\s*(?:Section|End|Variables?|Hypothes[ie]s|Context|From|Require|Open|Set|Declare|Delimit|Arguments|Global|Local)\b"
)
# Further names that a definition defines: after `with`, constructors, fields. A use of any is enough, because a record is unpacked by position.
FURTHER_NAMES = {
    "Fixpoint": re.compile(r"\bwith\s+([A-Za-z_][A-Za-z0-9_']*)\s*[({:]"),
    "Inductive": re.compile(r"(?:\bwith\b|\|)\s*([A-Za-z_][A-Za-z0-9_']*)"),
    "Record": re.compile(r"(?:[{;]|:=)\s*([A-Za-z_][A-Za-z0-9_']*)\s*[:{]"),
}
KINDS = {"prf", "def", "ind", "rec", "constr", "abbrev", "scheme"}  # of coqc's index


@dataclass
class Sentence:
    """A sentence of a file together with its proof: its line, the names that it defines, its own first, and all its words."""

    line: int
    names: list[str] = field(default_factory=list)
    words: set[str] = field(default_factory=set)


def without_comments(text: str) -> str:
    """Return the text with its comments, which may be nested, and its strings replaced by blanks; line breaks stay."""
    depth, result, in_string = 0, [], False
    for token in re.findall(r'\(\*|\*\)|"|\n|.', text):
        if token == '"':
            in_string = not in_string
        elif not in_string and token in ("(*", "*)"):
            depth += 1 if token == "(*" else -1
        else:
            result.append(token if token == "\n" or not (depth or in_string) else " ")
    return "".join(result)


def sentences(text: str) -> Iterator[Sentence]:
    """Yield the sentences of a file; those of a proof are part of the sentence that they prove."""
    sentence, line = Sentence(1), 1
    for text_of_sentence in re.split(r"(?<=\.)(?=\s)", without_comments(text)):
        head = DEFINES.match(text_of_sentence)
        if head or NO_DEFINITION.match(text_of_sentence):
            yield sentence
            blank = len(text_of_sentence) - len(text_of_sentence.lstrip())
            sentence = Sentence(line + text_of_sentence[:blank].count("\n"))
        if head:
            sentence.names = [head[2], *(FURTHER_NAMES[head[1]].findall(text_of_sentence) if head[1] in FURTHER_NAMES else ())]
        sentence.words |= set(WORD.findall(text_of_sentence))
        line += text_of_sentence.count("\n")
    yield sentence


def unused_definitions(texts: dict[str, str], outside: Iterable[str]) -> list[str]:
    """Return definitions that no later sentence and no outside text uses. texts: by file, in the order of compilation."""
    later_words = {word for text in outside for word in WORD.findall(text)}
    result = []
    for name, text in reversed(texts.items()):
        for sentence in reversed([*sentences(text)]):
            if sentence.names and not later_words & set(sentence.names):
                result.append(f"{name}, line {sentence.line}: {sentence.names[0]}")
            later_words |= sentence.words - set(sentence.names)
    return result[::-1]


def unreferenced_names(compiled: Path, names: Iterable[str]) -> set[str]:
    """Return the names that coqc's index of the compiled library defines and never refers to. names: of its files."""
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
