"""Convex sets by normals and support (`ConvexSet`).

A polygon that the package does not know, one class and one table in this file, goes through design, exact certificate, C, closed loop
and pictures. Its true shape is the judge throughout.
"""

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
from tests.support.controllers import build_once

Points = list[tuple[Fraction, Fraction]]


class Polygon(ConvexSet):
    """A convex polygon in the plane, by its corners in order around it."""

    dimension = 2

    def __init__(self, corners: Points, name: str = "") -> None:
        self.corners, self.name = corners, name

    @property
    def normals(self) -> tuple[Normal, ...]:
        normals = list(axis_normals(2))
        for (a, b), (c, d) in zip(self.corners, self.corners[1:] + self.corners[:1], strict=True):
            outward = (d - b, a - c)
            integers = [int(v * lcm(*(w.denominator for w in outward))) for v in outward]
            normal = tuple(v // gcd(*integers) for v in integers)
            if normal not in normals:
                normals.append(normal)
        return tuple(normals)

    def support(self, normal: Normal) -> Fraction:
        return max(sum((c * v for c, v in zip(normal, p, strict=True)), Fraction(0)) for p in self.corners)

    @property
    def vertices(self) -> tuple[Vector, ...]:
        return tuple(self.corners)


class PolygonTable(Unsafe):
    """The table of a polygon in a task, as shapes.py has them for the shapes that ship."""

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
    return build_once(CORRIDOR)


# ------------------------------------------------------------------------------------------------------------- the shapes

numbers = st.fractions(min_value=-4, max_value=4, max_denominator=8)


@st.composite
def boxes(draw: st.DrawFn, n: int) -> BoxSet:
    lower = [draw(numbers) for _ in range(n)]
    return BoxSet(tuple(lower), tuple(a + abs(draw(numbers)) + Fraction(1, 8) for a in lower))


@st.composite
def polygons(draw: st.DrawFn) -> Polygon:
    """Draw the hull of random points, or a triangle where they are on one line."""
    points = draw(st.lists(st.tuples(numbers, numbers), min_size=3, max_size=7, unique=True))
    corners = hull(points)
    return Polygon(
        corners if len(corners) > 2 else [(Fraction(0), Fraction(0)), (Fraction(1), Fraction(0)), (Fraction(0), Fraction(1))]
    )


def hull(points: Points) -> Points:
    """Return the corners of the convex hull counterclockwise, as chains of left turns."""

    def half(ordered: Points) -> Points:
        chain: Points = []
        for p in ordered:
            while len(chain) > 1 and cross(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(sorted(points)) + half(sorted(points, reverse=True))


def cross(a, b, c) -> Fraction:
    """Return twice the area of the triangle a, b, c: positive where it turns left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def clipped(corners: Points, box: BoxSet) -> Points:
    """Return the exact corners of the polygon within a closed box, by the algorithm of Sutherland and Hodgman."""
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
def test_boxes_are_apart_and_cover_as_their_edges_say(box: BoxSet, second_box: BoxSet) -> None:
    pairs = list(zip(box.lower, box.upper, second_box.lower, second_box.upper, strict=True))
    assert box.is_apart_from(second_box.lower, second_box.upper) == any(b < c or d < a for a, b, c, d in pairs)
    assert box.covers(second_box.lower, second_box.upper) == all(a <= c and d <= b for a, b, c, d in pairs)
    assert [box.span(i) for i in range(3)] == list(zip(box.lower, box.upper, strict=True))


@given(polygons(), boxes(2))
@settings(max_examples=300)
def test_a_polygon_is_apart_from_a_box_exactly_if_they_share_no_point(polygon: Polygon, box: BoxSet) -> None:
    assert polygon.is_apart_from(box.lower, box.upper) == (not clipped(polygon.corners, box))


@given(polygons(), st.tuples(numbers.map(abs), numbers.map(abs)), st.tuples(numbers, numbers))
def test_a_grown_set_contains_a_point_exactly_if_the_box_about_it_meets_the_set(
    polygon: Polygon, half: Vector, point: Vector
) -> None:
    grown = polygon.grown(half)
    box = BoxSet(tuple(v - h for v, h in zip(point, half, strict=True)), tuple(v + h for v, h in zip(point, half, strict=True)))
    assert grown.is_apart_from(point, point) == polygon.is_apart_from(box.lower, box.upper)
    for normal, offset in grown.faces:
        assert max(sum(c * v for c, v in zip(normal, p, strict=True)) for p in grown.vertices) == offset


@given(polygons(), boxes(2), st.fractions(min_value=0, max_value=1, max_denominator=8))
def test_the_slack_of_a_constraint_is_the_distance_beyond_the_clearance(
    polygon: Polygon, box: BoxSet, clearance: Fraction
) -> None:
    """A constraint has the slack s exactly if the box touches the face of the set grown by clearance + s."""
    for constraint, (normal, offset) in zip(separation_constraints(polygon, (clearance, clearance)), polygon.faces, strict=True):
        slack = (
            minimum_over_box(normal, box.lower, box.upper) - constraint.bound - constraint.clearance
        ) / constraint.slack_per_distance
        assert minimum_over_box(normal, box.lower, box.upper) == offset + (clearance + slack) * sum(map(abs, normal))


@given(polygons())
def test_the_outline_of_a_set_is_its_corners(polygon: Polygon) -> None:
    drawn = {tuple(p) for p in outline(polygon).tolist()}
    assert drawn == {tuple(float(v) for v in p) for p in polygon.corners}


@given(polygons(), st.lists(st.tuples(numbers, numbers), min_size=1, max_size=20), st.tuples(numbers, numbers))
@settings(max_examples=60)
def test_route_obstacles_agree_with_exact_inclusion_and_visibility(
    polygon: Polygon, points: Points, eye: tuple[Fraction, Fraction]
) -> None:
    """Whether points are inside the grown set, or visible past it, agrees with exact arithmetic, except where a line nearly touches it."""
    reach = Fraction(1, 4)
    table = PolygonTable.model_construct(name="P", axes=None, corners=tuple(polygon.corners))
    space = parse_task(PLAIN).state_space.model_copy(update={"lower": (Fraction(-9),) * 2, "upper": (Fraction(9),) * 2})
    obstacles = grow_obstacles(arena_of(with_sets(table, state_space=space)), np.full(2, float(reach)))
    grown = polygon.grown((reach, reach))
    points_array = np.array([[float(v) for v in p] for p in points])
    for p, is_inside, is_visible in zip(
        points,
        obstacles.contain(points_array),
        obstacles.visible_from(np.array([float(v) for v in eye]), points_array),
        strict=True,
    ):
        depth = min(offset - sum(c * v for c, v in zip(n, p, strict=True)) for n, offset in grown.faces)
        if abs(depth) > 1e-9:
            assert bool(is_inside) == (depth > 0)
        entry, exit_ = Fraction(0), Fraction(1)  # the share of the line from eye to p that is inside the set
        for n, offset in grown.faces:
            at_eye, at_point = (sum(c * v for c, v in zip(n, q, strict=True)) for q in (eye, p))
            if at_eye == at_point:
                exit_ = exit_ if at_eye < offset else Fraction(-1)
            elif at_point > at_eye:
                exit_ = min(exit_, (offset - at_eye) / (at_point - at_eye))
            else:
                entry = max(entry, (offset - at_eye) / (at_point - at_eye))
        if abs(exit_ - entry) > 1e-6:
            assert bool(is_visible) == (entry > exit_)


# ----------------------------------------------------------------------------------------------- the polygon, end to end


def test_a_corridor_between_the_true_shapes_is_certified_and_closed_by_their_boxes(controller) -> None:
    assert controller.certificate.holds
    with pytest.raises(NotCertified):
        build_once(
            with_sets(
                *(
                    UnsafeSet(name=t.name, lower=[v[0] for v in s], upper=[v[1] for v in s])
                    for t in (RIGHT, LEFT)
                    for s in [[t.to_convex_set((), ()).span(i) for i in (0, 1)]]
                )
            )
        )


def test_the_certified_tube_keeps_its_clearance_from_the_true_polygons(controller) -> None:
    """At dense times, in exact numbers, the box grown by the clearance shares no point with a triangle."""
    low, high = controller.design.edges_at(np.linspace(0, 9, 2001))
    clearance, rounding = controller.task.tube.clearance, Fraction(1, 1 << 40)
    for a, b in zip(low.tolist(), high.tolist(), strict=True):
        box = BoxSet(tuple(Fraction(v) - clearance + rounding for v in a), tuple(Fraction(v) + clearance - rounding for v in b))
        assert not any(clipped(list(table.corners), box) for table in (RIGHT, LEFT))


def test_p4_fails_exactly_where_a_slanted_face_comes_too_near(controller) -> None:
    """A triangle is pushed toward the tube. Where P4 holds, boxes grown by the clearance avoid the triangle; where it fails, some box
    grown by clearance, P7's error and a table unit meets it."""
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
        growth = clearance + (Fraction(-1, 1 << 40) if finding.holds else error + Fraction(1, 100))
        meets = any(
            clipped(list(moved.corners), BoxSet(tuple(Fraction(v) - growth for v in a), tuple(Fraction(v) + growth for v in b)))
            for a, b in zip(low.tolist(), high.tolist(), strict=True)
        )
        assert meets != finding.holds
        assert finding.holds or finding.obstacle == "right"
    assert verdicts == sorted(verdicts, reverse=True)
    assert len(set(verdicts)) == 2


def test_the_loop_judges_by_the_true_shape(controller) -> None:
    """The certified controller hits nothing. A start inside a triangle is a hit; a start that is only in its bounding box is not."""
    loop = Loop(controller, PLANTS["integrator"])
    for kind in ("none", "nearest", "outward"):
        run = loop.run(Scenario(rate=500.0, disturbance=kind, strength=0.0 if kind == "none" else 0.2))
        assert run.good
        assert run.kept
    assert loop.run(Scenario(start=(4.0, 1.0))).hit == "right"
    assert loop.run(Scenario(start=(1.3, 3.6))).hit == "left"
    assert loop.run(Scenario(start=(3.4, 3.4))).hit is None


def test_disturbance_toward_the_nearest_set_is_along_its_normal(controller) -> None:
    """At a point nearest to the slanted side of a triangle, the disturbance acts along the normal of that side."""
    run = Loop(controller, PLANTS["integrator"]).run(Scenario(disturbance="nearest", strength=0.1, start=(2.9, 1.9)), trace=True)
    w = run.trace[0, 9:11]
    assert w == pytest.approx([0.1 / np.sqrt(2), -0.1 / np.sqrt(2)], rel=1e-6)


def test_unsafe_sets_do_not_add_to_the_cost_of_a_step(controller) -> None:
    assert cost_of(controller.program, "control") == cost_of(build_once(parse_task(PLAIN)).program, "control")


def test_the_tube_of_a_robot_with_a_body_avoids_the_grown_triangles(controller) -> None:
    body = (Fraction("0.2"), Fraction("0.1"))
    start = parse_task(PLAIN).initial_set.model_copy(update={"lower": (Fraction("0.2"), Fraction("0.1"))})
    target = parse_task(PLAIN).target_set.model_copy(
        update={"lower": (Fraction("4.5"),) * 2, "upper": (Fraction("4.8"), Fraction("4.9"))}
    )
    task = with_sets(
        RIGHT, LEFT, body=body, initial_set=start, target_set=target, initial_state=(Fraction("0.35"), Fraction("0.3"))
    )
    assert first_problem(task) is None
    certified = build_once(task)
    assert certified.certificate.holds
    low, high = certified.design.edges_at(np.linspace(0, 9, 500))
    for a, b in zip(low.tolist(), high.tolist(), strict=True):
        assert all(s.is_apart_from(tuple(map(Fraction, a)), tuple(map(Fraction, b))) for s in task.obstacles)


def test_checks_of_a_task_use_the_true_shape() -> None:
    """A triangle whose bounding box covers the start is fine where it does not touch it, and refused where it does."""
    near = polygon_of("near", ("0", "1.5"), ("1.5", "0"), ("1.5", "1.5"))
    assert first_problem(with_sets(near)) is None
    over = polygon_of("over", ("0", "0.9"), ("0.9", "0"), ("1.5", "1.5"))
    problem = first_problem(with_sets(over))
    assert problem is not None
    assert "over" in problem


def test_pictures_of_a_polygon_are_drawn(controller, tmp_path) -> None:
    draw(controller, tmp_path / "diagonal.png")
    assert (tmp_path / "diagonal.png").read_bytes().startswith(b"\x89PNG")


def test_adaptive_tubes_are_judged_by_the_true_shape() -> None:
    """A triangle is beside the straight way: the search goes around its bounding box, and the enclosure certifies with the true
    faces. A triangle on the tube is detected; a triangle of which only the bounding box meets the tube is no failure."""
    corner = polygon_of("corner", ("2.2", "1.6"), ("3.4", "1.6"), ("3.4", "2.8"))
    options = parse_task(PLAIN).tube.model_copy(update={"design": "adaptive"})
    task = with_sets(corner, tube=options)  # a task file cannot state this: adaptive designs take boxes only
    tube = design_adaptive(task)
    assert certify_enclosed(task, tube).holds
    low, high = (edges[1000] for edges in tube.edges_at(np.linspace(0, 9, 2001)))
    x, y = (f"{(a + b) / 2:.3f}" for a, b in zip(low, high, strict=True))
    on_it = polygon_of("on it", (x, y), (str(Fraction(x) + 1), y), (x, str(Fraction(y) + 1)))
    falsification = falsify(with_sets(on_it), tube)
    assert next(f for f in falsification.failures if f.code == "P4").obstacle == "on it"
    a, b = Fraction(f"{high[0] + 0.2:.3f}"), Fraction(f"{low[1] - 0.2:.3f}")
    beside = polygon_of("beside", (str(a - 1), str(b - 1)), (str(a), str(b - 1)), (str(a), str(b)))
    assert "P4" not in {f.code for f in falsify(with_sets(beside), tube).failures}


def test_every_alternative_constraint_of_an_avoidance_is_sound() -> None:
    """Any one constraint of P4 keeps box and set apart: normals may be missing, but no normal may be wrong."""
    for avoidance, shape in zip(avoidances(CORRIDOR), CORRIDOR.obstacles, strict=True):
        for constraint, (x, y) in product(
            avoidance.alternatives, [(Fraction(a, 4), Fraction(b, 4)) for a in range(20) for b in range(20)]
        ):
            value = sum(c * ((x, y)[i]) for i, _, c in constraint.terms)
            if value >= constraint.bound + constraint.clearance:
                assert shape.is_apart_from((x, y), (x, y))
