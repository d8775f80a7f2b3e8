"""The command line: the commands, and the exit code of each error.

0 good, 1 drift or a failed comparison, 2 bad input, 3 not certified or infeasible, 4 a needed tool is missing, 5 internal.
One command a file; imports stay inside the commands, so that --help answers at once.
"""

from __future__ import annotations

import os
import sys
import warnings
from typing import Annotated, Any

import typer

from stt_codegen.cli import check_commands, design_commands
from stt_codegen.cli.options import print_json, say
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
    if not os.environ.get("STT_CODEGEN_DEBUG"):
        warnings.simplefilter("ignore")
    try:
        sys.exit(_exit_code(commands, program))
    except UsageError as error:
        error.show()
        if "--json" in sys.argv:
            print_json({"error": error.format_message(), "exit_code": 2})
        sys.exit(2)
    except SttError as error:
        say(f"{program}: {error}")
        if "--json" in sys.argv:
            print_json({"error": str(error), "exit_code": error.exit_code})
        sys.exit(error.exit_code)
    except BrokenPipeError:  # the reader closed the pipe, which is no error
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except OSError as error:
        say(f"{program}: the output cannot be written ({error.strerror})")
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception as error:
        if os.environ.get("STT_CODEGEN_DEBUG"):
            raise
        say(
            f"stt-codegen: internal error: {type(error).__name__}: {error}; "
            "please report it with the traceback that STT_CODEGEN_DEBUG=1 shows"
        )
        sys.exit(5)
