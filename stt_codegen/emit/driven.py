"""C for closed loops of the emitted C: an adapter with one interface in doubles for every kind of controller, and a plant printed
from its kernel (templates/loop/). `loop/`, the report's page and ROS packages use it."""

from __future__ import annotations

from stt_codegen.certify import Certificate
from stt_codegen.certify.missions import cycle_of
from stt_codegen.controller.integers import build_integer_law
from stt_codegen.designs import Design, require_refined, uncertified_alpha_step
from stt_codegen.emit.integers import power_of_two
from stt_codegen.emit.naming import file_names, guard_name, wrap_name
from stt_codegen.plants import Model, model
from stt_codegen.program import Program, round_to, shortest
from stt_codegen.program.convert import lower
from stt_codegen.program.targets.c import CPrinter
from stt_codegen.program.targets.template_files import template
from stt_codegen.task import Task


def driven_sources(task: Task) -> list[str]:
    """Return the names of the emitted C files that a closed loop compiles."""
    guard = [guard_name(task.name)] if task.control.outside != "return" else []
    return [file_names(task.name).source, *guard, *([wrap_name(task.name)] if task.repeat else [])]


def cycle_literal(design: Design) -> str | None:
    """Return the length of the cycle of a tube that repeats itself, seconds, as a literal of a double; else None."""
    cycle = cycle_of(design)
    return None if cycle is None else shortest(round_to(cycle.length, "double"), "double")


def adapter_source(task: Task, design: Design, certificate: Certificate) -> str:
    """Return the C of `loop_own_step`, `loop_own_tube`, `loop_own_margin` and the rest of templates/loop/adapter.c.j2."""
    if task.emit.scalar == "fixed":
        refined = require_refined(design)
        u_bits = build_integer_law(task, refined).u_bits
        return template("loop/adapter_fixed.c.j2").render(
            prefix=task.name, macro=task.name.upper(), order=task.order, x_scale=power_of_two(refined.bits),
            u_scale=power_of_two(u_bits), t_c=repr(float(task.prescribed_time)), segments=refined.segments,
            rows=len(refined.table), filter=[repr(float(v)) for v in refined.filter],
            table=[[f"{v}.0" for v in row] for row in refined.integers().reshape(len(refined.table), -1)],
        )  # fmt: skip
    steps = certificate.steps
    longest_step = repr(float(steps[1])) if steps is not None else repr(float(uncertified_alpha_step(task.prescribed_time)))
    return template("loop/adapter.c.j2").render(
        prefix=task.name, macro=task.name.upper(), is_stateful=design.is_stateful, longest=longest_step, order=task.order,
        outside=task.control.outside, differs=task.uses_differences, cycle=cycle_literal(design),
    )  # fmt: skip


def plant_source(plant: Model, n: int, order: int) -> str:
    """Return the C of `loop_plant`: f and g of a plant in n dimensions, in double."""
    kernel = lower(model(plant, n, order))
    lines = CPrinter(Program("plant", n, "double", (), (kernel,), functions=())).kernel(kernel)
    outputs = [f"f + {i}" for i in range(n)] + [f"g + {i}" for i in range(n * n)]
    sizes = {"x": order * n, "p": len(plant.constants), "sample": n if plant.mixing else 0}
    inputs = [f"{name}[{i}]" for name, size in sizes.items() for i in range(size)]
    arguments = ", ".join([*inputs, *outputs])
    return template("loop/plant.c.j2").render(kernel="\n".join(lines), arguments=arguments)
