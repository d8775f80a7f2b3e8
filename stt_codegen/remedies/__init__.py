"""What to change where a task is refused: options of the task file, each tried to the end, the cheapest change first."""

from stt_codegen.remedies.remedy_search import CertificationTests, find_remedies

__all__ = ["CertificationTests", "find_remedies"]
