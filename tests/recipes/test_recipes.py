"""A sample follows each recipe of CONTRIBUTING.md in a copy of the repository.

The sample changes exactly the places that the recipe names, and the addition works from end to end.
"""

from __future__ import annotations

import json
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from stt_codegen.program.targets.c.runner import STRICT
from tests.support.controllers import ROOT
from tests.support.recipes import (
    PAGE,
    Sample,
    changed_files,
    copy_of_the_repository,
    follow_recipe,
    mismatches,
    places_to_change,
    run_in_copy,
    run_pytest_in_copy,
    section,
)

TARGETS = "stt_codegen/program/targets"
CHECKER = "stt_codegen/checker/stt_checker"
SET = Sample(
    "A set",
    files="set",
    edits={
        "stt_codegen/task/sets/shapes.py": [
            (
                "from stt_codegen.task.sets.polytopes import",
                "from stt_codegen.task.sets.diamonds import Diamond\nfrom stt_codegen.task.sets.polytopes import",
            ),
            (
                "@cache\ndef corners_of_cut_box",
                '''class UnsafeDiamond(Unsafe):
    """All points whose distances from a middle, by dimension, sum up to no more than a reach."""

    point_fields = ("middle",)
    middle: Vector
    reach: Positive

    def vectors(self) -> list[tuple[str, Vector]]:
        return [("middle", self.middle)]

    def problem(self) -> str | None:
        return None

    def half_spaces(self) -> Sequence[HalfSpace]:
        return Diamond(self.middle, self.reach).faces

    def to_convex_set(self, _lower: Vector, _upper: Vector) -> ConvexSet:
        return Diamond(self.middle, self.reach, self.name)


@cache
def corners_of_cut_box''',
            ),
            (
                '    "radius": UnsafeBall,\n',
                '    "radius": UnsafeBall,\n    "middle": UnsafeDiamond,\n    "reach": UnsafeDiamond,\n',
            ),
        ],
        f"{CHECKER}/keys.py": [('offsets centre segment radius"\n', 'offsets centre segment radius middle reach"\n')],
        f"{CHECKER}/sets.py": [
            ('{"vertices"}, {"normals", "offsets"},', '{"middle", "reach"}, {"vertices"}, {"normals", "offsets"},'),
            ("FORMS[1:4])", "FORMS[1:5])"),
            (
                '        if "centre" in table:\n',
                """        if "middle" in table:
            middle, reach = vector(table["middle"], d), number(table["reach"])
            for signs in itertools.product((Fraction(-1), Fraction(1)), repeat=d):
                listed.append((list(signs), dot(signs, middle) + reach))
        if "centre" in table:
""",
            ),
            (
                '        elif "normals" in form:\n',
                """        elif "middle" in form:
            centre, reach = vector(table["middle"], d), number(table["reach"])
            corners = [[v + s * reach * (k == i) for k, v in enumerate(centre)] for i in range(d) for s in (-1, 1)]
        elif "normals" in form:
""",
            ),
        ],
        "stt_codegen/theorem/controller_theorem.py": [
            ('"unsafe": "motion during timing spread",', '"unsafe": "motion during timing spread middle reach",')
        ],
        "docs/task.md": [
            ("| `centre`, `radius` | | a ball |", "| `middle`, `reach` | | a diamond |\n| `centre`, `radius` | | a ball |")
        ],
        "tests/task/test_shapes.py": [
            ('    "ball": (SPACE,', '    "diamond": (FLAT, ("middle = [2.5, 2.4]\\nreach = 1.5",)),\n    "ball": (SPACE,'),
            (
                '    "centre radius": (',
                '    "middle reach": ("middle = [2.5, 2.5]\\nreach = 9", "middle = [4.5, 0.5]\\nreach = 0.4"),\n    "centre radius": (',
            ),
            (
                "    axes, d = task.axis_indices(unsafe), len(lower)\n",
                """    axes, d = task.axis_indices(unsafe), len(lower)
    if hasattr(unsafe, "reach"):  # the hull of its corners
        (x, y), r = unsafe.middle, unsafe.reach
        unsafe = UnsafePolytope(vertices=[(x - r, y), (x + r, y), (x, y - r), (x, y + r)])
""",
            ),
        ],
    },
)
OPERATION = Sample(
    "An operation",
    edits={
        "stt_codegen/program/operations.py": [
            (
                '    "neg": _exact(',
                """    "hypot": Operation(
        (REAL, REAL), REAL, "math", math.hypot, call="hypot", casadi=("OP_HYPOT",), ball="({0} * {0} + {1} * {1}).sqrt()",
        ulps=LIBRARY_ULPS, formula=lambda sp, a, b: sp.sqrt(a**2 + b**2), commutes=True,
        spread=lambda np, a, b: (np.hypot(a.value, b.value), np.hypot(a.error, b.error)),
    ),
    "neg": _exact(""",
            )
        ],
        "tests/program/test_program.py": [
            ('    "constpow": (', '    "hypot": (lambda a, b: ca.hypot(a, b), POINTS, 1),\n    "constpow": (')
        ],
    },
)
LANGUAGE = Sample(
    "A target language",
    files="language",
    edits={
        f"{TARGETS}/registry.py": [
            ("import c, python, rust", "import c, javascript, python, rust"),
            ("python.TARGET, rust.TARGET)", "python.TARGET, rust.TARGET, javascript.TARGET)"),
        ],
        f"{CHECKER}/keys.py": [("tick_period selftest rust", "tick_period selftest rust javascript")],
        f"{CHECKER}/files.py": [('OTHER_LANGUAGES = (".rs",)', 'OTHER_LANGUAGES = (".rs", ".js")')],
        "stt_codegen/theorem/controller_theorem.py": [('    "emit": "",', '    "emit": "javascript",')],
        "docs/task.md": [("| `rust` | false |", "| `javascript` | false | adds `<p>.js` |\n| `rust` | false |")],
    },
)
COMMAND = Sample(
    "A command",
    files="command",
    edits={
        "stt_codegen/cli/check_commands/__init__.py": [
            (
                "from stt_codegen.cli.check_commands.pil",
                "from stt_codegen.cli.check_commands.count import count\nfrom stt_codegen.cli.check_commands.pil",
            ),
            ("(check, certify,", "(check, certify, count,"),
        ],
        "README.md": [
            (
                "    stt-codegen theorem cart.toml",
                "    stt-codegen count cart.toml        # how many sets are unsafe\n    stt-codegen theorem cart.toml",
            )
        ],
    },
)
BOARD = Sample(
    "A board",
    edits={
        "stt_codegen/board/boards.py": [
            (
                '        _arm("m4f",',
                '        _arm("m4", "Cortex-M4, no FPU", "cortex-m4", "mps2-an386", rust_target="thumbv7em-none-eabi"),\n        _arm("m4f",',
            )
        ],
        "docs/board.md": [("| rv32 | RISC-V", "| m4 | Cortex-M4, no FPU | qemu-system-arm | |\n| rv32 | RISC-V")],
    },
)
KIND = Sample(
    "A kind of tube",
    files="kind",
    edits={
        "stt_codegen/design_kinds.py": [
            ('Literal["refined", "adaptive", "literal"]', 'Literal["refined", "adaptive", "literal", "shapely"]'),
            (
                '    "adaptive": Capabilities(',
                '    "shapely": Capabilities(avoids_any_shape=True),\n    "adaptive": Capabilities(',
            ),
        ],
        "stt_codegen/designs/__init__.py": [
            (
                "from stt_codegen.designs.refined import",
                "from stt_codegen.designs.shapely import ShapelyDesign\nfrom stt_codegen.designs.refined import",
            ),
            ('    "RefinedDesign",\n', '    "ShapelyDesign",\n    "RefinedDesign",\n'),
        ],
        "stt_codegen/pipeline.py": [
            ("import AdaptiveDesign, Design, RefinedDesign,", "import AdaptiveDesign, Design, ShapelyDesign, RefinedDesign,"),
            (
                "def _design_adaptive(",
                """def _design_shapely(task: Task) -> Design:
    from stt_codegen.design import refine

    return ShapelyDesign.of(refine(task))


def _design_adaptive(""",
            ),
            (
                '    "adaptive": Stages(',
                """    "shapely": Stages(
        _design_shapely,
        for_any_design(ShapelyDesign, _refined_program),
        for_any_design(ShapelyDesign, _certify_refined),
    ),
    "adaptive": Stages(""",
            ),
        ],
        "stt_codegen/compare/comparison.py": [
            (
                '    "adaptive": _OF_ADAPTIVE,',
                """    "shapely": _KindComparison(
        for_any_design(RefinedDesign, CasadiRefined), for_any_design(RefinedDesign, _add_rows_of_refined)
    ),
    "adaptive": _OF_ADAPTIVE,""",
            )
        ],
        "stt_codegen/emit/document.py": [
            (
                '    "adaptive": for_any_design(',
                '    "shapely": for_any_design(RefinedDesign, _exact),\n    "adaptive": for_any_design(',
            )
        ],
        "stt_codegen/lemmas/emitted/functions.py": [('{"refined": SPLINE, ', '{"refined": SPLINE, "shapely": SPLINE, ')],
        "stt_codegen/report/loop_analysis.py": [
            (
                '    "adaptive": for_any_design(',
                '    "shapely": for_any_design(RefinedDesign, _read_splines),\n    "adaptive": for_any_design(',
            )
        ],
        "benchmarks/suites/printed.py": [('"refined": "ours"', '"refined": "ours", "shapely": "a sample"')],
        "docs/task.md": [('Designs: `"refined"` (certified);', 'Designs: `"refined"` and `"shapely"` (certified);')],
    },
)
SAMPLES = {sample.title: sample for sample in (SET, OPERATION, LANGUAGE, COMMAND, BOARD, KIND)}


@pytest.fixture(scope="module")
def copy_with_sample(tmp_path_factory):
    """Return a function from the title of a recipe to a copy of the repository in which its sample has followed the recipe."""
    copies: dict[str, Path] = {}

    def make(title: str) -> Path:
        if title not in copies:
            copies[title] = copy_of_the_repository(tmp_path_factory.mktemp("recipe"))
            follow_recipe(SAMPLES[title], copies[title])
        return copies[title]

    return make


@pytest.mark.parametrize("title", SAMPLES)
def test_a_recipe_names_exactly_the_places_that_its_sample_changes(title: str, copy_with_sample) -> None:
    assert mismatches(places_to_change(SAMPLES[title].recipe), changed_files(copy_with_sample(title))) == []


def test_every_link_of_the_page_leads_somewhere() -> None:
    links = [path for path in re.findall(r"\]\(([^)#]+)\)", PAGE) if "://" not in path]
    assert len(links) > 50
    assert [path for path in links if not (ROOT / path).exists()] == []


@pytest.mark.parametrize(
    ("named", "changed", "message"),
    [
        ({"README.md", "docs"}, {"README.md"}, "docs: is named, and nothing is changed there"),
        ({"README.md"}, {"README.md", "Makefile"}, "Makefile: is changed, and is not named"),
        ({"docs"}, {"docs/task.md"}, "docs/task.md: is changed, and is not named"),
        ({"docs/nowhere.md"}, {"docs/nowhere.md"}, "docs/nowhere.md: is named, and is not there"),
        ({"docs"}, {"tests/new.py"}, "tests/new.py: is changed, and is not named"),
    ],
)
def test_a_recipe_with_wrong_places_is_reported(named: set[str], changed: set[str], message: str) -> None:
    assert message in mismatches(named, changed)


def test_new_files_in_a_folder_that_is_named_are_accepted() -> None:
    assert mismatches({"docs", "README.md"}, {"docs/new/page.md", "README.md"}) == []


def test_places_are_the_links_in_bold() -> None:
    page = "## One\n1. **[a](x/a.py)** as [b](x/b.py), **bold**, **[c](x/c/)**\n## Two\n**[d](d)**\n"
    assert places_to_change(section("One", page)) == {"x/a.py", "x/c"}


# ------------------------------------------------------------------------------------------------ from end to end


@pytest.mark.parametrize("title", ["A set", "A target language", "A command"])
def test_faces_and_layers_accept_the_sample(title: str, copy_with_sample) -> None:
    run_pytest_in_copy(
        copy_with_sample(title), "tests/test_faces.py", "tests/test_layers.py", "-k", "through_faces or lists_what or one_way"
    )


def test_a_set_is_designed_certified_and_checked(copy_with_sample) -> None:
    copy = copy_with_sample("A set")
    run_pytest_in_copy(
        copy,
        "tests/task/test_keys.py",
        "tests/task/test_shapes.py",
        "-k",
        "key or list or know or refuses_a_region_of_any_form or diamond and every_shape",
    )


def test_the_sampled_set_works_as_a_region_and_on_a_closed_axis(copy_with_sample, tmp_path: Path) -> None:
    copy = copy_with_sample("A set")
    turning = (ROOT / "tasks" / "omni_heading.toml").read_text()
    turning = turning[: turning.index("[[unsafe]]")] + '[[unsafe]]\nname = "rock"\nmiddle = [2.5, 1.5, 0.5]\nreach = 0.4\n'
    head = "[state_space]\nlower = [0, 0]\nupper = [5, 5]\n[initial_set]\nlower = [0, 0]\nupper = [0.5, 0.5]\n[target_set]\nlower = [4.5, 4.5]\nupper = [5, 5]\n"
    mission = 'name = "visitor"\nprescribed_time = 20\ninitial_state = [0.25, 0.25]\n' + head
    mission += '[[region]]\nname = "dock"\nmiddle = [2, 3]\nreach = 1\n[[mission]]\nvisit = "dock"\n'
    for name, text in {"omni_heading": turning, "visitor": mission}.items():
        (tmp_path / f"{name}.toml").write_text(text)
        generated = run_in_copy(copy, "generate", str(tmp_path / f"{name}.toml"), "--out", str(tmp_path))
        assert generated.returncode == 0, generated.stderr
        files = [str(tmp_path / f"{name}{end}") for end in (".toml", ".c", ".certificate.json")]
        checked = run_in_copy(copy, "certify", *files)
        assert checked.returncode == 0, checked.stdout + checked.stderr


def test_an_operation_is_printed_in_every_language_and_bounded(copy_with_sample, tool) -> None:
    tool("gcc"), tool("clang")
    run_pytest_in_copy(
        copy_with_sample("An operation"),
        "tests/program/test_program.py",
        "-k",
        "hypot and not hypothesis or bank_covers or printed_by_every_printer",
    )
    code = """
import casadi as ca, numpy as np
from stt_codegen.program.analyse import Runner
from stt_codegen.program.targets import TARGETS
from tests.support.bank import kernel_of, one_function_program
kernel, function = kernel_of("far", lambda a, b: ca.hypot(a * 3, b / 7), 2)
program = one_function_program(kernel, "float")
points = np.array([[1e-3, 2.0], [0.3, -40.0], [-5.0, 1e3]], np.float32)
estimate = Runner(program).run("f", {"x": points.astype(np.longdouble)})["y"]
true = np.hypot(points[:, 0].astype(float) * 3, points[:, 1].astype(float) / 7)
single = np.hypot(points[:, 0] * np.float32(3), points[:, 1] / np.float32(7)).astype(float)
assert (np.abs(estimate.value[:, 0].astype(float) - true) <= 1e-12 * true).all()
assert (np.abs(single - true) <= estimate.error[:, 0]).all() and (estimate.error[:, 0] < 1e-5 * true).all()
for target in TARGETS:
    assert any("hypot" in line for line in target.printer(program).kernel(kernel)), target.title
"""
    (copy_with_sample("An operation") / "bounded.py").write_text(code)
    result = run_in_copy(copy_with_sample("An operation"), module="bounded")
    assert result.returncode == 0, result.stderr


def test_a_language_is_within_its_bounds_and_changes_no_file_of_other_tasks(copy_with_sample, tmp_path: Path, tool) -> None:
    tool("node"), tool("cc")
    copy = copy_with_sample("A target language")
    run_pytest_in_copy(
        copy, "tests/task/test_keys.py", "tests/compare/test_targets.py", "-k", "javascript or key or list or know"
    )
    text = (ROOT / "tasks" / "omni_s1.toml").read_text()
    (tmp_path / "omni_s1.toml").write_text(text)
    assert run_in_copy(copy, "generate", str(tmp_path / "omni_s1.toml"), "--out", str(tmp_path / "old")).returncode == 0
    for path in (tmp_path / "old").iterdir():
        assert path.read_bytes() == (ROOT / "generated" / "omni_s1" / "refined" / "float" / path.name).read_bytes()
    (tmp_path / "omni_s1.toml").write_text(text + "[emit]\njavascript = true\n")
    written = run_in_copy(copy, "generate", str(tmp_path / "omni_s1.toml"), "--out", str(tmp_path), "--json")
    assert "omni_s1.js" in json.loads(written.stdout)["written"][0]["files"]
    files = [str(tmp_path / f"omni_s1{end}") for end in (".toml", ".c", ".certificate.json")]
    assert run_in_copy(copy, "certify", *files).returncode == 0
    (tmp_path / "omni_s1.toml").write_text(text.replace('name = "omni_s1"', 'name = "require"') + "[emit]\njavascript = true\n")
    refused = run_in_copy(copy, "generate", str(tmp_path / "omni_s1.toml"), "--out", str(tmp_path))
    assert "name: 'require' is a reserved word of JavaScript (emit.javascript)" in refused.stderr


@pytest.mark.parametrize("path", [f"{CHECKER}/keys.py", f"{CHECKER}/files.py", "stt_codegen/theorem/controller_theorem.py"])
def test_a_language_that_is_missing_in_a_list_is_reported(path: str, tmp_path: Path) -> None:
    copy = copy_of_the_repository(tmp_path)
    follow_recipe(replace(LANGUAGE, edits={name: edits for name, edits in LANGUAGE.edits.items() if name != path}), copy)
    with pytest.raises(AssertionError, match=r"javascript|\.js"):
        run_pytest_in_copy(copy, "tests/task/test_keys.py")
    assert f"{path}: is named, and nothing is changed there" in mismatches(places_to_change(LANGUAGE.recipe), changed_files(copy))


def test_a_command_is_in_the_help_and_answers(copy_with_sample) -> None:
    copy = copy_with_sample("A command")
    assert "count" in run_in_copy(copy, "--help").stdout
    assert json.loads(run_in_copy(copy, "count", "tasks/omni_s2.toml", "--json").stdout) == {"unsafe": 4}
    run_pytest_in_copy(copy, "tests/cli/test_commands.py")


def test_a_board_runs_the_c_and_is_counted(copy_with_sample, tool) -> None:
    for name in ("arm-none-eabi-gcc", "qemu-system-arm"):
        tool(name)
    copy = copy_with_sample("A board")
    result = run_in_copy(copy, "pil", "tasks/omni_s1.toml", "--board", "m4", "--points", "50", "--json")
    document = json.loads(result.stdout)
    assert document["within_bounds"] is True
    assert document["calls"]["control"]["most"] > 500  # without an FPU
    assert "m4" in run_in_copy(copy, "mcu", "--help", module="benchmarks").stdout
    assert "m4," in run_in_copy(copy, "pil", "tasks/omni_s1.toml", "--board", "m5").stderr


def test_a_kind_of_tube_is_designed_compiled_and_compared(copy_with_sample, tmp_path: Path, tool) -> None:
    """The sample's only capability is to avoid sets of any shape: its C, package and comparison need no other capability."""
    tool("gcc")
    copy = copy_with_sample("A kind of tube")
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    (tmp_path / "omni_s2.toml").write_text(text.replace("[tube]\n", '[tube]\ndesign = "shapely"\n'))
    for folder, options in (("c", ()), ("sketch", ("--package", "arduino"))):
        arguments = (str(tmp_path / "omni_s2.toml"), "--out", str(tmp_path / folder), *options)
        written = run_in_copy(copy, "generate", *arguments)
        assert written.returncode == 0, written.stderr
    assert "covered(" not in "".join(
        path.read_text() for path in tmp_path.rglob("*.[chi]*") if path.suffix in (".c", ".h", ".ino")
    )
    command = ["gcc", *STRICT, "-c", str(tmp_path / "c" / "omni_s2.c"), "-o", str(tmp_path / "omni_s2.o")]
    compiled = subprocess.run(command, capture_output=True, text=True, check=False)
    assert compiled.returncode == 0, compiled.stderr
    compared = run_in_copy(copy, "compare", str(tmp_path / "omni_s2.toml"), "--points", "200")
    assert compared.returncode == 0, compared.stdout + compared.stderr
    run_pytest_in_copy(
        copy, "tests/test_designs_protocol.py", "-k", "table or answers or another_class or list_says or asked_for"
    )


@pytest.mark.parametrize("path", ["stt_codegen/emit/document.py", "benchmarks/suites/printed.py"])
def test_a_kind_that_is_missing_in_a_table_is_reported(path: str, tmp_path: Path) -> None:
    copy = copy_of_the_repository(tmp_path)
    follow_recipe(replace(KIND, edits={name: edits for name, edits in KIND.edits.items() if name != path}), copy)
    with pytest.raises(AssertionError, match="has no shapely"):
        run_pytest_in_copy(copy, "tests/test_designs_protocol.py", "-k", "every_kind_has_an_entry")
