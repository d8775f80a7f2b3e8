"""Checks a certified controller without the tool that made it. Python 3.11, standard library only.

    python3 checker.pyz TASK.toml CONTROLLER.c CERTIFICATE.json        (the header beside the C)
    python3 checker.pyz --meaning        (computes again what the listings mean and how they round)

Exit code 0: verified, all holds. 1: refused, and why. 2: a file cannot be used. docs/certificate-format.md says what this means.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any, NoReturn

from .bounds import CERTIFICATE_BYTES, SOURCE_BYTES, TASK_BYTES, read_bounded
from .claims import check
from .exact import Refused, Unusable
from .task import Task


def refuse_decimal(text: str) -> NoReturn:
    raise Refused(f"the certificate has the decimal {text}; its numbers are whole, or fractions")


def refuse_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len(dict(pairs)) < len(pairs):
        raise Refused("the certificate has a key twice")
    return dict(pairs)


def plain(problem: object) -> str:
    """Return a message as one line of printable characters, whatever texts of a file it has."""
    return str(problem).encode("unicode_escape").decode()


def verdict(arguments: list[str]) -> tuple[str, int]:
    """Run the check. Return a line, and the exit code."""
    if arguments != ["--meaning"] and len(arguments) != 3:
        return (__doc__ or "").strip(), 2
    try:
        if arguments == ["--meaning"]:
            from . import meaning

            meaning.check_meaning()
            return "checker: the listings compute the tube and the law, and round no more than rounding.py and integers.py say", 0
        data, text, proof = map(read_bounded, map(Path, arguments), (TASK_BYTES, SOURCE_BYTES, CERTIFICATE_BYTES))
        task, certificate = Task(data), json.loads(proof)
        if not isinstance(certificate, dict) or certificate.get("design") != "refined":
            raise Unusable("the certificate is not of a refined tube; only those can be checked here")
        # read again: decimals are refused only now, since certificates of other tubes have them
        certificate = json.loads(proof, parse_float=refuse_decimal, object_pairs_hook=refuse_duplicates)
        proved = check(task, certificate, text, Path(arguments[1]).parent)
    except Refused as problem:
        return f"checker: refused: {plain(problem)}", 1
    except Exception as problem:  # whatever a file does to the checker, the answer is not "verified"
        file = dict(zip(("TOMLDecodeError", "", "JSONDecodeError"), arguments, strict=False)).get(kind := type(problem).__name__)
        reason = f"{plain(file or 'a file')} is not of the form that is read here ({kind}: {plain(problem)})"
        reason = f"{plain(problem.filename)} cannot be read ({problem.strerror})" if isinstance(problem, OSError) else reason
        return f"checker: cannot check: {plain(problem) if isinstance(problem, Unusable) else reason}", 2
    return f"checker: verified: {task.name}: {proved}", 0


def main(arguments: list[str]) -> int:
    """Print the verdict, to stderr where there is none, and return the exit code; it is 2 where the line cannot be written."""
    line, code = verdict(arguments)
    stream = sys.stderr if code == 2 else sys.stdout
    try:
        print(line, file=stream, flush=True)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())  # Python would try again when it ends
        return 2
    return code
