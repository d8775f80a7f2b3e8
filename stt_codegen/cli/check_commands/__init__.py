"""Commands that check a controller, a file each; `COMMANDS` lists them."""

from stt_codegen.cli.check_commands.certify import certify
from stt_codegen.cli.check_commands.check import check
from stt_codegen.cli.check_commands.compare import compare
from stt_codegen.cli.check_commands.lag import lag
from stt_codegen.cli.check_commands.pil import pil
from stt_codegen.cli.check_commands.prove import prove
from stt_codegen.cli.check_commands.theorem import theorem

__all__ = ["COMMANDS"]

COMMANDS = (check, certify, compare, lag, pil, prove, theorem)
