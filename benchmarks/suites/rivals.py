"""C texts that are measured beside the emitted `control`: CasADi's C of the same law, C written by hand, and a lower limit.

benchmarks/suites/mcu.py runs them. Each text defines <prefix>_control for the emitted header, so that the same image runs it.
CasADi's C does less: it does not test for NaN, and returns no status.
"""

from __future__ import annotations

import re
from typing import Any

import casadi as ca

from stt_codegen.designs import LOWER, require_adaptive, require_refined
from stt_codegen.paper import adaptive_tube, circumvent, control_law, reach_tube, refined_tube
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.targets.c.printer import CPrinter
from stt_codegen.program.targets.template_files import template

_CALLS = re.compile(r"\b(exp|expm1|log|log1p|tanh|sqrt|fabs|fmin|fmax|floor|sinh|cosh|pow)\(")
_LITERAL = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+|\.\d+(?:e[+-]?\d+)?)(?![\w.])")


def casadi_text(controller: EmittedController, single: bool) -> str:
    """Return CasADi's C (casadi_real=float) of (t, [alpha,] x) -> u. single: whether calls and literals are single precision."""
    design = controller.design
    function = _adaptive(controller) if design.is_stateful else _refined(controller)
    generator = ca.CodeGenerator("law", {"casadi_real": "float", "casadi_int": "int"})
    generator.add(function)
    body = generator.dump()
    if single:
        body = _LITERAL.sub(r"\1f", _CALLS.sub(r"\1f(", body))
    p, stateful = controller.task.name, design.is_stateful
    ok = f"{p.upper()}_OK"
    parameters = f"{p}_real t, " + (f"const {p}_real *alpha, " if stateful else "") + f"const {p}_real *x, {p}_real *u"
    arguments = "&t, alpha, x" if stateful else "&t, x"
    sizes = (function.sz_arg(), function.sz_res(), function.sz_iw(), function.sz_w())
    return (
        f'#include "{p}.h"\n{body}\n{p}_status {p}_control({parameters})\n{{\n'
        f"    const float *arg[{sizes[0] + 1}] = {{{arguments}}};\n    float *res[{sizes[1] + 1}] = {{u}};\n"
        f"    int iw[{sizes[2] + 1}];\n    float w[{sizes[3] + 1}];\n    law(arg, res, iw, w, 0);\n    return {ok};\n}}\n"
    )


def _law(controller: EmittedController, i: int, low: Any, high: Any, x: Any) -> Any:
    """Return the law of component i: equation (13) with the clamp."""
    task = controller.task
    width = high - low
    near = width * float((1 - task.e_max[i]) / 2)
    a = ca.fmin(ca.fmax(x - low, near), width - near)
    b = ca.fmin(ca.fmax(high - x, near), width - near)
    epsilon, xi = control_law.transformed_error()(a, b)
    return control_law.law()(float(task.gain[i]), xi, epsilon)


def _refined(controller: EmittedController) -> ca.Function:
    """Return the law with a refined tube as a function of CasADi, (t, x) -> u."""
    design = require_refined(controller.design)
    n, k = design.dimension, design.segments
    t, x = ca.MX.sym("t"), ca.MX.sym("x", n)
    table = ca.MX(ca.DM([float(v * design.unit) for row in design.table for pair in row for v in pair]))
    u = ca.fmin(ca.fmax(t, 0) * float(k / design.prescribed_time), k)
    segment = ca.fmin(ca.floor(u), k - 1)
    w = refined_tube.basis()(u - segment)
    result = []
    for i in range(n):
        edges: list[Any] = []
        for side in (0, 1):
            q = [table[segment * (2 * n) + (2 * n * j + 2 * i + side)] for j in range(4)]
            edges.append(refined_tube.blend()(w, ca.vertcat(*q)))
        result.append(_law(controller, i, edges[0], edges[1], x[i]))
    return ca.Function("law", [t, x], [ca.vertcat(*result)])


def _adaptive(controller: EmittedController) -> ca.Function:
    """Return the law with an adaptive tube as a function of CasADi, (t, alpha, x) -> u."""
    design = require_adaptive(controller.design)
    n, t_c, nu = design.dimension, float(design.prescribed_time), float(design.nu)
    t, alpha, x = ca.SX.sym("t"), ca.SX.sym("alpha", 2 * n), ca.SX.sym("x", n)
    clamped_time = ca.fmin(ca.fmax(t, 0), t_c)
    sigma = reach_tube.profile()(clamped_time, t_c)
    result = []
    for i in range(n):
        rho = [reach_tube.reach_edge()(float(design.start[i][s]), float(design.target[i][s]), sigma) for s in (0, 1)]
        beta = []
        for side in (0, 1):
            total = ca.SX(0)
            for b in design.bumps_on(i, side):
                shape = [float(v) for v in (b.height, b.steepness, b.middle, b.radius, circumvent.CUT["float"])]
                total = circumvent.join()(total, circumvent.circumvent()(clamped_time, *shape), nu)
            beta.append(float(design.walls[i][side]) + (total if side == LOWER else -total))
        low = adaptive_tube.lower_edge()(rho[0], alpha[i], beta[0], nu)
        high = adaptive_tube.upper_edge()(rho[1], alpha[n + i], beta[1], nu)
        result.append(_law(controller, i, low, high, x[i]))
    return ca.Function("law", [t, alpha, x], [ca.vertcat(*result)])


def hand_text(controller: EmittedController) -> str:
    """Return a refined `control` as one writes it by hand, with every test of the emitted one; all components have one gain."""
    design, program = require_refined(controller.design), controller.program
    task, printer = controller.task, CPrinter(program)
    return template("bench/hand.c.j2").render(
        prefix=program.prefix,
        macro=program.prefix.upper(),
        table=printer.table(program.table("coefficients")),
        segments=design.segments,
        rate=f"{float(design.segments / design.prescribed_time):.9g}F",
        t_c=f"{float(design.prescribed_time)!r}F",
        near=f"{float((1 - task.e_max[0]) / 2):.9g}F",
        gain=f"{float(task.gain[0]):.9g}F",
    )


def floor_text(controller: EmittedController) -> str:
    """Return a `control` with one division and one logarithm per component, and nothing else: a lower limit of the cost."""
    p = controller.task.name
    size = f"{p.upper()}_N"
    return (
        f'#include "{p}.h"\n#include <math.h>\n{p}_status {p}_control(float t, const float x[{size}], float u[{size}])\n{{\n'
        f"    for (int i = 0; i < {size}; i++) {{\n        u[i] = logf(x[i] / t);\n    }}\n    return {p.upper()}_OK;\n}}\n"
    )
