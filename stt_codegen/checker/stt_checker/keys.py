"""The keys of a task file. One that is unknown here is refused: it might change what the task asks for."""

from fractions import Fraction
from typing import Any

from .exact import Unusable

SET_KEYS = "lower upper vertices normals offsets centre segment radius"
KNOWN_KEYS = {
    "": "name axes units periodic prescribed_time repeat start_delay initial_state body state_space initial_set target_set "
        "unsafe region mission tube control emit plant",
    "state_space": "axes lower upper vertices normals offsets", "initial_set": "lower upper share speed",
    "target_set": "axes lower upper vertices normals offsets centre radius motion",
    "unsafe": f"name axes motion during timing spread {SET_KEYS}",
    "region": f"name any_of axes {SET_KEYS}",
    "mission": "visit between stay then within never before patrol every until formula",
    "tube": "design clearance min_width prefer max_speed max_acceleration filter segments seed adaptive",
    "control": "gain rest reserve e_max u_max u_norm period latency outside velocity period_min saturate",
    "emit": "scalar math tick_period selftest rust",
    "plant": "order f_max w_max g_min g_max g_cross noise noise_v lag lag2 slew overshoot exact",
}  # fmt: skip
LISTS = ("unsafe", "region", "mission")


def canonical(value: Any) -> Any:
    """Return the data that the task's digest is taken of: every number as a reduced fraction."""
    if isinstance(value, dict):
        return {k: canonical(v) for k, v in value.items()}
    if isinstance(value, list):
        return [canonical(v) for v in value]
    return value if isinstance(value, bool | str) else "{}/{}".format(*Fraction(value).as_integer_ratio())


def refuse_unknown_keys(document: dict[str, Any]) -> None:
    space = document.get("state_space")
    source = "a map" if "map" in document else "an outline" if isinstance(space, dict) and "outline" in space else None
    if source is not None:
        raise Unusable(f"the task has {source}; give the .task.toml beside the C, where its sets are spelled out")
    tables = [(name, entry) for name, v in document.items() for entry in (v if name in LISTS else [v])]
    for name, entry in [("", document), *((name, entry) for name, entry in tables if name in KNOWN_KEYS)]:
        unknown = {*entry} - {*KNOWN_KEYS[name].split()}
        if unknown:
            raise Unusable(f"the task has {min(unknown)!r}, which is unknown here")
