"""Commands that read a task and write or show something, a file each; `COMMANDS` lists them."""

from stt_codegen.cli.design_commands.design import design
from stt_codegen.cli.design_commands.generate import generate
from stt_codegen.cli.design_commands.maps import map_
from stt_codegen.cli.design_commands.report import report
from stt_codegen.cli.design_commands.schema import schema
from stt_codegen.cli.design_commands.simulate import simulate

__all__ = ["COMMANDS"]

COMMANDS = (design, generate, simulate, report, map_, schema)
