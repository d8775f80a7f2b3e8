"""Formulas as other tools write them: the same formula, or a refusal that says what to write here. And regions that exclude one
another, which no search can have at one moment."""

from __future__ import annotations

import ast
import math
import random
import re
import time
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise, product
from typing import Any

import pytest

import stt_codegen as stt
from stt_codegen.checker.stt_checker import formula as checker_formula
from stt_codegen.checker.stt_checker.exact import Unusable
from stt_codegen.design.refusals.regions_at_once import excluded_regions, needed_finally, needed_now
from stt_codegen.task import parse_task
from stt_codegen.task.mission.formulas import Always, And, Eventually, Formula, InRegion, Interval, Or, Until, conjunction
from stt_codegen.task.mission.grammar import parse_formula
from stt_codegen.task.mission.unread_text import UNREAD_BINARY, UNREAD_PREFIXES
from tests.benchmarks.test_peers import needs

PLAIN = [
    "always[0, 16] (dock -> eventually[0, 4] left)",
    "not lab until[0, 24] key",
    "eventually[3, 5] always[0, 2] dock and not (lab or key)",
    "eventually dock -> always (not lab and eventually key)",
    "(dock -> left) and (left -> dock)",
]


def words(changes: dict[str, str]) -> Callable[[str], str]:
    """Return a function that writes these words in context of the plain ones."""
    return lambda text: re.sub(r"[a-z]+|->", lambda word: changes.get(word.group(), word.group()), text)


DIALECTS: dict[str, Callable[[str], str]] = {
    "rtamt": lambda text: words({"->": "implies"})(text).replace(", ", ":"),
    "letters": words({"always": "G", "eventually": "F", "until": "U", "and": "&&", "or": "||", "not": "!"}),
    "Breach": words({"always": "alw_", "eventually": "ev_", "until": "until_", "->": "=>"}),
    "TeX": words({"always": "globally", "eventually": "finally", "and": "/\\", "or": "\\/", "not": "~"}),
    "capitals": lambda text: words({name: name.upper() for name in ("always", "eventually", "until", "and", "or", "not")})(text),
    "one sign": words({"and": "&", "or": "|", "not": "!"}),
    "milliseconds": lambda text: re.sub(r"(\d+)", r"\g<1>000ms", text),
    "seconds": lambda text: re.sub(r"(\d+)", r"\1s", text),
}


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("text", PLAIN)
def test_a_formula_of_another_tool_is_the_same_formula(text: str, dialect: str) -> None:
    assert parse_formula(DIALECTS[dialect](text)) == parse_formula(text)


@pytest.mark.parametrize("sign", ["<->", "iff", "<=>"])
def test_an_equivalence_is_both_implications(sign: str) -> None:
    assert parse_formula(f"dock {sign} left") == parse_formula("(dock -> left) and (left -> dock)")
    assert parse_formula(f"a and b {sign} c") == parse_formula(f"(a and b) {sign} c")


def test_an_end_that_is_infinite_may_be_open() -> None:
    assert parse_formula("eventually[2, inf) dock") == parse_formula("eventually[2, inf] dock")


def test_regions_may_have_the_names_of_operators() -> None:
    g, f, u, x, r = (InRegion(name) for name in "GFUXR")
    assert parse_formula("G and F") == conjunction(g, f)
    assert parse_formula("eventually G") == Eventually(parse_formula("eventually F").over, g)
    assert parse_formula("F until (X and R)") == Until(parse_formula("F until X").over, f, conjunction(x, r))
    assert parse_formula("F U U") == parse_formula("F until U")
    assert parse_formula("G (U or G)") == parse_formula("always (U or G)")
    assert parse_formula("F G and not U") == parse_formula("eventually G and not U")
    assert u in parse_formula("F G and U").parts


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x + y <= 3", r"'\+ y <= 3' at character 3 compares numbers, .*normals = \[\[1, 1\]\] and offsets = \[3\]"),
        ("out = always[0:8] (not B)", "begins with 'out =', and a formula has no name here; leave `out =` out"),
        ("out = A -> B", "leave `out =` out"),
        ("out = always (x <= 3)", "leave `out =` out"),
        ("s = x + 3", "compares numbers"),
        ("always[0:8] not B;", "has ';' at character 18; leave it out"),
        ("A; B", "has ';' at character 2; use an entry for each formula"),
        ("F[0,1min] A", "has the unit 'min' at character 6; units are s, ms, us, ns"),
        ("always (abs(x) < 1)", "compares numbers, and a formula is about regions"),
        ("A == 1", "compares numbers"),
        ("2*x >= 1", "compares numbers"),
        ("next A", "time is continuous here: write eventually"),
        ("X A", "time is continuous here"),
        ("A release B", r"write not \(not f until not g\)"),
        ("A R B", r"write not \(not f until not g\)"),
        ("A W B", r"write \(f until g\) or always f"),
        ("A unless B", r"for `f unless g` write \(f until g\) or always f"),
        ("rise(A)", r"`always \(A -> f\)` asks for f there too"),
        ("A xor B", r"write \(f and not g\) or \(not f and g\)"),
        ("once[0, 3] A", "is about the past"),
        ("A since B", "is about the past"),
        ("eventually(0, 8) A", r"round brackets after 'eventually'; its ends count: write \[a, b\]"),
        ("eventually[0, 8) A", r"has '\)' at character 16, where '\]' is needed"),
        ("eventually[0 8] A", "where ',' is needed"),
    ],
)
def test_what_is_not_read_is_refused_with_what_to_write(text: str, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        parse_formula(text)


def test_the_advised_form_of_release_and_xor_is_read() -> None:
    for text in ("not (not A until not B)", "(A until B) or always A", "(A and not B) or (not A and B)"):
        parse_formula(text)


@pytest.mark.parametrize("context", ["{}", "({})", "G[0, 8] ({})", "A and {}", "(A -> {}) and B", "not {}", "A until[0, 3] {}"])
def test_an_unread_operator_gets_its_help_wherever_it_stands(context: str) -> None:
    for word, advice in UNREAD_BINARY.items():
        with pytest.raises(ValueError, match=re.escape(f"{word!r} at character {context.index('{') + 3} {advice}")):
            parse_formula(context.format(f"A {word} B"))
    for word, advice in UNREAD_PREFIXES.items():
        with pytest.raises(ValueError, match=re.escape(f"{word!r} at character {context.index('{') + 1} {advice}")):
            parse_formula(context.format(f"{word}(A)"))


@pytest.mark.parametrize(
    "context", ["{}", "always ({})", "A and {}", "not {} or B", "G {}", "A U {}", "{} -> B", "out_1 until[0, 3] {}"]
)
@pytest.mark.parametrize(
    "comparison",
    ["x <= 3", "x + y <= 3", "z1 >= 0.5", "2*x - 3 y + 1 > 4", "x <= y", "-x + 2 < 3*y - x", "3 >= 0.25 * x", "x-y>1"],
)
def test_the_region_that_is_advised_for_a_comparison_is_where_it_holds(comparison: str, context: str) -> None:
    with pytest.raises(ValueError, match="compares numbers") as refusal:
        parse_formula(context.format(comparison))
    lines = re.search(r"axes = (\[.*\]), normals = \[(\[.*\])\] and offsets = \[(.*)\] for (.*), and", str(refusal.value))
    assert lines is not None
    assert lines[4] == comparison
    axes, normal, offset = map(ast.literal_eval, lines.groups()[:3])
    for point in product((-7.31, -0.43, 0.97, 2.71, 11.13), repeat=3):
        values = dict(zip(("x", "y", "z1"), point, strict=True))
        holds = eval(comparison.replace("3 y", "3*y"), {}, values)
        assert holds == (sum(c * values[axis] for axis, c in zip(axes, normal, strict=True)) <= offset)


CHAINS = {
    "A implies B implies C": ("(A implies B) implies C", "A implies (B implies C)"),
    "A -> B -> C -> D": ("((A -> B) -> C) -> D", "A -> (B -> (C -> D))"),
    "A iff B => not C": ("(A iff B) => not C", "A iff (B => not C)"),
    "A <-> B <-> C": ("(A <-> B) <-> C", "A <-> (B <-> C)"),
    "A until[0, 3] B U[1:2] C": ("(A until[0, 3] B) U[1:2] C", "A until[0, 3] (B U[1:2] C)"),
    "A or B implies always (C and D) implies D": (
        "(A or B implies always (C and D)) implies D",
        "A or B implies (always (C and D) implies D)",
    ),
}


@pytest.mark.parametrize("context", ["{}", "always[0, 8] ({})", "D and ({})", "not ({}) -> D"])
@pytest.mark.parametrize("chain", CHAINS)
def test_a_chain_that_tools_read_in_different_ways_is_refused_with_both_readings(chain: str, context: str) -> None:
    from_left, from_right = CHAINS[chain]
    assert parse_formula(from_left) != parse_formula(from_right)
    with pytest.raises(ValueError, match=re.escape(f"write {from_left} or {from_right}")):
        parse_formula(context.format(chain))
    operators = re.findall(r"implies|iff|until|U|<->|=>|->", chain)[:2]
    with pytest.raises(Unusable, match=re.escape("needs brackets: (f {0} g) {1} h, or f {0} (g {1} h)".format(*operators))):
        checker_formula.parse(context.format(chain))


OPERATORS = (" and ", " or ", " implies ", " iff ", " until[0:3] ")
RTAMT_NODES = {"Conjunction": "and", "Disjunction": "or", "Implies": "->", "Iff": "<->", "TimedUntil": "until[0:3]"}
RTAMT_PREFIXES = {"Neg": "not", "TimedAlways": "always[0:3]", "TimedEventually": "eventually[0:3]"}


def bracketed(node: Any) -> str:
    """Return a formula as rtamt has read it, with all brackets."""
    kind, parts = type(node).__name__, node.children
    if kind in RTAMT_PREFIXES:
        return f"({RTAMT_PREFIXES[kind]} {bracketed(parts[0])})"
    return f"({bracketed(parts[0])} {RTAMT_NODES[kind]} {bracketed(parts[1])})" if parts else str(node.var)


def test_a_formula_without_brackets_is_refused_or_means_what_rtamt_reads(caplog: pytest.LogCaptureFixture) -> None:
    needs("rtamt")
    import rtamt

    draw, refused = random.Random(54), 0
    caplog.set_level("CRITICAL")
    for _ in range(150):
        operands = [draw.choice(("", "", "not ", "always[0:3] ", "eventually[0:3] ")) + name for name in "ABCD"]
        text = operands[0] + "".join(draw.choice(OPERATORS) + operand for operand in operands[1 : draw.randint(2, 4)])
        spec = rtamt.StlDenseTimeSpecification()
        for name in "ABCD":
            spec.declare_var(name, "float")
        spec.spec = f"out = {text}"
        spec.parse()
        try:
            formula = parse_formula(text)
        except ValueError:
            refused += 1
            with pytest.raises(Unusable):
                checker_formula.parse(text)
            continue
        assert formula == parse_formula(bracketed(spec.ast.specs[-1])), text
        assert checker_formula.parse(text) == canonical(formula)
    assert 20 <= refused <= 75


@pytest.mark.parametrize("text", ["(A <-> " * 39 + "B" + ")" * 39, "not (A until " * 20 + "B" + ")" * 20])
def test_a_formula_that_doubles_without_end_is_refused_at_once(text: str) -> None:
    begin = time.perf_counter()
    with pytest.raises(ValueError, match="use several entries"):
        parse_formula(text)
    assert time.perf_counter() - begin < 1


TASK = """name = "cart"
prescribed_time = 10
initial_state = [0.5, 0.5]
[state_space]
lower = [0, 0]
upper = [4, 4]
[initial_set]
lower = [0.4, 0.4]
upper = [0.6, 0.6]
"""
REGIONS = {
    "L": "lower = [0, 0]\nupper = [1.5, 1.5]",
    "A": "lower = [2.5, 2.5]\nupper = [3.5, 3.5]",
    "inner": "lower = [2.8, 2.8]\nupper = [3.2, 3.2]",
    "wide": "lower = [0, 0]\nupper = [3, 3]",
    "touching": "lower = [1.5, 0]\nupper = [2, 1.5]",
    "slope": "normals = [[1, 1]]\noffsets = [3]",
    "both": 'any_of = ["L", "touching"]',
}


def excluded(formula: str, tables: str = "") -> str:
    """Return the problem that is found of a task with this formula and further tables; empty for none."""
    regions = "".join(f'[[region]]\nname = "{name}"\n{lines}\n' for name, lines in REGIONS.items())
    return (excluded_regions(parse_task(f'{TASK}{tables}{regions}[[mission]]\nformula = "{formula}"\n')) or ("", ""))[0]


@pytest.mark.parametrize(
    ("formula", "problem"),
    [
        ("L until A", "A and L must hold at one moment, and they do not meet"),
        ("eventually (A and L)", "A and L must hold at one moment, and they do not meet"),
        ("always L and eventually A", "A and L must hold at one moment, and they do not meet"),
        ("always L and eventually[1, 2] always[0, 1] A", "A and L must hold at one moment, and they do not meet"),
        ("L until touching", "L and touching must hold at one moment, and they do not meet"),
        ("both until A", "A and both must hold at one moment, and they do not meet"),
        ("slope until A", "A and slope must hold at one moment, and they do not meet"),
        ("not A until A", "A and not A must hold at one moment, and they exclude one another"),
        ("not A until inner", "inner and not A must hold at one moment, and inner lies in A"),
        ("wide until A", ""),
        ("not inner until A", ""),
        ("(L or A) until A", ""),
        ("L until A or eventually A", ""),
        ("eventually L and eventually A", ""),
        ("always[0, 2] L and eventually A", ""),
        ("slope until wide", ""),
    ],
)
def test_regions_that_a_mission_needs_at_once_and_cannot_have_are_named(formula: str, problem: str) -> None:
    assert excluded(formula) == problem


def test_a_mission_of_regions_that_do_not_meet_is_refused_with_the_reason() -> None:
    regions = "".join(f'[[region]]\nname = "{name}"\n{REGIONS[name]}\n' for name in ("L", "A"))
    with pytest.raises(stt.NotCertified, match=r"they do not meet; `f until g` asks for f up to and including the moment of g"):
        stt.build(parse_task(f'{TASK}{regions}[[mission]]\nformula = "L until A"\n'))


TARGET = "[target_set]\nlower = [3, 0]\nupper = [4, 1]\n"


@pytest.mark.parametrize(
    ("formula", "problem"),
    [
        ("F G A", "from t_c on the tube stands in the target, and must be in A; they do not meet"),
        ("F always[2, inf] A", "from t_c on the tube stands in the target, and must be in A; they do not meet"),
        ("always (wide -> eventually[0, 4] A)", ""),
        ("always eventually A", "from t_c on the tube stands in the target, and must be in A; they do not meet"),
        ("eventually[10, 10] A", "from t_c on the tube stands in the target, and must be in A; they do not meet"),
        ("F G not corner", "from t_c on the tube stands in the target, and must be in not corner; the target lies in corner"),
        ("eventually A", ""),
        ("F (A and F G not A)", ""),
        ("(A implies L) implies A", "at t = 0 the tube is in the initial set, and must be in A; they do not meet"),
        ("G[0, 2] not L", "at t = 0 the tube is in the initial set, and must be in not L; the initial set lies in L"),
        ("corner until A", "at t = 0 the tube is in the initial set, and must be in corner; they do not meet"),
    ],
)
def test_regions_that_exclude_the_initial_set_or_the_target_are_named(formula: str, problem: str) -> None:
    corner = '[[region]]\nname = "corner"\nlower = [2.7, 0]\nupper = [4, 3]\n'
    assert excluded(formula, TARGET + corner) == problem


@pytest.mark.parametrize(
    ("formula", "reason"),
    [
        ("F G A", "the tube stands in the target, and must be in A; they do not meet"),
        ("F[0, 10 ns] A", "A must hold by 1e-08 s; they do not meet, and the search reaches regions at ends of up to"),
    ],
)
def test_a_refusal_says_what_no_change_of_times_can_mend(formula: str, reason: str) -> None:
    region = f'[[region]]\nname = "A"\n{REGIONS["A"]}\n'
    with pytest.raises(stt.NotCertified, match=reason):
        stt.build(parse_task(f'{TASK}{TARGET}{region}[[mission]]\nformula = "{formula}"\n'), effort=0)


def random_formula(draw: random.Random, depth: int) -> str:
    """Return the text of a formula about A and B with all brackets."""
    if depth == 0 or draw.random() < 0.15:
        return draw.choice(("A", "B", "not A", "not B"))
    window = draw.choice(("", "[0, 2]", "[1, 3]", "[6, 7]", "[7, inf]", "[0, 6]"))
    first, last = (random_formula(draw, depth - 1) for _ in range(2))
    timed = (f"(always{window} {first})", f"(eventually{window} {first})", f"({first} until{window} {last})")
    return draw.choice((*timed, f"({first} and {last})", f"({first} or {last})", f"({first} -> {last})"))


def random_run(draw: random.Random) -> dict[Any, list[tuple[Any, Any]]]:
    """Return when a run is in and out of A and B that stands from 6 s on, as the checker writes it."""
    known: dict[Any, list[tuple[Any, Any]]] = {(side, region): [] for side in ("in", "out") for region in "AB"}
    for region in "AB":
        switches = sorted(draw.sample(range(1, 12), draw.randint(0, 3)))
        sides = draw.choice((("in", "out"), ("out", "in")))
        for k, span in enumerate(pairwise([Fraction(0), *(Fraction(s, 2) for s in switches), math.inf])):
            known[sides[k % 2], region].append(span)
    return known


def test_what_is_needed_at_the_ends_holds_there_in_every_run_that_satisfies_the_formula() -> None:
    draw, satisfied_runs, needed_regions = random.Random(5), 0, 0
    for _ in range(3000):
        formula, known = parse_formula(random_formula(draw, draw.randint(1, 3))), random_run(draw)
        if not any(begin == 0 for begin, _ in checker_formula.satisfied(canonical(formula), known)):
            continue
        satisfied_runs += 1
        for moment, needed in ((0, needed_now(formula)), (1000, needed_finally(formula, Fraction(6)))):
            needed_regions += len(needed)
            for region in needed:
                spans = known["out" if region.is_negated else "in", region.region]
                assert any(begin <= moment <= end for begin, end in spans), str(formula)
    assert satisfied_runs > 300
    assert needed_regions > 300


def canonical(formula: Formula) -> tuple[Any, ...]:
    """Return a formula of the package as the stand-alone checker writes it."""

    def window(over: Interval) -> tuple[Any, Any]:
        return over.begin, math.inf if over.end is None else over.end

    match formula:
        case InRegion(region, is_negated):
            return ("out" if is_negated else "in", region)
        case And(parts) | Or(parts):
            return ("and" if isinstance(formula, And) else "or", *map(canonical, parts))
        case Until(over, first, last):
            return ("until", window(over), canonical(first), canonical(last))
        case Always(over, part) | Eventually(over, part):
            return ("always" if isinstance(formula, Always) else "eventually", window(over), canonical(part))
    raise TypeError(formula)


AS_NAMES = ["G and F", "eventually G", "F until (X and R)", "F U U", "G (U or G)", "F G and not U", "F G and U", "U U[0:3ms] U"]


@pytest.mark.parametrize("text", [*PLAIN, *(write(text) for text in PLAIN for write in DIALECTS.values()), *AS_NAMES])
def test_the_checker_reads_the_same_formula(text: str) -> None:
    for written in (text, f"({text}) <-> dock", f"eventually[2, inf) dock iff ({text})"):
        assert checker_formula.parse(written) == canonical(parse_formula(written))


def test_the_checker_refuses_a_formula_that_doubles_without_end() -> None:
    with pytest.raises(Unusable, match="in good time"):
        checker_formula.parse("(A <-> " * 39 + "B" + ")" * 39)


@pytest.mark.parametrize(("window", "is_read"), [
    ("[9, 9500ms]", False), ("[9ms, 9500]", False), ("[1us:2]", False),
    ("[0, 500ms]", True), ("[0:5us]", True), ("[9s, 9500ms]", True), ("[9, 10s]", True), ("[9s:10]", True), ("[2ms, inf)", True),
])  # fmt: skip
def test_a_unit_at_one_bound_alone_is_refused_where_tools_give_it_to_both(window: str, is_read: bool) -> None:
    """rtamt reads [9, 9500ms] as [9 ms, 9500 ms]."""
    text = f"always{window} A"
    if is_read:
        assert checker_formula.parse(text) == canonical(parse_formula(text))
        return
    with pytest.raises(ValueError, match="give each its own"):
        parse_formula(text)
    with pytest.raises(Unusable, match="a window with one unit"):
        checker_formula.parse(text)
