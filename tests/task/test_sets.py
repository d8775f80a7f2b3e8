"""Convex sets by normals and support. A polygon that the package has never heard of, one class and one table in this file, goes
through design, exact certificate, C, closed loop and pictures, and is judged by its true shape throughout."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import gcd, lcm

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stt_codegen.certify.adaptive import certify_enclosed
from stt_codegen.certify.adaptive.falsification import falsify
from stt_codegen.certify.exact import certify_refined
from stt_codegen.constraints import avoidances, separation_constraints
from stt_codegen.design.arena import arena_of
from stt_codegen.design.paper_tubes import design_adaptive
from stt_codegen.design.routes.grown_sets import grow_obstacles
from stt_codegen.errors import NotCertified
from stt_codegen.loop.simulate import Loop, Scenario
from stt_codegen.plants import PLANTS
from stt_codegen.program.analyse.cost import cost_of
from stt_codegen.report.outlines import outline
from stt_codegen.report.pictures.tube_pictures import draw
from stt_codegen.task.checks.field_checks import first_problem
from stt_codegen.task.load import parse_task
from stt_codegen.task.sets.convex_sets import BoxSet, ConvexSet, Normal, Vector, axis_normals, minimum_over_box
from stt_codegen.task.sets.shapes import Unsafe, UnsafeSet
from stt_codegen.task.task import Task
from tests.support.controllers import built

Points = list[tuple[Fraction, Fraction]]


class Polygon(ConvexSet):
    """A convex polygon in the plane, by its corners in order around it."""

    dimension = 2

    def __init__(self, corners: Points, name: str = "") -> None:
        self.corners, self.name = corners, name

    @property
    def normals(self) -> tuple[Normal, ...]:
        found = list(axis_normals(2))
        for (a, b), (c, d) in zip(self.corners, self.corners[1:] + self.corners[:1], strict=True):
            turned = (d - b, a - c)
            whole = [int(v * lcm(*(w.denominator for w in turned))) for v in turned]
            normal = tuple(v // gcd(*whole) for v in whole)
            if normal not in found:
                found.append(normal)
        return tuple(found)

    def support(self, normal: Normal) -> Fraction:
        return max(sum((c * v for c, v in zip(normal, p, strict=True)), Fraction(0)) for p in self.corners)

    @property
    def vertices(self) -> tuple[Vector, ...]:
        return tuple(self.corners)


class PolygonTable(Unsafe):
    """What shapes.py would have: a table that knows its shape."""

    corners: tuple[tuple[Fraction, Fraction], ...] = ()

    def vectors(self) -> list[tuple[str, tuple[Fraction, ...]]]:
        return [(f"corners[{k}]", p) for k, p in enumerate(self.corners)]

    def problem(self) -> str | None:
        return None if len(self.corners) > 2 else "corners: are fewer than three"

    def to_convex_set(self, lower: Vector, upper: Vector) -> ConvexSet:
        return Polygon(list(self.corners), self.name)


def polygon_of(name: str, *corners: tuple[str, str]) -> PolygonTable:
    points = tuple((Fraction(x), Fraction(y)) for x, y in corners)
    return PolygonTable.model_construct(name=name, axes=None, corners=points)


PLAIN = """name = "diagonal"
prescribed_time = 9
initial_state = [0.25, 0.25]
state_space = { lower = [0, 0], upper = [5, 5] }
initial_set = { lower = [0, 0], upper = [0.5, 0.5] }
target_set = { lower = [4.5, 4.5], upper = [5, 5] }
"""
# Two triangles with a slanted corridor between them; their bounding boxes overlap and close it.
RIGHT = polygon_of("right", ("1.2", "0"), ("5", "0"), ("5", "3.8"))
LEFT = polygon_of("left", ("0", "1.2"), ("3.8", "5"), ("0", "5"))


def with_sets(*tables: Unsafe, **options: object) -> Task:
    return parse_task(PLAIN).model_copy(update={"unsafe": tables, **options})


CORRIDOR = with_sets(RIGHT, LEFT)


@pytest.fixture(scope="module")
def controller():
    return built(CORRIDOR)


# ------------------------------------------------------------------------------------------------------------- the shapes

numbers = st.fractions(min_value=-4, max_value=4, max_denominator=8)


@st.composite
def boxes(draw: st.DrawFn, n: int) -> BoxSet:
    lower = [draw(numbers) for _ in range(n)]
    return BoxSet(tuple(lower), tuple(a + abs(draw(numbers)) + Fraction(1, 8) for a in lower))


@st.composite
def polygons(draw: st.DrawFn) -> Polygon:
    """The hull of random points, by turns to the left."""
    points = draw(st.lists(st.tuples(numbers, numbers), min_size=3, max_size=7, unique=True))
    corners = hull(points)
    return Polygon(
        corners if len(corners) > 2 else [(Fraction(0), Fraction(0)), (Fraction(1), Fraction(0)), (Fraction(0), Fraction(1))]
    )


def hull(points: Points) -> Points:
    def half(ordered: Points) -> Points:
        found: Points = []
        for p in ordered:
            while len(found) > 1 and cross(found[-2], found[-1], p) <= 0:
                found.pop()
            found.append(p)
        return found[:-1]

    return half(sorted(points)) + half(sorted(points, reverse=True))


def cross(a, b, c) -> Fraction:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def clipped(corners: Points, box: BoxSet) -> Points:
    """The polygon within a closed box, by Sutherland and Hodgman; exact."""
    for i in (0, 1):
        for sign, bound in ((1, -box.lower[i]), (-1, box.upper[i])):
            inside = [sign * p[i] + bound for p in corners]
            kept: Points = []
            for k, p in enumerate(corners):
                a, b, q = inside[k - 1], inside[k], corners[k - 1]
                if (a < 0) != (b < 0):
                    share = a / (a - b)
                    kept.append(tuple(u + share * (v - u) for u, v in zip(q, p, strict=True)))
                if b >= 0:
                    kept.append(p)
            corners = kept
    return corners


@given(boxes(3), boxes(3))
def test_boxes_are_apart_and_cover_as_their_edges_say(one: BoxSet, other: BoxSet) -> None:
    pairs = list(zip(one.lower, one.upper, other.lower, other.upper, strict=True))
    assert one.is_apart_from(other.lower, other.upper) == any(b < c or d < a for a, b, c, d in pairs)
    assert one.covers(other.lower, other.upper) == all(a <= c and d <= b for a, b, c, d in pairs)
    assert [one.span(i) for i in range(3)] == list(zip(one.lower, one.upper, strict=True))


@given(polygons(), boxes(2))
@settings(max_examples=300)
def test_a_polygon_is_apart_from_a_box_just_where_they_share_no_point(polygon: Polygon, box: BoxSet) -> None:
    assert polygon.is_apart_from(box.lower, box.upper) == (not clipped(polygon.corners, box))


@given(polygons(), st.tuples(numbers.map(abs), numbers.map(abs)), st.tuples(numbers, numbers))
def test_a_grown_set_holds_a_point_just_where_the_box_about_it_meets_the_set(polygon: Polygon, half: Vector, at: Vector) -> None:
    grown = polygon.grown(half)
    about = BoxSet(tuple(v - h for v, h in zip(at, half, strict=True)), tuple(v + h for v, h in zip(at, half, strict=True)))
    assert grown.is_apart_from(at, at) == polygon.is_apart_from(about.lower, about.upper)
    for normal, offset in grown.faces:
        assert max(sum(c * v for c, v in zip(normal, p, strict=True)) for p in grown.vertices) == offset


@given(polygons(), boxes(2), st.fractions(min_value=0, max_value=1, max_denominator=8))
def test_the_slack_of_a_row_is_the_clearance_beyond(polygon: Polygon, box: BoxSet, clearance: Fraction) -> None:
    """A row holds by s just where the set grown by clearance + s is not past its normal."""
    for row, (normal, offset) in zip(separation_constraints(polygon, clearance), polygon.faces, strict=True):
        slack = (minimum_over_box(normal, box.lower, box.upper) - row.bound - row.clearance) / row.slack_per_distance
        assert minimum_over_box(normal, box.lower, box.upper) == offset + (clearance + slack) * sum(map(abs, normal))


@given(polygons())
def test_the_outline_of_a_set_is_its_corners(polygon: Polygon) -> None:
    drawn = {tuple(p) for p in outline(polygon).tolist()}
    assert drawn == {tuple(float(v) for v in p) for p in polygon.corners}


@given(polygons(), st.lists(st.tuples(numbers, numbers), min_size=1, max_size=20), st.tuples(numbers, numbers))
@settings(max_examples=60)
def test_what_the_route_sees_is_what_there_is(polygon: Polygon, points: Points, eye: tuple[Fraction, Fraction]) -> None:
    """Inside and in sight of the grown set, against exact arithmetic, but where a line all but touches."""
    reach = Fraction(1, 4)
    table = PolygonTable.model_construct(name="P", axes=None, corners=tuple(polygon.corners))
    space = parse_task(PLAIN).state_space.model_copy(update={"lower": (Fraction(-9),) * 2, "upper": (Fraction(9),) * 2})
    seen = grow_obstacles(arena_of(with_sets(table, state_space=space)), np.full(2, float(reach)))
    grown = polygon.grown((reach, reach))
    given_points = np.array([[float(v) for v in p] for p in points])
    for p, inside, free in zip(
        points, seen.contain(given_points), seen.visible_from(np.array([float(v) for v in eye]), given_points), strict=True
    ):
        depth = min(offset - sum(c * v for c, v in zip(n, p, strict=True)) for n, offset in grown.faces)
        if abs(depth) > 1e-9:
            assert bool(inside) == (depth > 0)
        first, final = Fraction(0), Fraction(1)
        for n, offset in grown.faces:
            here, there = (sum(c * v for c, v in zip(n, q, strict=True)) for q in (eye, p))
            if here == there:
                final = final if here < offset else Fraction(-1)
            elif there > here:
                final = min(final, (offset - here) / (there - here))
            else:
                first = max(first, (offset - here) / (there - here))
        if abs(final - first) > 1e-6:
            assert bool(free) == (first > final)


# ----------------------------------------------------------------------------------------------- the polygon, end to end


def test_a_way_that_only_the_true_shapes_leave_is_found_and_certified(controller) -> None:
    assert controller.certificate.holds
    with pytest.raises(NotCertified):
        built(
            with_sets(
                *(
                    UnsafeSet(name=t.name, lower=[v[0] for v in s], upper=[v[1] for v in s])
                    for t in (RIGHT, LEFT)
                    for s in [[t.to_convex_set((), ()).span(i) for i in (0, 1)]]
                )
            )
        )


def test_the_certified_tube_keeps_its_clearance_from_the_true_polygons(controller) -> None:
    """At dense times, in exact numbers: the box, grown by the clearance, shares no point with a triangle."""
    low, high = controller.design.edges_at(np.linspace(0, 9, 2001))
    keep, rounding = controller.task.tube.clearance, Fraction(1, 1 << 40)
    for a, b in zip(low.tolist(), high.tolist(), strict=True):
        box = BoxSet(tuple(Fraction(v) - keep + rounding for v in a), tuple(Fraction(v) + keep - rounding for v in b))
        assert not any(clipped(list(table.corners), box) for table in (RIGHT, LEFT))


def test_p4_falls_just_where_a_slanted_face_comes_too_near(controller) -> None:
    """A triangle is pushed toward the tube. Where P4 holds, boxes grown by the clearance keep off it; where it falls, some box grown
    by a table unit more than clearance and P7's error meets it."""
    design, error, clearance = controller.design, max(controller.certificate.edge_error), controller.task.tube.clearance
    low, high = design.edges_at(np.linspace(0, 9, 8 * design.segments + 1))
    verdicts = []
    for k in range(0, 60, 3):
        push = Fraction(k, 100)
        moved = polygon_of("right", *((str(x - push), str(y + push)) for x, y in RIGHT.corners))
        finding = next(
            f
            for f in certify_refined(with_sets(moved, LEFT), design, controller.certificate.edge_error).findings
            if f.code == "P4"
        )
        verdicts.append(finding.holds)
        keep = clearance + (Fraction(-1, 1 << 40) if finding.holds else error + Fraction(1, 100))
        meets = any(
            clipped(list(moved.corners), BoxSet(tuple(Fraction(v) - keep for v in a), tuple(Fraction(v) + keep for v in b)))
            for a, b in zip(low.tolist(), high.tolist(), strict=True)
        )
        assert meets != finding.holds
        assert finding.holds or finding.obstacle == "right"
    assert verdicts == sorted(verdicts, reverse=True)
    assert len(set(verdicts)) == 2


def test_the_loop_judges_by_the_true_shape(controller) -> None:
    """Runs of the certified controller hit nothing; a start inside a triangle is a hit, one in its bounding box alone is not."""
    loop = Loop(controller, PLANTS["integrator"])
    for kind in ("none", "nearest", "outward"):
        run = loop.run(Scenario(rate=500.0, disturbance=kind, strength=0.0 if kind == "none" else 0.2))
        assert run.good
        assert run.kept
    assert loop.run(Scenario(start=(4.0, 1.0))).hit == "right"
    assert loop.run(Scenario(start=(1.3, 3.6))).hit == "left"
    assert loop.run(Scenario(start=(3.4, 3.4))).hit is None


def test_wind_toward_the_nearest_set_blows_along_its_face(controller) -> None:
    """From a place nearest to the slanted side of a triangle, the push is along its normal."""
    run = Loop(controller, PLANTS["integrator"]).run(Scenario(disturbance="nearest", strength=0.1, start=(2.9, 1.9)), trace=True)
    w = run.trace[0, 9:11]
    assert w == pytest.approx([0.1 / np.sqrt(2), -0.1 / np.sqrt(2)], rel=1e-6)


def test_the_step_costs_what_it_costs_without_sets(controller) -> None:
    assert cost_of(controller.program, "control") == cost_of(built(parse_task(PLAIN)).program, "control")


def test_a_body_moves_every_face(controller) -> None:
    """A robot of some size gets a narrower corridor, and its tube keeps off the grown triangles."""
    body = (Fraction("0.2"), Fraction("0.1"))
    start = parse_task(PLAIN).initial_set.model_copy(update={"lower": (Fraction("0.2"), Fraction("0.1"))})
    target = parse_task(PLAIN).target_set.model_copy(
        update={"lower": (Fraction("4.5"),) * 2, "upper": (Fraction("4.8"), Fraction("4.9"))}
    )
    task = with_sets(
        RIGHT, LEFT, body=body, initial_set=start, target_set=target, initial_state=(Fraction("0.35"), Fraction("0.3"))
    )
    assert first_problem(task) is None
    made = built(task)
    assert made.certificate.holds
    low, high = made.design.edges_at(np.linspace(0, 9, 500))
    for a, b in zip(low.tolist(), high.tolist(), strict=True):
        assert all(s.is_apart_from(tuple(map(Fraction, a)), tuple(map(Fraction, b))) for s in task.obstacles)


def test_checks_ask_the_shape() -> None:
    """A triangle whose bounding box covers the start is fine where it does not touch it, and refused where it does."""
    near = polygon_of("near", ("0", "1.5"), ("1.5", "0"), ("1.5", "1.5"))
    assert first_problem(with_sets(near)) is None
    over = polygon_of("over", ("0", "0.9"), ("0.9", "0"), ("1.5", "1.5"))
    told = first_problem(with_sets(over))
    assert told is not None
    assert "over" in told


def test_pictures_show_it(controller, tmp_path) -> None:
    draw(controller, tmp_path / "diagonal.png")
    assert (tmp_path / "diagonal.png").read_bytes().startswith(b"\x89PNG")


def test_adaptive_tubes_are_judged_by_the_true_shape() -> None:
    """A triangle beside the straight way: the search goes around its bounding box, and the enclosure certifies with the true faces.
    One laid upon the tube is found out; one whose bounding box alone meets the tube is not held against it."""
    corner = polygon_of("corner", ("2.2", "1.6"), ("3.4", "1.6"), ("3.4", "2.8"))
    options = parse_task(PLAIN).tube.model_copy(update={"design": "adaptive"})
    task = with_sets(corner, tube=options)  # a file could not ask for it: designs of this kind offer boxes
    tube = design_adaptive(task)
    assert certify_enclosed(task, tube).holds
    low, high = (edges[1000] for edges in tube.edges_at(np.linspace(0, 9, 2001)))
    x, y = (f"{(a + b) / 2:.3f}" for a, b in zip(low, high, strict=True))
    on_it = polygon_of("on it", (x, y), (str(Fraction(x) + 1), y), (x, str(Fraction(y) + 1)))
    found = falsify(with_sets(on_it), tube)
    assert next(f for f in found.failures if f.code == "P4").obstacle == "on it"
    a, b = Fraction(f"{high[0] + 0.2:.3f}"), Fraction(f"{low[1] - 0.2:.3f}")
    beside = polygon_of("beside", (str(a - 1), str(b - 1)), (str(a), str(b - 1)), (str(a), str(b)))
    assert "P4" not in {f.code for f in falsify(with_sets(beside), tube).failures}


def test_every_row_of_a_choice_is_sound() -> None:
    """Each row of P4 alone keeps box and set apart: normals may be missing, none may be wrong."""
    for one, shape in zip(avoidances(CORRIDOR), CORRIDOR.obstacles, strict=True):
        for row, (x, y) in product(one.alternatives, [(Fraction(a, 4), Fraction(b, 4)) for a in range(20) for b in range(20)]):
            left = sum(c * ((x, y)[i]) for i, _, c in row.terms)
            if left >= row.bound + row.clearance:
                assert shape.is_apart_from((x, y), (x, y))
