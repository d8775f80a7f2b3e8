"""Certified prescribed-time reach-avoid-stay controllers in C and Python, from one task.

    import stt_codegen as stt
    controller = stt.build("cart.toml")

The names are those of `stt_codegen.api`, taken from there when they are first used: importing this package costs next to nothing.
"""

from typing import Any

__version__ = "0.1.0"
__all__ = [
    "BadInput", "Box", "Certificate", "Controller", "Finding", "MissingTool", "NotCertified", "SttError", "Task", "UnsafeSet",
    "build", "certify", "design", "load", "parse",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name in __all__:
        from stt_codegen import api

        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
