"""Readers that turn a Program into SymPy formulas, along a path or branch by branch."""

from stt_codegen.program.symbolic.paths import follow, follow_kernel, formulas_on, kernel_formulas
from stt_codegen.program.symbolic.symbols import branches, formulas

__all__ = ["branches", "follow", "follow_kernel", "formulas", "formulas_on", "kernel_formulas"]
