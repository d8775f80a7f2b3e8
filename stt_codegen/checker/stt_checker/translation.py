"""The listings as Python, for meaning.py: their functions on fractions, or on ranges with errors."""

import re
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

from .source import chosen_lines

EPS = Fraction(1, 1 << 24)  # terms with eps^2 are the largest for float
EXPRESSIONS = (  # C, and what it is in Python
    (r"\(int32_t\)(\w+)", r"int(\1)"), (r"\(P_real\)(?!NAN)(\w+)", r"Fraction(\1)"), (r"\(P_real\)", ""), ("&&", "and"),
    (r"!(?!=)", "not "), (r"(= |return )(\S+) \? (\S+) : (\S+)", r"\1(\3) if (\2) else (\4)"), (r"(\d+\.\d+)", r"Fraction('\1')"),
    (r"^(?:const )?(?:P_real|P_status|int32_t|uint32_t|bool) (?=\w+ =)|^\*", ""),
)  # fmt: skip


def python_line(line: str) -> str:
    """Return a line of a function as Python. Blocks have the same indentation in both languages."""
    indent, text = re.fullmatch(r"( *)(.*?);?", line).groups()  # type: ignore[union-attr]
    if loop := re.fullmatch(r"for \(int32_t (\w+) = 0; \w+ < (.*); \+\+\w+\) \{", text):
        return f"{indent}for {loop[1]} in range({loop[2]}):"
    if branch := re.fullmatch(r"if \((\w+)\) \{", text):
        return f"{indent}if {branch[1]}:"
    if call := re.fullmatch(r"(P_\w+)\(([^&]*), (&.*)\)", text):
        return f"{indent}{call[3].replace('&', '')} = {call[1]}({call[2]})"
    if re.fullmatch(r"\}|\w+ \w+", text) and not text.startswith("return"):
        return ""
    text = re.sub(r" / ", " // ", text) if text.startswith("const int32_t") else text
    for c, python in EXPRESSIONS:
        text = re.sub(c, python, text)
    return indent + text


def functions(piece: str, options: set[str], known: dict[str, Any]) -> SimpleNamespace:
    """Return the functions of a piece as Python. known: what the C has before them. `$name` is read in known["N"]."""
    text = re.sub(r"/\*.*?\*/", "", "\n".join(chosen_lines(piece, options)), flags=re.DOTALL)
    text = re.sub(r"\$log\b", "log", text)
    text = re.sub(r"\$(\w+?)(?=U?\b)U?", r'N["\1"]', text)
    for head, words, body in re.findall(r"\b(P_\w+)\(([^)]*)\)\n\{\n(.*?)\n\}$", text, re.DOTALL | re.MULTILINE):
        parameters = [re.sub(r"\[.*", "", p.split()[-1]) for p in words.split(",")]
        inputs, outputs = ([p.strip("*") for p in parameters if p.startswith("*") == is_output] for is_output in (False, True))
        lines = [f"def {head}({', '.join(inputs)}):", *map(python_line, body.splitlines())]
        lines += [f"    return {', '.join(outputs)}"] if outputs else []
        exec("\n".join(lines), known)  # of the listings, which are ours
    return SimpleNamespace(**{name.removeprefix("P_"): value for name, value in known.items() if name != "N"})


class Inexact:
    """A value between two numbers, and how far it is off; every operation rounds once."""

    def __init__(self, low: Any, high: Any, error: Any = 0) -> None:
        self.low, self.high, self.error = Fraction(low), Fraction(high), Fraction(error)

    def rounded(self) -> "Inexact":
        return Inexact(self.low, self.high, self.error + (max(abs(self.low), abs(self.high)) + self.error) * EPS)

    def __neg__(self) -> "Inexact":
        return Inexact(-self.high, -self.low, self.error)

    def __add__(self, value: Any) -> "Inexact":
        o = value if isinstance(value, Inexact) else Inexact(value, value)
        return Inexact(self.low + o.low, self.high + o.high, self.error + o.error).rounded()

    def __sub__(self, value: Any) -> "Inexact":
        return self + -(value if isinstance(value, Inexact) else Inexact(value, value))

    def __mul__(self, value: Any) -> "Inexact":
        o = value if isinstance(value, Inexact) else Inexact(value, value)
        ends = [v * w for v in (self.low, self.high) for w in (o.low, o.high)]
        lowest = max(min(ends), Fraction(0)) if self is o else min(ends)  # a square is not negative
        sizes = [max(abs(v.low), abs(v.high)) for v in (self, o)]
        return Inexact(lowest, max(ends), sizes[0] * o.error + sizes[1] * self.error + self.error * o.error).rounded()

    def __rsub__(self, value: Any) -> "Inexact":
        return Inexact(value, value) - self

    __radd__, __rmul__ = __add__, __mul__
