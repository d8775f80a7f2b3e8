"""Change each token of shipped C, and each claim of a certificate, one at a time: the stand-alone checker must refuse.

    python -m benchmarks token_mutants [--every 1] [--task trolley --task omni_board] [--processes 2]

A changed file gets new hashes, so that the checker must read the change to refuse it. A change may be accepted if it has the same
meaning: a literal of the same value, or in a controller in integers a row of the curves that keeps the law within its error
bound.
A changed claim may be accepted if it is true: a smaller margin, a larger error, another normal. Such changes are listed with the
reason. The exit code is 1 where another is accepted.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import io
import json
import multiprocessing
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial
from itertools import islice
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from stt_codegen.checker import check_files
from stt_codegen.program.number import round_to

ROOT = Path(__file__).parent.parent
TOKEN = re.compile(
    r"/\*.*?\*/|\d+\.\d+(?:e-?\d+)?F?|0x[0-9a-f]+U|\d+U?|[A-Za-z_]\w*|\"[^\"\n]*\"|<<=|>>=|<=|>=|==|!=|&&|<<|>>|\+\+|--|\+=|&="
    r"|[^\s\w]",
    re.DOTALL,
)
# Recorded controllers by task and scalar; together they have every kind of listing that is recorded.
SCALARS = {
    "trolley": "float", "omni_board": "float", "drone": "float", "watchman": "float", "attitude": "double", "crawler": "double",
    "courier": "float", "omni_s1": "float", "gantry": "fixed", "crane": "fixed",
}  # fmt: skip
PUNCTUATION = ("+", "-", "*", "/", "<", "<=", ">", "&&", "!", "==", "?", ":", ",", ";")
KNOWN_WORDS = (
    "int32_t",
    "uint32_t",
    "bool",
    "float",
    "double",
    "static",
    "inline",
    "const",
    "void",
    "true",
    "false",
    "return",
    "logf",
    "NAN",
)


@dataclass(frozen=True)
class TokenMutant:
    """A token of a file, its replacement, and the line of the file. position: in characters."""

    file: str
    position: int
    token: str
    replacement: str
    line: str


@cache
def shipped_files(task: str) -> dict[str, bytes]:
    """Return the recorded files of a refined controller, by name."""
    folder = ROOT / "generated" / task / "refined" / SCALARS[task]
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def token_mutants(task: str, step: int = 1) -> Iterator[TokenMutant]:
    """Yield a mutant for every `step`-th token of C and header, comments apart.

    The replacement is another number, another name of the file, another punctuation mark, or nothing.
    """
    for name, data in shipped_files(task).items():
        if name not in (f"{task}.c", f"{task}.h"):
            continue
        text = data.decode()
        matches = [m for m in TOKEN.finditer(text) if not m.group().startswith("/*")]
        names = sorted({m.group() for m in matches if re.match(r"[A-Za-z_]", m.group())} | set(KNOWN_WORDS))
        for k, match in enumerate(matches):
            if k % step == 0:
                replacement = replacement_token(match.group(), names, Random(f"{name} {k}"))
                line = text[text.rfind("\n", 0, match.start()) + 1 : text.find("\n", match.end())].strip()
                yield TokenMutant(name, match.start(), match.group(), replacement, line)


def replacement_token(token: str, names: list[str], rng: Random) -> str:
    """Draw what replaces a token."""
    if rng.random() < 0.1:
        return ""
    if token[0] == '"':
        return '"other"'
    if re.match(r"\d", token):
        return rng.choice((replacement_number(token, rng), replacement_number(token, rng), rng.choice(names)))
    if re.match(r"[A-Za-z_]", token):
        return rng.choice([v for v in names if v != token])
    return rng.choice([v for v in PUNCTUATION if v != token])


def replacement_number(token: str, rng: Random) -> str:
    """Draw another number of the same kind: a digit is changed or, of an integer, the value is near or about twice as large."""
    if "." in token or token.startswith("0x"):
        digits = [m.start() for m in re.finditer(r"\d", token) if m.start() != 1 or not token.startswith("0x")]
        k = rng.choice(digits)
        return token[:k] + str((int(token[k]) + rng.randrange(1, 10)) % 10) + token[k + 1 :]
    value, unsigned = int(token.rstrip("U")), "U" if token.endswith("U") else ""
    return rng.choice((f"{value + 1}{unsigned}", f"{max(value - 1, 0) if value else 2}{unsigned}", f"{2 * value + 1}{unsigned}"))


def changed_files(mutant: TokenMutant, task: str) -> dict[str, bytes]:
    """Return the shipped files with the change, and with its hash in the certificate."""
    files = dict(shipped_files(task))
    text, position = files[mutant.file].decode(), mutant.position
    files[mutant.file] = (text[:position] + mutant.replacement + text[position + len(mutant.token) :]).encode()
    proof = f"{task}.certificate.json"
    document = json.loads(files[proof])
    document["sha256"][mutant.file] = hashlib.sha256(files[mutant.file]).hexdigest()
    files[proof] = json.dumps(document).encode()
    return files


def is_accepted(files: dict[str, bytes], task: str) -> bool:
    """Return whether the checker verifies the files. An exception that it does not catch is raised."""
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
    ):
        for name, data in files.items():
            Path(folder, name).write_bytes(data)
        paths = [str(Path(folder, f"{task}.{end}")) for end in ("c", "certificate.json")]
        return check_files([str(ROOT / "tasks" / f"{task}.toml"), *paths]) == 0


def judge_mutant(mutant: TokenMutant, task: str) -> tuple[TokenMutant, bool]:
    return mutant, is_accepted(changed_files(mutant, task), task)


def reason_for_same_meaning(mutant: TokenMutant, task: str) -> str:
    """Return why a mutant has the same meaning as the shipped file; an empty text where it has another."""
    if is_accurate_curve_row(mutant, task):
        return "a row of the curves that is within its error bound"
    scalar = SCALARS[task]
    literal = re.compile(r"\d+\.\d+(?:e-?\d+)?" + ("F" if scalar == "float" else ""))
    if scalar != "fixed" and literal.fullmatch(mutant.token) and literal.fullmatch(mutant.replacement):
        before, after = (round_to(Fraction(v.removesuffix("F")), scalar) for v in (mutant.token, mutant.replacement))
        return f"a literal of the same {scalar}" if before == after else ""
    return ""


def is_accurate_curve_row(mutant: TokenMutant, task: str) -> bool:
    """Return whether the mutant changes a table of the curves of a controller in integers, and they are still accurate.

    The curves are 1/d and H of the law. Each must be within 2^-11 of its exact value, relatively, since the law's error may be
    2^-10.
    """
    text = changed_files(mutant, task)[mutant.file].decode()
    tables = {
        name: list(map(int, body.split(",")))
        for name, body in re.findall(r"const uint\d+_t \w+_(levels|slopes|bends|h_shifts)\[\d+\] \w+ = \{([\d,\s]*)\}", text)
    }
    if len(tables) < 4 or not re.fullmatch(r"\d+", mutant.token + mutant.replacement) or not re.fullmatch(r"\d+,?", mutant.line):
        return False
    t = np.arange(1 << 16)
    level, slope, bend, shifts = (np.array(tables[name])[:, None] for name in ("levels", "slopes", "bends", "h_shifts"))
    value = level - ((slope - (bend * t >> 16)) * t >> 17)
    row, position = np.arange(len(level))[:, None], (t + 0.5) / (1 << 16)  # position: in the row, from 0 to 1
    reciprocal = 2.0**16 / (1 + (row[:16] + position) / 16)
    e = 1 - (8 + (row[16:] - 16) % 8 + position) / 2.0 ** (4 + (row[16:] - 16) // 8)
    h = 8 * np.arctanh(e) / (e * (1 - e * e)) * 2.0 ** (shifts[16] - shifts[16:])
    exact = np.concatenate([reciprocal, h * 2.0 ** np.round(np.log2(level[16] / h[0, 0]))])
    return bool((value >= 0).all() and (value < 1 << 16).all() and (np.abs(value / exact - 1) < 2.0**-11).all())


# ------------------------------------------------------------------------------------------------ claims

# Changed claims that may be true: by the path of the number in the certificate, which changes, and why. A change is up, down, or
# a step: one unit up or down, or down by less than a claim of seconds or metres is rounded up.
TRUE_CLAIMS = {
    r"sampled\.rho\.\d+": ("up down", "another bound on |e|, which is proved, too"),
    r"sampled\.(shift|u)\.\d+": (
        "up step",
        "a larger error or input, which the proof allows, too, or the same before it is rounded up",
    ),
    r"(edge|rate)_error\.\d+": ("up", "a larger error, which the proof allows, too"),
    r"claims\.\d+ P\d\.margin": ("down", "a smaller margin, which holds, too"),
    r"claims\.\d+ P10\.(margin|on\.[01])": (
        "step",
        "the part of a mission, for another time or with another margin, from which it follows",
    ),
    r"claims\.\d+ P\d+\.hints\.\d+\.2\.\d+": ("up down", "another separating normal"),
    r"claims\.\d+ P\d+\.hints\.\d+\.3\.\d+": ("up down", "another multiplier of a half-space"),
    r"claims\.\d+ P[135]\.hints\.\d+\.[01]": ("up down", "another place to cut the tube at"),
    r"sampled\.path\.\d+\.nearest": ("down", "a smaller distance to an edge, which holds, too"),
    r"sampled\.path\.\d+\.history": ("up", "bounds over a longer time, from which it follows, too"),
    r"mission\.time_margin": ("up step", "a larger allowance for the clock, with which the mission follows, too"),
}
TRUE_CLAIMS_OF_INTEGERS = {
    r"control\.gain\.\d+": ("up down", "a gain that integers of 16 bits hold by the same numbers"),
}
ENTRIES_THAT_MAY_BE_LEFT_OUT = {
    r"sha256\.\w+\.rs": "a file of which nothing is said",
    r"claims\.\d+ P10": "a part of a mission that follows from the others",
}
ROUNDED_UP_BY = Fraction(1, 10**6)


def claims_with_a_change(task: str) -> Iterator[tuple[str, Any]]:
    """Yield certificates with one change, each with a description of it.

    Every number, word and list is changed and left out, and two entries are added. A description has the path of the entry.
    """
    document = json.loads(shipped_files(task)[f"{task}.certificate.json"])

    def walk(value: Any, path: tuple[Any, ...]) -> Iterator[tuple[tuple[Any, ...], Any]]:
        yield path, value
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
            yield from walk(inner, (*path, key))

    for path, value in list(walk(document, ()))[1:]:
        for label, new in changed_values(value):
            copy = json.loads(json.dumps(document))
            target = copy
            for key in path[:-1]:
                target = target[key]
            if label == "left out":
                del target[path[-1]]
            else:
                target[path[-1]] = new
            yield f"{described(path, document)}: {label}", copy
    for key in ("note", "sampled2"):
        yield f"{key}: added", {**document, key: 1}


def described(path: tuple[Any, ...], document: dict[str, Any]) -> str:
    """Return the path of an entry as words with dots; a claim has its property too, as in "claims.3 P4.margin"."""
    words = [str(key) for key in path]
    if path[0] == "claims" and len(path) > 1:
        words[1] += f" {document['claims'][path[1]]['property']}"
    return ".".join(words)


def changed_values(value: Any) -> list[tuple[str, Any]]:
    """Return other values of a claim, each with its label; "left out" stands for no value."""
    alternatives: list[tuple[str, Any]] = [("left out", None)]
    if isinstance(value, bool) or value is None:
        alternatives.append(("negated", not value))
    elif isinstance(value, int):
        alternatives += [(f"{value} to {value + d}", value + d) for d in (1, -1, 10**6)] + [("as a decimal", float(value))]
    elif isinstance(value, str):
        changed = value[:-1] + ("1" if value[-1:] != "1" else "2")
        alternatives.append((f"{value} to {changed}", changed))
    elif isinstance(value, list):
        alternatives += [("empty", []), ("twice", value + value)]
    else:
        alternatives.append(("empty", {}))
    return alternatives


def reason_for_true_claim(label: str, are_integers: bool = False) -> str:
    """Return why the changed claim with this description may be true; an empty text where it cannot be."""
    for path, reason in ENTRIES_THAT_MAY_BE_LEFT_OUT.items():
        if re.fullmatch(f"{path}: left out", label):
            return reason
    change = re.fullmatch(r"(?P<path>[^:]+): (?P<old>-?\d+(?:/\d+)?) to (?P<new>-?\d+(?:/\d+)?)", label)
    if change is None:
        return ""
    old, new = Fraction(change["old"]), Fraction(change["new"])
    changes = {"up" if new > old else "down"}
    is_one_unit = abs(new - old) == 1 and "/" not in change["old"] + change["new"]
    if is_one_unit or 0 < old - new < old * ROUNDED_UP_BY:
        changes.add("step")
    for path, (possible, reason) in (TRUE_CLAIMS | (TRUE_CLAIMS_OF_INTEGERS if are_integers else {})).items():
        if re.fullmatch(path, change["path"]) and changes & set(possible.split()):
            return reason
    return ""


def accepted_claims(task: str, step: int = 1) -> list[str]:
    """Return the descriptions of the changed claims that the checker accepts. step: only every so many are tried."""
    return [
        label
        for label, document in islice(claims_with_a_change(task), 0, None, step)
        if is_accepted({**shipped_files(task), f"{task}.certificate.json": json.dumps(document).encode()}, task)
    ]


def main() -> int:
    """Check all mutants of each task, and print the accepted ones. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--every", type=int, default=1, help="only every so many tokens")
    parser.add_argument("--task", action="append", choices=SCALARS, help="where none is named, all of them")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    wrong = 0
    for task in options.task or SCALARS:
        begin = time.perf_counter()
        if not is_accepted(shipped_files(task), task):
            print(f"{task}: REFUSED without a change")
            return 1
        with multiprocessing.Pool(options.processes) as pool:
            judged = list(pool.imap(partial(judge_mutant, task=task), token_mutants(task, options.every), chunksize=20))
        accepted = [mutant for mutant, passed in judged if passed]
        reasons = Counter(reason_for_same_meaning(m, task) for m in accepted)
        print(f"{task}: {len(judged)} changed tokens, {len(accepted)} accepted ({time.perf_counter() - begin:.0f} s)")
        for reason, count in sorted(reasons.items()):
            print(f"  {count:4d}  {reason or 'WHICH DO NOT MEAN THE SAME'}")
        for m in accepted:
            if not reason_for_same_meaning(m, task):
                print(f"  ACCEPTED: {m.file}: {m.token!r} -> {m.replacement!r} in: {m.line}")
        claims = accepted_claims(task)
        print(f"{task}: {sum(1 for _ in claims_with_a_change(task))} changed claims, {len(claims)} accepted")
        for label in claims:
            print(f"  {reason_for_true_claim(label, SCALARS[task] == 'fixed') or 'ACCEPTED'}: {label}")
        wrong += sum(not reason_for_same_meaning(m, task) for m in accepted)
        wrong += sum(not reason_for_true_claim(label, SCALARS[task] == "fixed") for label in claims)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
