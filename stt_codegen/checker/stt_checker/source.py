"""The C files: that they are the listings, filled with the numbers of the task and of the certificate.

A listing (listing_*.c) is the C of a controller with names for what depends on the task. `fill` writes it out for one task, and
`compare` holds a file against that, token by token. What is not in the listing is refused, even where it would mean the same.
"""

import pkgutil
import re
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any

from .exact import Refused, require, require_in_range, rounded

LISTINGS = ("listing_controller.c", "listing_order2.c", "listing_files.c", "listing_integers.c")
REAL = re.compile(r"\d+\.\d+(e-?\d{1,3})?")
TOKEN = re.compile(
    r"(?P<skip>[ \n]+|/\*.*?\*/)|(?P<line>#[^\n]*)|\$\d+(?:/\d+)?|(?:\d+\.\d+(?:e-?\d{1,3})?F?|0x[0-9a-f]+U|\d+U?)(?!\w)"
    r"|[A-Za-z_]\w*|\"[^\"\n]*\"|<<=|>>=|<=|>=|<<|>>|!=|==|&&|\+\+|--|\+=|&=|[-+*/<>=!?:;,(){}\[\]&]", re.DOTALL | re.ASCII,
)  # fmt: skip


def tokens(text: str) -> list[str]:
    """Return the tokens of C without its comments; of a directive its words, and the end of its line."""
    return [word for word, _ in numbered_tokens(text)]


def numbered_tokens(text: str) -> list[tuple[str, int]]:
    """Return the tokens, each with the number of its line."""
    require("\r" not in text, "a C file has carriage returns; something has changed its line ends")
    is_plain = re.fullmatch(r"[\n -~]*", text) is not None and "\\" not in text and "??" not in text
    require(is_plain, "a C file has a character that no controller has: a tab, a backslash, ?? or one beyond ASCII")
    words, at, number = list[tuple[str, int]](), 0, 1
    while at < len(text):
        match = TOKEN.match(text, at)
        if match is None:
            raise Refused(f"a C file has {text[at : at + 20].splitlines()[0]!r}, which no controller has")
        at = match.end()
        require(match.group() != "/" or text[at : at + 1] != "/", "a C file has a comment by //")
        if match["line"]:
            require(not text[: match.start()].rpartition("\n")[2].strip(" "), "a C file has a directive within a line")
            line = re.sub(r"/\*[^*]*\*/", " ", match["line"])
            require("/*" not in line and "//" not in line, f"a C file has the line {line!r}")
            words += [(word, number) for word in [*line.split(), "\n"]]
        elif match["skip"] is None:
            words.append((match.group(), number))
        number += match.group().count("\n")
    return words


@cache
def pieces() -> dict[str, list[str]]:
    """Return the pieces of all listings by their headings, as lines. What stands before the first heading is about the file."""
    by_name = dict[str, list[str]]()
    for file in LISTINGS:
        name = ""
        for line in (pkgutil.get_data(__package__, file) or b"").decode().splitlines():
            if line.startswith("== "):
                name = line[3:]
                require(name not in by_name, f"two pieces of the listings are called {name!r}")
                by_name[name] = []
            elif name:
                by_name[name].append(line)
    return by_name


def chosen_lines(name: str, options: set[str], closed: Sequence[int] = ()) -> list[str]:
    """Return the lines of a piece that a task with these options has. A line that ends with `  [words]` is there if all the words
    are options. A line `<<heading>>` stands for another piece; with `[each closed axis]` it stands there once for every axis that
    closes, and the names after $ in that piece get the axis's number."""
    lines = []
    for line in pieces()[name]:
        text, _, condition = line.removesuffix("]").partition("  [") if line.endswith("]") else (line, "", "")
        inner = re.fullmatch(r" *<<(.+)>>", text)
        if inner and condition == "each closed axis":
            lines += [re.sub(r"\$(\w+)", rf"$\1_{i}", part) for i in closed for part in chosen_lines(inner[1], options)]
        elif not condition or {*condition.split(", ")} <= options:
            lines += chosen_lines(inner[1], options, closed) if inner else [text]
    return lines


def spelled(value: Fraction) -> str:
    """Return a number as `fill` writes it: $3/4, or (-$3/4)."""
    require_in_range(value)
    return f"(-${-value})" if value < 0 else f"${value}"


def fill(name: str, options: set[str], task_name: str, values: dict[str, Any]) -> list[str]:
    """Return the tokens that a file must have. A name after $ is replaced by its value: a word, a whole number, a fraction, or a
    table of these. The token $3/4 stands for any literal that the compiler rounds to what it rounds 3/4 to."""

    def value_of(match: re.Match[str]) -> str:
        value = values[match[1]]
        if isinstance(value, list):  # in a table a negative number has no brackets
            return ", ".join((spelled(v) if isinstance(v, Fraction) else str(v)).strip("()") for v in value)
        return spelled(value) if isinstance(value, Fraction) else str(value)

    text = "\n".join(chosen_lines(name, options, values.get("closed", ())))
    text = re.sub(r"\bP(?=[_.])|\bM(?=_)", lambda match: task_name if match[0] == "P" else task_name.upper(), text)
    return tokens(re.sub(r"\$([a-z]\w*?)(?=U?\b)", value_of, text))


def is_same(token: str, wanted: str, is_single: bool, bits: int) -> bool:
    """Return whether a token is the wanted one, or a literal with the wanted value once it is rounded to the scalar."""
    if wanted[0] != "$" and not REAL.fullmatch(wanted):
        return token == wanted
    literal = token.removesuffix("F") if is_single else token
    is_literal = REAL.fullmatch(literal) is not None and token.endswith("F") == is_single
    return is_literal and rounded(Fraction(literal), bits) == Fraction(wanted.removeprefix("$"))


def compare(file: str, data: bytes, wanted: list[str], is_single: bool, bits: int) -> None:
    """Require that a C file has exactly these tokens."""
    end = "the end"  # no token, so that a longer or a shorter file differs there
    file_tokens = [*numbered_tokens(data.decode("ascii", "replace")), (end, data.count(b"\n"))]
    for (token, line), expected in zip(file_tokens, [*wanted, end], strict=False):
        if not is_same(token, expected, is_single, bits):
            shown = f"{float(Fraction(expected[1:])):.9g}" if expected[0] == "$" else repr(expected)
            raise Refused(f"{file} has {token[:60]!r} in line {line} where the listing has {shown}")


def table_words(data: bytes, name: str) -> list[str]:
    """Return the entries of the C's table with that name; that it stands in its place is seen when the file is compared."""
    words = tokens(data.decode("ascii", "replace"))
    require(name in words, f"the C has no table {name}")
    begin = words.index(name)
    require("{" in words[begin:] and "}" in words[begin:], f"the C's table {name} has no end")
    return "".join(words[words.index("{", begin) + 1 : words.index("}", begin)]).split(",")


def real_table(data: bytes, name: str, bits: int) -> list[Fraction]:
    """Return a table of real numbers as the compiler rounds them."""
    words = table_words(data, name)
    require(all(REAL.fullmatch(v.strip("-F")) for v in words), f"the C's table {name} has an entry that is no number")
    return [rounded(Fraction(v.rstrip("F")), bits) for v in words]


def integer_table(data: bytes, name: str, bits: int) -> list[int]:
    """Return a table of integers with so many bits; those with fewer than 32 have no sign."""
    words = table_words(data, name)
    require(all(re.fullmatch(r"-?(0|[1-9]\d{0,9})", v) for v in words), f"the C's table {name} has an entry that is no integer")
    low, high = (0, 1 << bits) if bits < 32 else (-(1 << 31), 1 << 31)
    require(all(low <= int(v) < high for v in words), f"the C's table {name} has an integer that its type does not hold")
    return [int(v) for v in words]


def entry_bits(entries: list[int]) -> int:
    """Return the bits of the type of a table of integers: 8 or 16 where all entries fit that without a sign, else 32."""
    return next((bits for bits in (8, 16) if all(0 <= v < 1 << bits for v in entries)), 32)
