"""`python -m stt_codegen.cli`."""

from stt_codegen.cli.main import main

main()
