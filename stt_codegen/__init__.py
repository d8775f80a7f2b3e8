"""Certified prescribed-time reach-avoid-stay controllers in C and Python, from one task.

    import stt_codegen as stt
    controller = stt.build("cart.toml")

The names are those of `stt_codegen.api`. Their first use imports it; importing this package alone takes no time.
"""

import sys
from types import ModuleType
from typing import Any

__version__ = "0.1.0"
__all__ = [
    "BadInput", "Box", "Certificate", "Controller", "Finding", "MissingTool", "NotCertified", "SttError", "Task",
    "UnsafeBall", "UnsafeCapsule", "UnsafeHalfSpaces", "UnsafePolytope", "UnsafeSet",
    "build", "certify", "certify_tube", "design", "load", "parse",
]  # fmt: skip


class _Face(ModuleType):
    """A module whose functions `design` and `certify` come before the folders of the same names.

    Python sets an imported folder as an attribute of its package. A property stays in front of it.
    """

    def __getattr__(self, name: str) -> Any:
        if name in __all__:
            from stt_codegen import api

            return getattr(api, name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it has {', '.join(__all__)}")

    def __dir__(self) -> list[str]:
        return [*__all__, "__version__"]


def _function(name: str) -> property:
    return property(lambda self: self.__getattr__(name), lambda _self, _folder: None)


for _name in ("certify", "design"):
    setattr(_Face, _name, _function(_name))
sys.modules[__name__].__class__ = _Face
