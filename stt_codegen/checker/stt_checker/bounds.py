"""Bounds on the files, checked before they are parsed: a few bytes of TOML can cost its parser minutes and gigabytes."""

import re
from pathlib import Path

from .exact import Unusable

TASK_BYTES, SOURCE_BYTES, CERTIFICATE_BYTES, BESIDE_BYTES = 4_000_000, 4_000_000, 16_000_000, 64_000_000
PARTS = 16  # of a key with dots
STRING = re.compile(  # or a comment, or a quote that has no end and what follows it, which the parser refuses
    r"""\"{3}(?:[^"\\]++|\\.|"{1,2}+(?!"))*+"{3,5}|'{3}(?:[^']++|'{1,2}+(?!'))*+'{3,5}"""
    r"""|"(?!"")(?:[^"\\\n]++|\\[^\n])*+"|'(?!'')[^'\n]*+'|\#[^\n]*+|["'].*""", re.DOTALL,
)  # fmt: skip
END = r"[][{}\"'\#=,.\s]"  # of a word
DOTTED = re.compile(rf"(?:(?<={END})|^)(?:(?!{END}).(?:(?!{END}).)*+[ \t]*+\.[ \t]*+)++", re.DOTALL)


def read_bounded(path: Path, limit: int) -> bytes:
    """Return the content of a file of at most so many bytes. A pipe or a device is none."""
    if path.exists() and not path.is_file():
        raise Unusable(f"{path} is no file")
    with path.open("rb") as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise Unusable(f"{path} has more than {limit} bytes")
    return data


def require_bounded(text: str) -> None:
    """Refuse a task with a long dotted key outside of strings and comments: it costs the parser the square of its parts."""
    plain = STRING.sub(lambda match: "" if match[0][0] == "#" else "S", text)
    if any(key.count(".") >= PARTS for key in DOTTED.findall(plain)):
        raise Unusable(f"the task has a dotted key of more than {PARTS} parts")
