"""Bounds on the files, checked before they are parsed: a few bytes of TOML can cost its parser minutes and gigabytes."""

import re
from pathlib import Path

from .exact import Unusable

TASK_BYTES, SOURCE_BYTES, CERTIFICATE_BYTES, BESIDE_BYTES = 4_000_000, 4_000_000, 16_000_000, 64_000_000
DEPTH, PARTS, WORD = 16, 16, 1000  # of lists in lists, of a key with dots, of a number or key in characters
STRING = re.compile(  # or a comment, or a quote that has no end and what follows it, which the parser refuses
    r"""\"{3}(?:[^"\\]++|\\.|"{1,2}+(?!"))*+"{3,5}|'{3}(?:[^']++|'{1,2}+(?!'))*+'{3,5}"""
    r"""|"(?!"")(?:[^"\\\n]++|\\[^\n])*+"|'(?!'')[^'\n]*+'|\#[^\n]*+|["'].*""", re.DOTALL,
)  # fmt: skip
END = r"[][{}\"'\#=,.\s]"  # of a word
DOTTED = re.compile(rf"(?:(?<={END})|^)(?:(?!{END}).(?:(?!{END}).)*+[ \t]*+\.[ \t]*+)++", re.DOTALL)


def read(path: Path, limit: int) -> bytes:
    """Return the content of a file of at most so many bytes. A pipe or a device is none."""
    if path.exists() and not path.is_file():
        raise Unusable(f"{path} is no file")
    with path.open("rb") as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise Unusable(f"{path} has more than {limit} bytes")
    return data


def require_bounded(text: str) -> None:
    """Refuse a task whose parts outside of strings and comments are longer or deeper than any task's."""
    plain, depth, deepest = STRING.sub(lambda match: "" if match[0][0] == "#" else "S", text), 0, 0
    for bracket in re.sub(r"[^][{}]+", "", plain):
        depth += 1 if bracket in "[{" else -1
        deepest = max(deepest, depth)
    longest = max(map(len, re.split(END, plain)))
    parts = max((key.count(".") + 1 for key in DOTTED.findall(plain)), default=1)
    for size, limit, what in ((deepest, DEPTH, "lists in lists"), (longest, WORD, "a word"), (parts, PARTS, "a dotted key")):
        if size > limit:
            raise Unusable(f"the task has {what} of more than {limit}")
