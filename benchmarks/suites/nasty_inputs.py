"""Malformed and oversized inputs of every kind that a command reads: mutations of good files, and families of bombs.

`draw_case` draws them by seed. A case is a folder of files and the command that reads them.

Long because every kind of input has a good file, its bombs, and its commands.
"""

from __future__ import annotations

import copy
import io
import json
import random
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from pathlib import Path
from typing import Any

from stt_codegen.task import json_schema

ROOT = Path(__file__).parent.parent.parent
TASKS = ("empty", "omni_s1", "omni_s3", "omni_heading", "either", "crawler", "trolley", "rover", "waypoints")
RECORDED = "omni_s3"
Files = dict[str, bytes]

# Texts that stand in for a token of any text format.
TOKENS: tuple[str, ...] = (
    "", "nan", "-inf", "1e999999999", "-1e-999999999", "9" * 4000, "9" * 200_000, "0x" + "f" * 300, "0" * 5000 + "1",
    "-0.0", "1_0", "true", "null", "[]", "{}", "[[[[]]]]", '""', "''", '"""', "'''", "#", "\\", "\0", "\r", "\t", "\u202e",
    "\ufeff",
    "é", "𝟙", "½", "٣", "../../../../etc/passwd", "/dev/zero", "/dev/full", "$(id)", "`id`", "*/", "<script>", "%s%n",
    "{{7*7}}", "a.b",
    "=", ",", "1979-05-27T07:32:00Z", "auto", "*a", "&a", "!!python/object/apply:os.system", "1/0", "1/3", "0x1p3", "-",
    "+1", ".5",
)  # fmt: skip

# Values that stand in for a value of TOML or JSON.
VALUES: tuple[Any, ...] = (
    0, -1, 1, 2**63, -(2**64), 10**300, Decimal("1e-300"), Decimal("0.1"), Decimal("NaN"), Decimal("Infinity"),
    Decimal("1e9"), Decimal("1e-9"), Decimal("1e10"), Decimal("0." + "3" * 60), True, False, "", "auto", "x", "a" * 100_000,
    "\0", "\n", "*/", "\u202e",
    "é", [], [[]], {}, {"a": 1}, [0], [0, 0], [0] * 3, [0] * 65, [0] * 10_000, [[0, 0]] * 5_000, ["x"], ["x", "x"], [{}],
    [{}] * 3_000,
    [Decimal("0.5"), Decimal("0.5")], [1, "x"], [True, False], "1", "1.0", "[0, 1]",
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """Files of a folder, and the arguments of the command that reads them there. kind: of input; family: how it was made."""

    kind: str
    family: str
    files: Mapping[str, bytes]
    arguments: tuple[str, ...]


@dataclass(frozen=True)
class Bomb:
    """A case of which the file `part` is large, deep or long; `case` makes its bytes."""

    kind: str
    family: str
    files: Mapping[str, bytes]
    arguments: tuple[str, ...]
    part: str
    make: Callable[[], bytes]

    def case(self) -> Case:
        return Case(self.kind, self.family, {**self.files, self.part: self.make()}, self.arguments)


# ------------------------------------------------------------------------------------------ mutation


def mutate_bytes(data: bytes, rng: random.Random) -> bytes:
    """Return bytes with up to four pieces removed, repeated, replaced or cut off."""
    for _ in range(rng.randint(1, 4)):
        a, b = sorted(rng.choices(range(len(data) + 1), k=2))
        b = min(b, a + rng.choice((1, 1, 2, 8, 100, 10_000)))
        noise = bytes(rng.randrange(256) for _ in range(rng.choice((1, 1, 4, 64))))
        data = rng.choice(
            (data[:a] + data[b:], data[:b] + data[a:], data[:a] + noise + data[b:], data[:a], data[:a] + noise + data[a:])
        )
    return data


def mutate_tokens(data: bytes, rng: random.Random) -> bytes:
    """Return a text with up to three tokens removed, repeated, exchanged or replaced."""
    tokens = re.findall(r"\s+|[A-Za-z_]+|[0-9.eE+-]+|.", data.decode(errors="replace"))
    for _ in range(rng.randint(1, 3)):
        if not tokens:
            break
        i, j = rng.randrange(len(tokens)), rng.randrange(len(tokens))
        change = rng.randrange(4)
        if change == 0:
            tokens[i] = rng.choice(TOKENS)
        elif change == 1:
            tokens[i] = tokens[i] * rng.choice((2, 3, 1000))
        elif change == 2:
            tokens[i], tokens[j] = tokens[j], tokens[i]
        else:
            del tokens[i]
    return "".join(tokens).encode(errors="surrogatepass")


def paths_in(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every value in lists and tables."""
    if path:
        yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from paths_in(inner, (*path, key))


def mutate_structure(document: Any, rng: random.Random) -> Any:
    """Return lists and tables with up to three values replaced, removed or repeated."""
    for _ in range(rng.randint(1, 3)):
        *parents, last = rng.choice(list(paths_in(document)) or [("name",)])
        table = document
        for key in parents:
            table = table[key]
        change = rng.randrange(4)
        if change == 0 and isinstance(table, list):
            table.insert(last, table[last])
        elif change == 1:
            del table[last]
        elif change == 2 and isinstance(table[last], list):
            table[last] = table[last] * rng.choice((0, 2, 50))
        else:
            table[last] = copy.deepcopy(rng.choice(VALUES))  # the next change may be of a value within it
    return document


def to_toml(value: Any) -> str:
    """Return a table as TOML, with all inner tables written inline."""

    def inline(v: Any) -> str:
        if isinstance(v, dict):
            return "{" + ", ".join(f"{json.dumps(k)} = {inline(w)}" for k, w in v.items()) + "}"
        if isinstance(v, list):
            return "[" + ", ".join(map(inline, v)) + "]"
        if isinstance(v, bool | str):
            return json.dumps(v)
        return str(v).replace("Infinity", "inf").replace("NaN", "nan").replace("E", "e")

    return "".join(f"{json.dumps(k)} = {inline(v)}\n" for k, v in value.items())


# ------------------------------------------------------------------------------------------ tasks


def good_task(name: str) -> bytes:
    return (ROOT / "tasks" / f"{name}.toml").read_bytes()


def fields_of_schema() -> list[tuple[str, ...]]:
    """Return the path of every field of a task file, of tables in lists without their number."""
    schema = json.loads(json_schema())

    def walk(node: Any, path: tuple[str, ...], depth: int) -> Iterator[tuple[str, ...]]:
        if "$ref" in node:
            node = schema["$defs"][node["$ref"].rpartition("/")[2]]
        for inner in [*node.get("anyOf", []), *node.get("oneOf", []), *([node["items"]] if "items" in node else [])]:
            yield from walk(inner, path, depth)
        for key, inner in node.get("properties", {}).items() if depth < 3 else ():
            yield (*path, key)
            yield from walk(inner, (*path, key), depth + 1)

    return sorted(set(walk(schema, (), 0)))


def with_field(document: dict[str, Any], path: tuple[str, ...], value: Any) -> dict[str, Any]:
    """Return a task with a field set; tables that it lacks are added."""
    table: Any = document
    for key in path[:-1]:
        inner = table.setdefault(key, {})
        table = inner[0] if isinstance(inner, list) and inner and isinstance(inner[0], dict) else inner
        if not isinstance(table, dict):
            return document
    table[path[-1]] = value
    return document


def _encoded(make: Callable[[], str]) -> bytes:
    return make().encode()


def task_bombs() -> dict[str, Callable[[], bytes]]:
    """Return families of tasks that would be large, deep or long for a parser, a check or a search."""
    base = good_task("omni_s3").decode()
    box = '[[unsafe]]\nname = "b{}"\nlower = [{}, {}]\nupper = [{}, {}]\n'
    plain = base.replace("[[unsafe]]", "[[other]]")
    texts: dict[str, Callable[[], str]] = {
        "dotted key": lambda: "a." * 30_000 + "b = 1\n" + base,
        "dotted quoted key": lambda: '"a" . ' * 30_000 + "b = 1\n" + base,
        "dotted header": lambda: base + "[" + "a." * 30_000 + "b]\n",
        "many dotted keys": lambda: "".join(f"a{i}.b.c.d.e.f.g.h = 1\n" for i in range(40_000)) + base,
        "lists in lists": lambda: base + "\nz = " + "[" * 50_000,
        "tables in tables": lambda: base + "\nz = " + "{a = " * 50_000,
        "many tables": lambda: base + "[[unsafe]]\n" * 300_000,
        "many inline tables": lambda: "unsafe = [" + "{}," * 300_000 + "]\n" + base,
        "many keys": lambda: "".join(f"k{i} = 1\n" for i in range(350_000)) + base,
        "many boxes": lambda: base + "".join(box.format(i, 0.001 * i, 0.5, 0.001 * i + 0.0005, 0.6) for i in range(3_000)),
        "digits": lambda: base.replace("prescribed_time = ", "prescribed_time = " + "1" * 3_000_000),
        "hexadecimal": lambda: "z = 0x" + "f" * 3_000_000 + "\n" + base,
        "a megabyte too much": lambda: base + "#" + "x" * 5_000_000,
        "comment": lambda: base + "#" + "x" * 3_900_000,
        "string": lambda: f'name = "{"x" * 3_900_000}"\n',
        "escapes": lambda: 'name = "' + "\\u0041" * 600_000 + '"\n',
        "quotes": lambda: "name = " + '"' * 2_000_000,
        "string without end": lambda: 'name = """' + "x.y.z.[{" * 200_000,
        "dimensions": lambda: base.replace("initial_state = [", "initial_state = [" + "0.1, " * 500_000),
        "vertices": lambda: base + "[[unsafe]]\nvertices = [" + "[0.1, 0.2], " * 100_000 + "]\n",
        "half-spaces": lambda: base + "[[unsafe]]\nnormals = [" + "[1, 2], " * 32 + "]\noffsets = [" + "1, " * 32 + "]\n",
        "motion": lambda: (
            base + "[[unsafe]]\nlower = [1, 1]\nupper = [2, 2]\nmotion = [" + "{at = 1, by = [1, 1]}, " * 40_000 + "]\n"
        ),
        "missions": lambda: base + '[[mission]]\nvisit = "A"\n' * 20_000,
        "formula in brackets": lambda: base + '[[mission]]\nformula = "' + "(" * 100_000 + '"\n',
        "formula of nots": lambda: base + '[[mission]]\nformula = "' + "not " * 100_000 + 'A"\n',
        "formula of ands": lambda: base + '[[mission]]\nformula = "' + "A & " * 100_000 + 'A"\n',
        "formula of windows": lambda: base + '[[mission]]\nformula = "' + "F[0, 1] G[0, 1] " * 20_000 + 'A"\n',
        "regions": lambda: base + '[[region]]\nname = "A"\nlower = [1, 1]\nupper = [2, 2]\n' * 20_000,
        "maps": lambda: plain + "[map]\nfile = [" + '"a.yaml", ' * 100_000 + "]\n",
        "a map that is a device": lambda: plain + '[map]\nfile = "/dev/zero"\n',
        "a map with a NUL": lambda: plain + '[map]\nfile = "a\\u0000b"\n',
        "carriage returns": lambda: base.replace("\n", "\r"),
        "lines that end in two ways": lambda: base.replace("\n", "\r\n"),
        "empty": lambda: "",
    }
    families: dict[str, Callable[[], bytes]] = {name: partial(_encoded, make) for name, make in texts.items()}
    return families | {
        "UTF-16": lambda: base.encode("utf-16"),
        "bytes that are no UTF-8": lambda: base.encode() + b"\xff\xfe",
        "zeros": lambda: bytes(3_000_000),
    }


def task_case(rng: random.Random) -> Case:
    """Draw a task and the command that reads it: bombs, mutations of three kinds, or a wrong value in a field of the schema."""
    name, family = rng.choice(TASKS), rng.choice(("bomb", "bytes", "tokens", "tokens", "structure", "field", "field"))
    data = good_task(name)
    if family == "bomb":
        family, make = rng.choice(list(task_bombs().items()))
        data = make()
    elif family == "bytes":
        data = mutate_bytes(data, rng)
    elif family == "tokens":
        data = mutate_tokens(data, rng)
    else:
        document = tomllib.loads(data.decode(), parse_float=Decimal)
        if family == "structure":
            document = mutate_structure(document, rng)
        else:
            path = rng.choice(fields_of_schema())
            document, family = with_field(document, path, rng.choice(VALUES)), ".".join(path)
        data = to_toml(document).encode(errors="surrogatepass")
    command = rng.choice(
        (
            ("generate", "--out", "out", "--effort", "0"),
            ("design", "--effort", "0"),
            ("generate", "--record", "out", "--effort", "0"),
        )
    )
    return Case("task", family, {"task.toml": data}, (command[0], "task.toml", *command[1:]))


# ------------------------------------------------------------------------------------------ maps


def good_map(rng: random.Random) -> Files:
    """Return a small map and its image, as a map saver writes them."""
    from PIL import Image

    image = Image.new("L", (rng.randint(1, 40), rng.randint(1, 40)), 254)
    for _ in range(rng.randint(0, 30)):
        image.putpixel((rng.randrange(image.width), rng.randrange(image.height)), rng.choice((0, 205, 128)))
    data, kind = io.BytesIO(), rng.choice(("PNG", "PPM", "BMP", "GIF", "TIFF"))
    image.save(data, kind)
    text = "image: a.img\nresolution: 0.05\norigin: [-1.0, -2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    return {"map.yaml": text.encode(), "a.img": data.getvalue()}


def image_bombs() -> dict[str, Callable[[], bytes]]:
    """Return images that claim to be large, are packed, or are of a kind that runs a program."""
    import struct
    import zlib

    def png(width: int, height: int, *chunks: tuple[bytes, bytes]) -> bytes:
        header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
        parts = [(b"IHDR", header), *chunks, (b"IEND", b"")]
        return b"\x89PNG\r\n\x1a\n" + b"".join(
            struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in parts
        )

    def packed() -> bytes:
        return zlib.compress(bytes(200_000_000), 9)

    return {
        "a large header": lambda: png(2**31 - 1, 2**31 - 1),
        "4096 x 4096": lambda: png(4096, 4096, (b"IDAT", zlib.compress(bytes(4097 * 4096), 9))),
        "too wide": lambda: png(5000, 2, (b"IDAT", zlib.compress(bytes(5001 * 2)))),
        "packed pixels": lambda: png(10, 10, (b"IDAT", packed())),
        "packed text": lambda: png(10, 10, (b"zTXt", b"a\0\0" + packed()), (b"IDAT", zlib.compress(bytes(110)))),
        "no pixels": lambda: png(10, 10),
        "PGM of digits": lambda: b"P2 " + b"9" * 100_000 + b" 9 255\n",
        "PGM in text": lambda: b"P2 40 40 255\n" + b"0 " * 1_000_000,
        "PGM comment": lambda: b"P5 #" + b"x" * 5_000_000,
        "PFM": lambda: b"Pf 10 10 -1.0\n" + bytes(400),
        "EPS": lambda: b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 10 10\n{} loop\n",
        "SVG": lambda: b'<svg xmlns="http://www.w3.org/2000/svg"/>',
        "empty": lambda: b"",
        "zeros": lambda: bytes(1_000_000),
    }


def yaml_bombs() -> dict[str, Callable[[], bytes]]:
    """Return YAML with aliases, depth, tags and long scalars."""
    good = "image: a.img\nresolution: 0.05\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    aliases = "a0: &a0 [x, x]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 30))
    texts = {
        "aliases": aliases + good,
        "an alias of itself": "a: &a [*a]\n" + good,
        "merge keys": "<<: &a {image: a}\nb: {<<: *a}\n" + good,
        "lists in lists": "a: " + "[" * 10_000 + "\n" + good,
        "blocks in blocks": "".join("  " * i + "a:\n" for i in range(120)) + good,
        "indents": "- " * 7_000 + "\n",
        "tags": "a: !!python/object/apply:os.system ['id']\n" + good,
        "two documents": good + "---\n" + good,
        "digits": good.replace("0.05", "9" * 15_000),
        "exponent": good.replace("0.05", "1e999999999"),
        "tiny cells": good.replace("0.05", "1e-19"),
        "sexagesimal": good.replace("0.05", "1:2:3"),
        "a long key": "? " + "x" * 15_000 + "\n: 1\n" + good,
        "too long": good + "#" * 20_000,
        "an image that is a device": good.replace("a.img", "/dev/zero"),
        "an image that is this file": good.replace("a.img", "map.yaml"),
        "an image that is a folder": good.replace("a.img", "."),
        "keys that are lists": "[a, b]: 1\n{a: b}: 2\n" + good,
        "origin of lists": good.replace("[0, 0, 0]", "[[0], {a: 1}, null]"),
    }
    return {name: partial(bytes, text.encode()) for name, text in texts.items()}


def map_case(rng: random.Random) -> Case:
    """Draw a map whose YAML or image is wrong, and the command that reads it."""
    files, part = good_map(rng), rng.choice(("map.yaml", "map.yaml", "a.img"))
    family = rng.choice(("bomb", "bytes", "tokens"))
    if family == "bomb":
        family, make = rng.choice(list((image_bombs() if part == "a.img" else yaml_bombs()).items()))
        files[part] = make()
    else:
        files[part] = (mutate_tokens if family == "tokens" and part != "a.img" else mutate_bytes)(files[part], rng)
    if rng.random() < 0.3:
        return Case("map", f"{part}: {family}", files, ("map", "map.yaml", "--upright", "out/up.yaml"))
    return Case(
        "map", f"{part}: {family}", files, ("map", "map.yaml", "--as", rng.choice(("boxes", "polygons")), "--picture", "out")
    )


# ------------------------------------------------------------------------------------------ records of steps


def good_record() -> bytes:
    rows = [f"{0.01 * i:.2f};{int(i >= 10)};{0.0 if i < 10 else 1 - 0.9 ** (i - 9):.5f}" for i in range(120)]
    return ("time;command;response\n" + "\n".join(rows) + "\n").encode()


def record_bombs() -> dict[str, Callable[[], bytes]]:
    """Return records that are long, wide, or have numbers at the ends of their range."""
    text = good_record().decode()
    return {
        "empty": lambda: b"",
        "headings alone": lambda: b"a;b;c\n" * 1000,
        "a million rows": lambda: b"".join(b"%d 0 0\n" % i for i in range(1_000_000)),
        "400,000 rows": lambda: b"".join(b"%d %d %d\n" % (i, i > 9, i > 9) for i in range(400_000)),
        "a wide row": lambda: b"1;" * 3_000_000 + b"\n",
        "a long cell": lambda: b"1" * 3_000_000 + b";1;1\n",
        "large numbers": lambda: text.replace("0.0;", "1e308;").replace(";1;", ";1e308;").encode(),
        "large responses": lambda: re.sub(r"(\d\.\d{5})", r"\1e307", text).encode(),
        "small responses": lambda: re.sub(r"(\d\.\d{5})", r"\1e-320", text).encode(),
        "small times": lambda: re.sub(r"(?m)^(\d\.\d\d)", r"\1e-310", text).encode(),
        "large times": lambda: re.sub(r"(?m)^(\d\.\d\d)", r"\1e305", text).encode(),
        "small commands": lambda: text.replace(";1;", ";1e-320;").encode(),
        "no numbers": lambda: text.replace("0", "nan").encode(),
        "carriage returns": lambda: text.replace("\n", "\r").encode(),
        "NULs": lambda: text.replace(";", "\0").encode(),
        "lines of Unicode": lambda: text.replace("\n", "\u2028").encode(),
        "digits of Unicode": lambda: text.replace("1", "١").encode(),
        "zeros": lambda: bytes(2_000_000),
        "too large": lambda: b"1;1;1\n" * 6_000_000,
    }


def record_case(rng: random.Random) -> Case:
    """Draw a record of a step that is wrong."""
    family, data = rng.choice(("bomb", "bytes", "tokens")), good_record()
    if family == "bomb":
        family, make = rng.choice(list(record_bombs().items()))
        data = make()
    else:
        data = (mutate_tokens if family == "tokens" else mutate_bytes)(data, rng)
    options = rng.choice(
        ((), ("--columns", "1,2,3"), ("--columns", rng.choice(TOKENS).replace("\0", "") or ","), ("--latency", "1e300"))
    )
    return Case("record", family, {"step.csv": data}, ("lag", "step.csv", *options))


# ------------------------------------------------------------------------------------------ what a controller consists of


def good_set() -> Files:
    """Return a recorded controller with its task."""
    folder = ROOT / "generated" / RECORDED / "refined" / "float"
    names = [f"{RECORDED}{end}" for end in (".h", ".c", ".py", ".certificate.json")]
    return {"task.toml": good_task(RECORDED), **{name: (folder / name).read_bytes() for name in names}}


def json_bombs(good: bytes) -> dict[str, Callable[[], bytes]]:
    """Return JSON that is deep, long or has odd numbers."""
    document = json.loads(good)
    return {
        "lists in lists": lambda: b"[" * 100_000,
        "tables in tables": lambda: b'{"a":' * 100_000,
        "many lists": lambda: b"[" + b"[]," * 3_000_000 + b"[]]",
        "digits": lambda: good.replace(b"3", b"3" * 5_000),
        "exponents": lambda: re.sub(rb"\d+", b"1e999999999", good),
        "not a number": lambda: re.sub(rb": \d+", b": NaN", good),
        "nothing divided": lambda: re.sub(rb'"\d+/\d+"', b'"1/0"', good),
        "a key twice": lambda: good.replace(b"{", b'{"format": 3, "format": 3, ', 1),
        "a list": lambda: b"[]",
        "a number": lambda: b"3",
        "empty": lambda: b"",
        "too large": lambda: good + b" " * 70_000_000,
        "UTF-16": lambda: good.decode().encode("utf-16"),
        "a surrogate": lambda: good.replace(b'"format"', b'"\\ud800"'),
        "no hashes": lambda: json.dumps({**document, "sha256": 5, "folders": 5}).encode(),
        "hashes in a list": lambda: json.dumps({**document, "sha256": ["a"], "folders": []}).encode(),
    }


def source_bombs(good: bytes) -> dict[str, Callable[[], bytes]]:
    """Return C that is long, or has long tokens and tables."""
    return {
        "a comment without end": lambda: good + b"/*" + b"*" * 3_000_000,
        "comments": lambda: good + b"/**/" * 900_000,
        "brackets": lambda: good + b"(" * 3_000_000,
        "signs": lambda: good + b";" * 3_500_000,
        "a long name": lambda: good + b"a" * 3_000_000,
        "a long number": lambda: re.sub(rb"\{\n    \d", b"{\n    " + b"1" * 1_000_000, good, count=1),
        "exponents": lambda: re.sub(rb"(\d\.\d+)F", rb"\1e999F", good),
        "a long table": lambda: re.sub(rb"(_coefficients\[)\d+\] = \{", rb"\g<1>9] = {" + b"0.5F, " * 500_000, good, count=1),
        "too large": lambda: good + b"\n" * 9_000_000,
        "empty": lambda: b"",
        "zeros": lambda: bytes(1_000_000),
    }


def set_case(rng: random.Random) -> Case:
    """Draw a task, a C file or a certificate that is wrong, for the checker; or a certificate that stands in the way of a set."""
    files = good_set()
    part = rng.choice(("task.toml", f"{RECORDED}.c", f"{RECORDED}.h", f"{RECORDED}.certificate.json"))
    family, data = rng.choice(("bomb", "bytes", "tokens", "structure")), files[part]
    if family == "bomb":
        bombs = task_bombs() if part == "task.toml" else json_bombs(data) if part.endswith("json") else source_bombs(data)
        family, make = rng.choice(list(bombs.items()))
        files[part] = make()
    elif family == "structure" and part.endswith("json"):
        files[part] = json.dumps(mutate_structure(json.loads(data), rng), default=float).encode()
    else:
        files[part] = (mutate_bytes if family == "bytes" else mutate_tokens)(data, rng)
    if part.endswith("json") and rng.random() < 0.4:
        files = {"task.toml": good_task(RECORDED), f"out/{part}": files[part], f"out/{RECORDED}.c": files[f"{RECORDED}.c"]}
        return Case("folder", family, files, ("generate", "task.toml", "--out", "out"))
    return Case(
        "certificate", f"{part}: {family}", files, ("certify", "task.toml", f"{RECORDED}.c", f"{RECORDED}.certificate.json")
    )


def good_recording() -> Files:
    """Return a recorded folder with its manifest, its task, and a task beside it."""
    files = good_set()
    hashes = json.loads(files[f"{RECORDED}.certificate.json"])["sha256"]
    options = {"design": "refined", "scalar": "float"}
    entry = {"task": "../task.toml", "inputs_sha256": "0" * 64, "options": options, "sha256": hashes}
    manifest = json.dumps({"format": 1, "tools": {}, "folders": {f"{RECORDED}/refined/float": entry}}).encode()
    tree = {f"recorded/{RECORDED}/refined/float/{n}": d for n, d in files.items() if n != "task.toml"}
    return tree | {"task.toml": files["task.toml"], "empty.toml": good_task("empty"), "recorded/MANIFEST.json": manifest}


def manifest_case(rng: random.Random) -> Case:
    """Draw a recorded folder whose manifest, C or task is wrong, or a task beside it."""
    tree = good_recording()
    part = rng.choice(
        (*["recorded/MANIFEST.json"] * 4, f"recorded/{RECORDED}/refined/float/{RECORDED}.c", "task.toml", "empty.toml")
    )
    family, data = rng.choice(("bomb", "bytes", "tokens", "structure", "structure")), tree[part]
    if family == "bomb":
        bombs = task_bombs() if part.endswith("toml") else json_bombs(data) if part.endswith("json") else source_bombs(data)
        family, make = rng.choice(list(bombs.items()))
        tree[part] = make()
    elif family == "structure" and part.endswith("json"):
        tree[part] = json.dumps(mutate_structure(json.loads(data), rng), default=float).encode()
    else:
        tree[part] = (mutate_bytes if family == "bytes" else mutate_tokens)(data, rng)
    accept = ("--accept",) if rng.random() < 0.3 else ()
    return Case("manifest", f"{Path(part).name}: {family}", tree, ("check", "recorded", *accept))


# ------------------------------------------------------------------------------------------ options


def option_case(rng: random.Random) -> Case:
    """Draw a command with a good task and an odd value of an option."""
    value = rng.choice(
        [t.replace("\0", "") for t in TOKENS] + ["1,2", "1,2,3", "nan,nan", "1e308,1e308", "-1", "x,x", "x1,x2", "a" * 5000]
    )
    commands = (
        ("simulate", "--start"), ("simulate", "--gain"), ("simulate", "--rate"), ("simulate", "--axes"), ("simulate", "--plant"),
        ("simulate", "--noise"), ("simulate", "--latency"), ("simulate", "--lag"), ("simulate", "--w-max"),
        ("simulate", "--seed"), ("simulate", "--disturbance"), ("simulate", "--clock"), ("design", "--picture"),
        ("design", "--axes"),
        ("generate", "--out"), ("generate", "--record"), ("generate", "--package"), ("generate", "--scalar"),
        ("prove", "--plant"), ("prove", "--noise"),
        ("prove", "--out"), ("report", "--out"), ("design", "--effort"),
    )  # fmt: skip
    command, option = rng.choice(commands)
    value = value[:3000]  # of a command line
    return Case("option", f"{command} {option}", {"task.toml": good_task("empty")}, (command, "task.toml", option, value))


MAKERS: tuple[Callable[[random.Random], Case], ...] = (
    task_case, task_case, task_case, map_case, map_case, record_case, set_case, set_case, manifest_case, option_case,
)  # fmt: skip


def draw_case(number: int, seed: int) -> Case:
    """Return the case of a number, the same for the same seed; kinds take turns."""
    return MAKERS[number % len(MAKERS)](random.Random(f"{seed} {number}"))


def bombs() -> Iterator[Bomb]:
    """Yield every bomb once."""
    generate = ("generate", "task.toml", "--out", "out", "--effort", "0")
    draw_map = ("map", "map.yaml", "--picture", "out")
    certify = ("certify", "task.toml", f"{RECORDED}.c", f"{RECORDED}.certificate.json")
    chart, files, recording = good_map(random.Random(0)), good_set(), good_recording()
    for kind, part, makers, good_files, arguments in (
        ("task", "task.toml", task_bombs(), {}, generate),
        ("map", "map.yaml", yaml_bombs(), chart, draw_map),
        ("map", "a.img", image_bombs(), chart, draw_map),
        ("record", "step.csv", record_bombs(), {}, ("lag", "step.csv")),
        ("certificate", f"{RECORDED}.c", source_bombs(files[f"{RECORDED}.c"]), files, certify),
        ("certificate", certify[-1], json_bombs(files[certify[-1]]), files, certify),
        ("certificate", "task.toml", task_bombs(), files, certify),
        ("manifest", "empty.toml", task_bombs(), recording, ("check", "recorded")),
    ):  # fmt: skip
        for name, make in makers.items():
            yield Bomb(kind, f"{part}: {name}", good_files, arguments, part, make)
