"""Read TOML within bounds that are checked before it is parsed: a few bytes can cost a parser seconds and gigabytes.

Python's parser takes time and memory in the square of a dotted key's parts, recurses into nested lists, and makes a number of any
length. So `require_bounded` passes over the text once, by the parser's own rules on strings and comments, and counts. Where the
text is no TOML it may stop counting, because the parser stops there too.
"""

from __future__ import annotations

import re
import tomllib
from decimal import Decimal
from itertools import accumulate, islice
from typing import Any, NoReturn

from stt_codegen.errors import BadInput

DEPTH_LIMIT = 16  # lists and tables in one another; a task needs 5
PARTS_LIMIT = 16  # of a dotted key; a task needs 3
WORD_LIMIT = 1_000  # characters of a number, or of a key without quotes
TABLES_LIMIT = 50_000  # {inline}, and lines that begin with a bracket, as [header] does; an unsafe set is one
KEYS_LIMIT = 200_000  # key = value

# Strings of all four kinds, comments, and a quote without its end with all that follows.
SKIPPED = re.compile(
    r'"""(?:[^"\\]++|\\.|"{1,2}+(?!"))*+"{3,5}'
    r"|'''(?:[^']++|'{1,2}+(?!'))*+'{3,5}"
    r'|"(?!"")(?:[^"\\\n]++|\\[^\n])*+"'
    r"|'(?!'')[^'\n]*+'"
    r"|\#[^\n]*+"
    r"|[\"'].*",
    re.DOTALL,
)
WORD = r"[^][{}\"'\#=,.\s]"
DOTTED = re.compile(rf"(?<!{WORD})(?:{WORD}++[ \t]*+\.[ \t]*+)++")
NO_BRACKETS = re.compile(r"[^][{}]+")
TABLE = re.compile(r"\{|^[ \t]*+\[", re.MULTILINE)
STEPS = {"[": 1, "{": 1, "]": -1, "}": -1}


def parse_toml(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text, with decimals as `Decimal`. Raises `BadInput` where it is no TOML or exceeds a bound."""
    require_bounded(text)
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        last_line = text.count("\n") + 1
        reason = str(error).replace("at end of document", f"at line {last_line}, the end of the file")
        raise BadInput(f"not valid TOML: {reason}") from None
    except (ValueError, ArithmeticError, RecursionError):
        raise BadInput("not valid TOML: a number is too long or the nesting is too deep") from None


def require_bounded(text: str) -> None:
    """Raise `BadInput` with the line where a TOML text exceeds a bound."""
    structure = SKIPPED.sub(_placeholder, text)

    def refuse(position: int, problem: str) -> NoReturn:
        raise BadInput(f"line {structure.count(chr(10), 0, position) + 1}: {problem}")

    if max(map(len, re.split(rf"(?!{WORD}).", structure, flags=re.DOTALL))) > WORD_LIMIT:
        word = re.search(f"{WORD}{{{WORD_LIMIT + 1}}}", structure)
        refuse(word.start() if word else 0, f"has a number or a key of more than {WORD_LIMIT:,} characters")
    for key in DOTTED.finditer(structure):
        if key[0].count(".") >= PARTS_LIMIT:
            refuse(key.start(), f"has a key of more than {PARTS_LIMIT} parts with dots between them")
    for depth in accumulate(map(STEPS.__getitem__, NO_BRACKETS.sub("", structure))):
        if depth > DEPTH_LIMIT:
            refuse(_deepest(structure), f"is nested more than {DEPTH_LIMIT} deep")
    for pattern, limit, noun in ((TABLE, TABLES_LIMIT, "tables"), (re.compile("="), KEYS_LIMIT, "keys")):
        if len(pattern.findall(structure)) > limit:
            refuse(next(islice(pattern.finditer(structure), limit, None)).end(), f"comes after {limit:,} {noun}, the limit")


def _placeholder(match: re.Match[str]) -> str:
    """Return what stands for a string: a word and its line ends. For a comment, and after an error, nothing does."""
    is_string = match[0][0] != "#" and (len(match[0]) > 1 and match[0][0] == match[0][-1])
    return "S" + "\n" * match[0].count("\n") if is_string else ""


def _deepest(structure: str) -> int:
    """Return the position of the first bracket that is nested too deep."""
    depth = 0
    for match in re.finditer(r"[][{}]", structure):
        depth += STEPS[match[0]]
        if depth > DEPTH_LIMIT:
            return match.start()
    return 0
