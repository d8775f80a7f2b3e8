"""Does the stand-alone checker read every token? Each token of shipped C and headers changed, one at a time, and every claim.

    python -m benchmarks token_mutants [--every 1] [--task trolley --task omni_board] [--processes 2]

A changed file gets new hashes, so only what the checker reads can refuse it. What is accepted must mean the same, and is listed
with the reason: a literal of the same value, a local that is no longer `const`, and of a controller in integers a row of the
curves with which the law is within its bound too. Exit code 1 where something else is accepted.
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
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from stt_codegen.certify import checker
from stt_codegen.pipeline import build
from stt_codegen.program.number import round_to

ROOT = Path(__file__).parent.parent
TOKEN = re.compile(
    r"/\*.*?\*/|\d+\.\d+(?:e-?\d+)?F?|0x[0-9a-f]+U|\d+U?|[A-Za-z_]\w*|\"[^\"\n]*\"|<<=|>>=|<=|>=|==|!=|&&|<<|>>|\+\+|--|\+=|&="
    r"|[^\s\w]",
    re.DOTALL,
)
TASKS = ("trolley", "omni_board", "gantry", "crane")
SIGNS = ("+", "-", "*", "/", "<", "<=", ">", "&&", "!", "==", "?", ":", ",", ";")
WORDS = (
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
class Mutant:
    """One change of one file: where, what stood there and what stands there now."""

    file: str
    place: int
    before: str
    after: str
    line: str


@cache
def files_of(task: str) -> dict[str, bytes]:
    return build(ROOT / "tasks" / f"{task}.toml").files


def mutants(task: str, every: int = 1) -> Iterator[Mutant]:
    """One for each token that is no comment: another number, another name of the file, another sign, or nothing."""
    for name, data in files_of(task).items():
        if name not in (f"{task}.c", f"{task}.h"):
            continue
        text = data.decode()
        found = [m for m in TOKEN.finditer(text) if not m.group().startswith("/*")]
        names = sorted({m.group() for m in found if re.match(r"[A-Za-z_]", m.group())} | set(WORDS))
        for k, match in enumerate(found):
            if k % every == 0:
                after = other(match.group(), names, Random(f"{name} {k}"))
                line = text[text.rfind("\n", 0, match.start()) + 1 : text.find("\n", match.end())].strip()
                yield Mutant(name, match.start(), match.group(), after, line)


def other(token: str, names: list[str], dice: Random) -> str:
    """What takes a token's place."""
    if dice.random() < 0.1:
        return ""
    if token[0] == '"':
        return '"other"'
    if re.match(r"\d", token):
        return dice.choice((number(token, dice), number(token, dice), dice.choice(names)))
    if re.match(r"[A-Za-z_]", token):
        return dice.choice([v for v in names if v != token])
    return dice.choice([v for v in SIGNS if v != token])


def number(token: str, dice: Random) -> str:
    """Another number of the same kind: a digit changed, or one more or less."""
    if "." in token or token.startswith("0x"):
        places = [m.start() for m in re.finditer(r"\d", token) if m.start() != 1 or not token.startswith("0x")]
        k = dice.choice(places)
        return token[:k] + str((int(token[k]) + dice.randrange(1, 10)) % 10) + token[k + 1 :]
    value, unsigned = int(token.rstrip("U")), "U" if token.endswith("U") else ""
    return dice.choice((f"{value + 1}{unsigned}", f"{max(value - 1, 0) if value else 2}{unsigned}", f"{2 * value + 1}{unsigned}"))


def changed(mutant: Mutant, task: str) -> dict[str, bytes]:
    """The files with the change and new hashes."""
    files = dict(files_of(task))
    text, place = files[mutant.file].decode(), mutant.place
    files[mutant.file] = (text[:place] + mutant.after + text[place + len(mutant.before) :]).encode()
    proof = f"{task}.certificate.json"
    document = json.loads(files[proof])
    document["sha256"][mutant.file] = hashlib.sha256(files[mutant.file]).hexdigest()
    files[proof] = json.dumps(document).encode()
    return files


def accepted(files: dict[str, bytes], task: str) -> bool:
    """Whether the checker says yes. A program error in it counts as a refusal only if it says so."""
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
    ):
        for name, data in files.items():
            Path(folder, name).write_bytes(data)
        paths = [str(Path(folder, f"{task}.{end}")) for end in ("c", "certificate.json")]
        return checker.main([str(ROOT / "tasks" / f"{task}.toml"), *paths]) == 0


def judge(mutant: Mutant, task: str) -> tuple[Mutant, bool]:
    return mutant, accepted(changed(mutant, task), task)


def same_meaning(mutant: Mutant, task: str) -> str:
    """Why a changed token means the same, in words; empty where it does not."""
    if as_right(mutant, task):
        return "a row of the curves that is as right"
    if mutant.before == "const" and not mutant.after and mutant.line.startswith("const "):
        return "a local that is no longer const"
    if all(re.fullmatch(r"\d+\.\d+(?:e-?\d+)?F", v) for v in (mutant.before, mutant.after)):
        before, after = (round_to(Fraction(v[:-1]), "float") for v in (mutant.before, mutant.after))
        return "a literal of the same float" if before == after else ""
    return ""


def as_right(mutant: Mutant, task: str) -> bool:
    """Whether the change is one of a table of the curves of a controller in integers, and every value of them is within 2^-11 of
    1/d or H: the law may be wrong by 2^-10."""
    text = changed(mutant, task)[mutant.file].decode()
    found = {
        name: list(map(int, body.split(",")))
        for name, body in re.findall(r"const uint\d+_t \w+_(levels|slopes|bends|places)\[\d+\] \w+ = \{([\d,\s]*)\}", text)
    }
    if len(found) < 4 or not re.fullmatch(r"\d+", mutant.before + mutant.after) or not re.fullmatch(r"\d+,?", mutant.line):
        return False
    t = np.arange(1 << 16)
    level, slope, bend, places = (np.array(found[name])[:, None] for name in ("levels", "slopes", "bends", "places"))
    value = level - ((slope - (bend * t >> 16)) * t >> 17)
    head, place = np.arange(len(level))[:, None], (t + 0.5) / (1 << 16)
    over = 2.0**16 / (1 + (head[:16] + place) / 16)
    e = 1 - (8 + (head[16:] - 16) % 8 + place) / 2.0 ** (4 + (head[16:] - 16) // 8)
    rise = 8 * np.arctanh(e) / (e * (1 - e * e)) * 2.0 ** (places[16] - places[16:])
    right = np.concatenate([over, rise * 2.0 ** np.round(np.log2(level[16] / rise[0, 0]))])
    return bool((value >= 0).all() and (value < 1 << 16).all() and (np.abs(value / right - 1) < 2.0**-11).all())


# ------------------------------------------------------------------------------------------------ claims


def claims(task: str) -> Iterator[tuple[str, Any]]:
    """Certificates with one claim changed: every number, word and list, by its path; and every entry left out."""
    document = json.loads(files_of(task)[f"{task}.certificate.json"])

    def walk(value: Any, path: tuple[Any, ...]) -> Iterator[tuple[tuple[Any, ...], Any]]:
        yield path, value
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
            yield from walk(inner, (*path, key))

    for path, value in list(walk(document, ()))[1:]:
        for label, new in changes(value):
            copy = json.loads(json.dumps(document))
            target = copy
            for key in path[:-1]:
                target = target[key]
            if label == "left out":
                del target[path[-1]]
            else:
                target[path[-1]] = new
            yield f"{'.'.join(map(str, path))}: {label}", copy
    for key in ("note", "sampled2"):
        yield f"{key}: added", {**document, key: 1}


def changes(value: Any) -> list[tuple[str, Any]]:
    """Other values of one claim."""
    found: list[tuple[str, Any]] = [("left out", None)]
    if isinstance(value, bool) or value is None:
        found.append(("the other", not value))
    elif isinstance(value, int):
        found += [(f"{value + d}", value + d) for d in (1, -1, 10**6)] + [("as a decimal", float(value))]
    elif isinstance(value, str):
        found.append(("another word", value[:-1] + ("1" if value[-1:] != "1" else "2")))
    elif isinstance(value, list):
        found += [("empty", []), ("twice", value + value)]
    else:
        found.append(("empty", {}))
    return found


def claim_is_true(label: str) -> str:
    """Changed claims that are true as well."""
    if label.startswith("sampled.rho"):
        return "another bound on |e|, proved too"
    if re.match(r"claims\.\d+\.hints\.\d+\.2\.", label):
        return "another normal that shows as much"
    return "a larger error, allowed for too" if label.startswith("sampled.shift") else ""


def changed_claims(task: str) -> list[str]:
    """The changed claims that are accepted."""
    return [
        label
        for label, document in claims(task)
        if accepted({**files_of(task), f"{task}.certificate.json": json.dumps(document).encode()}, task)
    ]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--every", type=int, default=1, help="only every so many tokens")
    parser.add_argument("--task", action="append", help=f"tasks/<name>.toml; where none is named {', '.join(TASKS)}")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    wrong = 0
    for task in options.task or TASKS:
        begin = time.perf_counter()
        if not accepted(files_of(task), task):
            print(f"{task}: REFUSED as it is")
            return 1
        with multiprocessing.Pool(options.processes) as pool:
            verdicts = list(pool.imap(partial(judge, task=task), mutants(task, options.every), chunksize=20))
        yes = [m for m, good in verdicts if good]
        reasons = Counter(same_meaning(m, task) for m in yes)
        print(f"{task}: {len(verdicts)} changed tokens, {len(yes)} accepted ({time.perf_counter() - begin:.0f} s)")
        for reason, count in sorted(reasons.items()):
            print(f"  {count:4d}  {reason or 'WHICH DO NOT MEAN THE SAME'}")
        for m in yes:
            if not same_meaning(m, task):
                print(f"  ACCEPTED: {m.file}: {m.before!r} -> {m.after!r} in: {m.line}")
        kept = changed_claims(task)
        told = sum(1 for _ in claims(task))
        print(f"{task}: {told} changed claims, {len(kept)} accepted")
        for label in kept:
            print(f"  {claim_is_true(label) or 'ACCEPTED'}: {label}")
        wrong += sum(not same_meaning(m, task) for m in yes) + sum(not claim_is_true(label) for label in kept)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
