"""The command line: the commands, and the exit code of each error.

0 good, 1 drift or a failed comparison, 2 bad input, 3 not certified or infeasible, 4 a needed tool is missing, 5 internal.
One command a file; imports stay inside the commands, so that --help answers at once.
"""

from __future__ import annotations

import os
import sys
import warnings
from contextlib import suppress
from typing import Annotated, Any

import typer

from stt_codegen.cli import check_commands, design_commands
from stt_codegen.cli.options import print_json, say
from stt_codegen.cli.streams import discard, prepare_streams
from stt_codegen.errors import SttError

app = typer.Typer(
    name="stt-codegen",
    help="Certified prescribed-time reach-avoid-stay controllers in C and Python, from one TOML file.",
    rich_markup_mode=None,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for _command in (*design_commands.COMMANDS, *check_commands.COMMANDS):
    app.command(_command.__name__.rstrip("_"))(_command)


def _version(is_requested: bool) -> None:
    if is_requested:
        from stt_codegen import __version__

        print(f"stt-codegen {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version and leave")
    ] = False,
) -> None:
    pass


# Typer raises Click's UsageError for a wrong command line. It does not export that class, only a subclass.
UsageError: Any = typer.BadParameter.__mro__[1]


def _exit_code(commands: typer.Typer, program: str) -> int:
    """Run the command and return its exit code. `app()` would return 1 for a closed pipe, so the context is made here."""
    command = typer.main.get_command(commands)
    try:
        with command.make_context(program, sys.argv[1:]) as context:
            command.invoke(context)
        return 0
    except typer.Exit as end:
        return end.exit_code
    finally:
        sys.stdout.flush()


def main() -> None:
    """Run `stt-codegen`."""
    run(app, "stt-codegen")


def run(commands: typer.Typer, program: str) -> None:
    """Run a command line; every `SttError` becomes one message and its exit code (with --json also one document).

    Warnings of libraries are for developers: STT_CODEGEN_DEBUG=1 shows them.
    """
    prepare_streams()
    is_debug = bool(os.environ.get("STT_CODEGEN_DEBUG"))
    if not is_debug:
        warnings.simplefilter("ignore")
    try:
        code = _exit_code(commands, program)
    except BrokenPipeError:  # the reader closed the pipe, which is no error
        discard(sys.stdout)
        code = 0
    except KeyboardInterrupt:
        code = 130
    except Exception as error:
        if is_debug and not isinstance(error, (UsageError, SttError, OSError)):
            raise
        code = _report(error, program)
    sys.exit(code)


def _report(error: Exception, program: str) -> int:
    """Print the message of an error, with --json also as a document, and return its exit code."""
    if isinstance(error, UsageError):
        text, code = error.format_message(), 2
        with suppress(OSError):
            error.show()
    elif isinstance(error, SttError):
        text, code = str(error), error.exit_code
        say(f"{program}: {text}")
    elif isinstance(error, OSError):
        # files of a task are read and written by files/, which says which; a stream has no name
        problem = f"{error.filename}: cannot be read or written" if error.filename else "the output cannot be written"
        text, code = f"{problem} ({error.strerror})", 2
        say(f"{program}: {text}")
    elif isinstance(error, MemoryError):
        text, code = "the memory is not enough for this task; try a smaller one, or a machine with more", 2
        say(f"{program}: {text}")
    else:
        text, code = f"internal error: {type(error).__name__}: {error}", 5
        say(f"stt-codegen: {text}; please report it with the traceback that STT_CODEGEN_DEBUG=1 shows")
    try:
        if "--json" in sys.argv:
            print_json({"error": text, "exit_code": code})
        sys.stdout.flush()
    except OSError:
        discard(sys.stdout)
    return code
