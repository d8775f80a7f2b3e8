"""Between CasADi and the Program: kernels from CasADi functions, and CasADi functions from a Program."""

from stt_codegen.program.convert.from_casadi import UnknownOpcode, lower
from stt_codegen.program.convert.to_casadi import casadi_function

__all__ = ["UnknownOpcode", "casadi_function", "lower"]
