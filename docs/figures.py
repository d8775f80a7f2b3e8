"""Draws the pictures in docs/: python docs/figures.py (from the project's folder)."""

from pathlib import Path

from stt_codegen.picture import draw, draw_beside
from stt_codegen.pipeline import build

HERE = Path(__file__).parent
TASKS = HERE.parent / "tasks"


def main() -> None:
    draw(build(TASKS / "omni_s2.toml"), HERE / "omni_s2.png")
    pair = [build(TASKS / "omni_s1.toml", design, uncertified=True) for design in ("literal", "refined")]
    draw_beside(pair, ["as printed: (5)-(11)", "as shipped: refined, certified"], HERE / "literal_beside_refined.png")


if __name__ == "__main__":
    main()
