"""Where the templates are, and how they are read. Those of a target language are in its folder, the rest in templates/."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import jinja2

PACKAGE = Path(__file__).parents[2]


def template_folder() -> Path:
    """Return the folder of the templates of no target language: inside the installed package, or beside it in a checkout."""
    inside = PACKAGE / "templates"
    return inside if inside.is_dir() else PACKAGE.parent / "templates"


@cache
def _environment() -> jinja2.Environment:
    """Return the environment that reads templates; an undefined name in one is an error."""
    folders = [PACKAGE / "program" / "targets", template_folder()]
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(folders, encoding="utf-8"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        newline_sequence="\n",
        autoescape=False,
    )


def template(name: str) -> jinja2.Template:
    """Return a template by its path: `rust/controller.rs.j2` of a target language, `loop/plant.c.j2` of templates/.

    Undefined names are errors."""
    return _environment().get_template(name)
