"""The certificate against the task, the C and the header: its hashes, its numbers and its claims."""

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

from . import controller, files, inertia, limits, period, source
from . import tube as tubes
from .exact import Numbers, fractions, integers, require, rounded, units_above
from .law import Law
from .rounding import arithmetic_error
from .starts import covered_starts
from .task import Task

BITS = {"float": 24, "double": 53, "fixed": 20}
LAW_ERROR = {  # by scalar and whether the logarithm is inline, see docs/certificate-format.md
    ("float", False): Fraction(1, 1 << 19), ("double", False): Fraction(1, 1 << 46), ("fixed", False): Fraction(1, 1 << 10),
    ("float", True): Fraction(1, 1 << 14), ("double", True): Fraction(1, 1 << 14),
}  # fmt: skip
CUT_LIMIT = 1 << 20  # of a segment into parts
KEYS = "format task certified design method order scalar sha256 grid edge_error speed start covers_initial_set control claims"


def same(value: Any, wanted: Any) -> bool:
    """Return whether two values of JSON are equal and have equal types: True is not 1."""
    return json.dumps(value, sort_keys=True) == json.dumps(wanted, sort_keys=True)


def check(task: Task, certificate: dict[str, Any], text: bytes, folder: Path) -> str:
    """Return what is proved, in words; raise `Refused` where something is not as the certificate claims. text: the C; folder:
    that of the header and the files beside it."""
    scalar = _check_keys(task, certificate)
    bits = BITS[scalar]
    if task.turns:
        task.turns.add_noise(bits)
    if task.leaves_limit:
        task.u_max = _read_limits(task, certificate["control"])
    unit, cuts, seam = _check_grid(certificate["grid"], task)
    if scalar == "fixed":
        from .integers import Integers

        integer_controller: Any = Integers(text, task, certificate["integers"])
        entries = [v * unit for v in integer_controller.tables["coefficients"]]
    else:
        integer_controller, entries = None, source.real_table(text, f"{task.name}_coefficients", bits)
    tube = tubes.Tube(entries, task.n, unit, task.t_c, seam)
    if task.assumes_plant:
        task.assume_plant([tube.speed(i) for i in range(task.n)])
    segments = certificate["grid"]["segments"]
    require(segments == tube.segments and task.segments in (None, segments), "the C has another number of segments")

    # the law's constants, how far the arithmetic moves edges and rates (P7), and the start
    law = _read_law(task, tube, certificate, integer_controller)
    _check_start(task, tube, certificate)

    # P1 to P6, P8 and P10, in the order of the claims
    claims, edge_error = list(certificate["claims"]), max(law.edge_claims)
    require(all(type(claim) is dict for claim in claims), "a claim is no object")
    tubes.prove(task, tube, claims, cuts, edge_error)
    if task.order == 2:
        inertia.prove(task, tube, claims, cuts, law)
    elif task.proves_limits:
        limits.prove(task, tube, claims, cuts, bits)
    if "mission" in task.document:
        from .mission import Mission

        clock_error = integer_controller.clock_error / segments if integer_controller else Fraction(4, 1 << bits)
        Mission(task).prove(tube, edge_error, (claims, cuts), certificate["mission"], clock_error)
    else:
        require(not claims, "the certificate claims more than is known here")

    # P9, and the files
    if task.period is not None:
        _check_sampling(task, tube, certificate["sampled"], law)
    files.check_hashes(task, certificate["sha256"], text, folder)
    listed, beside = files.files_of(task, certificate["sha256"])
    has_phase, starts = f"{task.name}_phase.c" in beside, covered_starts(task, tube, law)
    if integer_controller:  # in integers: no value leaves 32 bits, and u is (13)
        options, values = integer_controller.prove(tube, law, certificate["grid"]["unit_bits"], has_phase, starts)
    else:
        options, values = controller.options_of(task, law, has_phase), controller.values_of(task, tube, law, starts)
    values["hash"] = files.design_hash(task, tube, law, certificate["grid"]["unit_bits"])
    files.check_listings(task, law, text, folder, files=listed, options=options, values=values)
    properties = {"P1 to " + ("P8" if task.proves_limits else "P7"): True, "P9": task.period, "P10": "mission" in task.document}
    proved = " and ".join(name for name, is_proved in properties.items() if is_proved)
    return f"{proved} hold, and the C is the listing of this tube and this law; {segments} segments, {task.n} dimensions"


def _read_limits(task: Task, control: dict[str, Any]) -> Numbers:
    """Return the limits of u that the certificate chooses, which all proofs take; the C must have them."""
    chosen, stated, norm = fractions(control["u_max"], task.n), task.stated_u_max, task.u_norm
    is_allowed = min(chosen) > 0 and all(a <= b for a, b in zip(chosen, stated or chosen, strict=True))
    require(is_allowed, "the certificate's u_max is not positive, or above the task's")
    is_within = norm is None or sum(v * v for v in chosen) <= norm * norm
    require(is_within, "the certificate's u_max allows a u whose norm is above u_norm")
    return chosen


def _check_keys(task: Task, certificate: dict[str, Any]) -> str:
    """Require the keys that are known, and what they repeat of the task. Return the scalar."""
    stated = {"sampled": task.period is not None, "mission": "mission" in task.document, "clock": task.clock is not None}
    stated |= {"filter": task.order == 2, "rate_error": task.order == 2, "integers": certificate.get("scalar") == "fixed"}
    keys = {*KEYS.split(), *(key for key, is_stated in stated.items() if is_stated)}
    require(certificate.get("format") != 2, "the certificate has format 2; make it again with a newer stt-codegen")
    require(
        {*certificate} == keys, f"the certificate lacks a key or has an unknown one: {', '.join(sorted({*certificate} ^ keys))}"
    )
    wanted: dict[str, Any] = {"format": 3, "task": task.name, "certified": True, "method": "exact", "order": task.order}
    for key, value in (wanted | ({"clock": task.clock} if task.clock else {})).items():
        require(same(certificate[key], value), f"the certificate's {key} is {certificate[key]!r:.80}; it must be {value!r:.80}")
    scalar = certificate["scalar"]
    require(scalar in BITS, "the scalar is unknown here")
    require(scalar != "fixed" or not task.turns, "a controller in integers with axes that close is unknown here")
    return str(scalar)


def _check_grid(grid: Any, task: Task) -> tuple[Fraction, int, int | None]:
    """Return the unit of the table, the parts of a segment, and the seam of a tube that repeats."""
    require(
        {*grid} == {"segments", "cuts", "unit_bits", *(["seam"] if task.repeats else [])}, "the certificate's grid is unknown"
    )
    has_integers = all(type(v) is int for v in grid.values()) and abs(grid["unit_bits"]) < 200
    require(has_integers, "the certificate's grid is not of whole numbers")
    cuts = grid["cuts"]
    require(0 < cuts <= CUT_LIMIT and cuts & (cuts - 1) == 0, f"cuts is no power of two up to {CUT_LIMIT}")
    return Fraction(2) ** -grid["unit_bits"], cuts, grid.get("seam")


def _read_law(task: Task, tube: tubes.Tube, certificate: dict[str, Any], integer_controller: Any) -> Law:
    """Return the law of the certificate, with P7 computed here. integer_controller: None where the C is in floating point."""
    scalar, bits = certificate["scalar"], BITS[certificate["scalar"]]
    gain, filters = _check_constants(task, certificate, bits, scalar)
    if integer_controller:
        integer_controller.check_clock(tube)
    error_of = integer_controller.arithmetic_error if integer_controller else arithmetic_error
    edge_error, rate_error = error_of(tube, bits), error_of(tube, bits, 1) if task.order == 2 else []
    edge_claims = integers(certificate["edge_error"], task.n)
    rate_claims = integers(certificate["rate_error"], task.n) if task.order == 2 else []
    for name, error, stated, unit in (
        ("edge_error", edge_error, edge_claims, tube.unit),
        ("rate_error", rate_error, rate_claims, tube.unit * tube.segments / task.t_c),
    ):
        is_enough = all(units_above(v, unit) <= c for v, c in zip(error, stated, strict=True))
        require(is_enough, f"P7 does not hold: the arithmetic moves an edge or a rate by more than {name} says")
    rounding = LAW_ERROR[scalar, task.inline]
    return Law(scalar, bits, gain, filters, rounding, edge_error, rate_error, edge_claims, rate_claims)


def _check_constants(task: Task, certificate: Any, bits: int, scalar: str) -> tuple[Numbers, Numbers]:
    """Return gains and filters (lambda, for order 2) of the certificate: the task's, or chosen where the task leaves them
    open."""
    control = certificate["control"]
    norm = {} if task.u_norm is None else {"u_norm": str(task.u_norm)}
    is_known = {*control} == {"gain", "e_max", "u_max", *norm} and all(same(control[k], v) for k, v in norm.items())
    require(is_known, "the certificate's control is unknown, or its u_norm is not the task's")
    gain = fractions(control["gain"], task.n)
    require(task.gain in (None, gain), "the certificate's gain is not the task's")
    is_signed = min(gain) > 0 or (task.gain is not None and max(gain) < 0)  # a gain that was chosen is positive
    require(is_signed, "the certificate's gains are not of one sign, or not positive")
    require(fractions(control["e_max"], task.n) == task.e_max, "the certificate's e_max is not the task's")
    stated = [] if control["u_max"] is None else fractions(control["u_max"], task.n)
    require(stated == limits.emitted_limits(task, bits), "the certificate's u_max is not the task's, as the C has it")
    if task.order == 1:
        return gain, []
    filters = fractions(certificate["filter"], task.n)

    def emitted(s: Fraction) -> Fraction:
        return Fraction(round(s * (1 << 14)), 1 << 14) if scalar == "fixed" else rounded(s, bits)

    is_number = min(filters) > 0 and (scalar == "fixed" or all(emitted(s) == s for s in filters))
    is_stated = task.filter is None or [emitted(s) for s in task.filter] == filters
    require(is_number and is_stated, "the certificate's filter is not the task's, or no number of the C")
    return gain, filters


def _check_start(task: Task, tube: tubes.Tube, certificate: Any) -> None:
    """Require what the certificate says about the tube's speed and its start."""
    speed = [tube.fastest(i) for i in range(task.n)]
    require(integers(certificate["speed"], task.n) == speed, "the certificate's speed is not the tube's")
    require(same(certificate["start"], [list(v) for v in tube.start]), "the certificate's start is not the tube's")
    lack = [
        max(s[0] * tube.unit - a, b - s[1] * tube.unit) * 1000 - (b - a) for s, a, b in zip(tube.start, *task.start, strict=True)
    ]
    require(certificate["covers_initial_set"] is (max(lack) <= 0), "the certificate's covers_initial_set is wrong")


def _read_paths(claim: Any, n: int) -> list[tuple[Fraction, Fraction | None]]:
    """Return by component how near its paths come to an edge, and over how many seconds bounds count; None: from the start on."""
    is_list = isinstance(claim, list) and len(claim) == n and all({*v} == {"nearest", "history"} for v in claim)
    require(is_list, "the certificate's path is unknown")
    nearest = fractions([entry["nearest"] for entry in claim], n)
    histories = [None if entry["history"] is None else fractions([entry["history"]], 1)[0] for entry in claim]
    require(all(v is None or v > 0 for v in histories), "a path's history is not positive")
    return [*zip(nearest, histories, strict=True)]


def _check_sampling(task: Task, tube: Any, claim: Any, law: Law) -> None:
    """Require the claim about samples, and prove P9."""
    wanted: dict[str, Any] = {"period": str(task.period), "latency": str(task.latency), "share": str(task.share)}
    wanted |= {"plant": task.stated} | ({"period_min": str(task.shortest)} if task.differs else {})
    require({*claim} - {"path"} == {"rho", "u", "shift", *wanted}, "the certificate's `sampled` is unknown")
    for key, value in wanted.items():
        require(same(claim[key], value), f"the certificate's sampled {key} is not the task's")
    rho, u, shift = (fractions(claim[key], task.n) for key in ("rho", "u", "shift"))
    require(min(rho) > 1, "P9 does not hold: rho is not above 1")
    smallest = period.shifts(task, tube, law)
    require(
        all(a <= b for a, b in zip(smallest, shift, strict=True)),
        "P9 does not hold: the law sees a larger error than `shift` says",
    )
    for x, (a, b) in zip(task.state, tube.start, strict=True):
        is_inside = abs(2 * x / tube.unit - a - b) <= task.share * (b - a)
        require(is_inside, "P9 does not hold: initial_state is outside the start share")
    if "path" in claim:
        largest = period.prove_paths(task, tube, law, _read_paths(claim["path"], task.n), (rho, u, shift))
    else:
        require(not task.is_late, "P9 does not hold: inputs act late, and the certificate has no path for them")
        largest = period.prove(task, tube, law, rho, shift)
    require(all(a <= b for a, b in zip(largest, u, strict=True)), "P9 does not hold: |u| may be more than is claimed")
    period.prove_guard(task, tube, law, rho, shift)
    if task.turns:
        task.turns.prove_steps(tube, [v * (1 + 2 * nu) for v, nu in zip(u, task.drive.opposite, strict=True)], law.filters)
