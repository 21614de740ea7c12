#!/usr/bin/env python3
"""Draws scenes/cherry.json: a cherry with stalk and leaf, edited on levels 0 to 5.

The drawing is a few curves and colour functions. Level by level, control points are moved onto the curves and
colour vertices take the painted colour wherever the coarser levels miss it by more than a tolerance; so the edits
are hierarchical, and fine ones stand only where the drawing has fine detail.

Usage: tools/draw_cherry.py > scenes/cherry.json
"""

import json
import math
from cmath import exp, phase

from gradient_mesh import InputMesh, Level, boundary_edit, sector_edit, ternary


# ---- the drawing: positions are complex numbers, y up, the fruit about one unit in radius ----

def bezier(points, t):
    while len(points) > 1:
        points = [a + (b - a) * t for a, b in zip(points, points[1:])]
    return points[0]


def bump(x, centre, width):
    return math.exp(-(((x - centre) / width) ** 2))


def mix(a, b, t):
    t = min(1.0, max(0.0, t))
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def ramp(stops, t):
    """Colour at t between (t, colour) stops."""
    for (t0, c0), (t1, c1) in zip(stops, stops[1:]):
        if t <= t1:
            return mix(c0, c1, (t - t0) / (t1 - t0))
    return stops[-1][1]


def smoothstep(a, b, x):
    x = min(1.0, max(0.0, (x - a) / (b - a)))
    return x * x * (3 - 2 * x)


def fruit_radius(angle):
    """Outline of the fruit: broad shoulders, the left one higher, and a dimple for the stalk."""
    degrees = math.degrees(angle) % 360
    return (1.0 - 0.25 * bump(degrees, 91, 25) + 0.055 * bump(degrees, 140, 32) + 0.035 * bump(degrees, 42, 30)
            + 0.045 * abs(math.cos(angle)) ** 3 + 0.015 * bump(degrees, 268, 40))


STALK = [0.0 + 0.70j, -0.02 + 1.30j, 0.10 + 1.75j, 0.50 + 2.12j]
# Where the stalk is cut by the rows of its quads; the leaf grows from the fourth quad.
STALK_STOPS = [0.0, 0.28, 0.56, 0.77, 0.83, 1.0]


def stalk_width(t):
    return 0.031 + 0.022 * bump(t, 0.0, 0.10) + 0.040 * bump(t, 1.0, 0.085) + 0.010 * bump(t, 0.83, 0.06)


def leaf_width(u):
    x = max(0.0, u - 0.09) / 0.91
    return 0.024 * (1 - x) + 0.37 * math.sin(math.pi * x ** 0.80) ** 1.05 * (1 - 0.22 * x)


class Axis:
    """A curve with a place along it (0 to 1) and a signed distance from it (left is positive)."""

    def __init__(self, points):
        self.points = points
        self.samples = [bezier(points, k / 400) for k in range(401)]

    def at(self, t, offset):
        t0, t1 = max(0.0, t - 1e-4), min(1.0, t + 1e-4)
        tangent = bezier(self.points, t1) - bezier(self.points, t0)
        return bezier(self.points, t) + 1j * tangent / abs(tangent) * offset

    def project(self, p):
        k = min(range(len(self.samples)), key=lambda k: abs(self.samples[k] - p))
        a, b = self.samples[max(0, k - 1)], self.samples[min(400, k + 1)]
        tangent = (b - a) / abs(b - a)
        return k / 400, ((p - self.samples[k]) / tangent).imag


STALK_AXIS = Axis(STALK)
LEAF_START = (STALK_STOPS[3] + STALK_STOPS[4]) / 2
LEAF_AXIS = Axis([STALK_AXIS.at(LEAF_START, -stalk_width(LEAF_START)), 0.66 + 1.72j, 1.20 + 1.98j, 1.80 + 1.40j])
LEAF_STOPS = [0.0, 0.16, 0.37, 0.58, 0.79]


def leaf_lean(u):
    """How far the side veins, and the mesh with them, run forward from the midrib to the rim."""
    return 0.10 * smoothstep(0.0, 0.25, u) * (1 - smoothstep(0.65, 1.0, u))


def leaf_place(u, side):
    """The point at `u` along the leaf and `side` from -1 to 1 across it."""
    forward = u + leaf_lean(u) * abs(side)
    return LEAF_AXIS.at(forward, side * leaf_width(forward))


def leaf_coordinates(p):
    """Where `leaf_place` puts p: (u, side, distance from the midrib)."""
    forward, offset = LEAF_AXIS.project(p)
    side = offset / max(0.012, leaf_width(forward))
    u = forward
    for _ in range(4):
        u = forward - leaf_lean(u) * min(1.0, abs(side))
    return u, side, offset

FLESH = [(0.0, (0.27, 0.01, 0.05)), (0.25, (0.44, 0.02, 0.07)), (0.55, (0.70, 0.05, 0.10)), (0.82, (0.86, 0.13, 0.14)),
         (1.0, (0.94, 0.29, 0.22))]


def ellipse(p, centre, turn, a, b):
    """Distance from the centre of an ellipse, 1 on its rim."""
    q = (p - centre) * exp(-1j * math.radians(turn))
    return math.hypot(q.real / a, q.imag / b)


GLARE, SPARK = -0.43 + 0.42j, -0.72 + 0.00j


def paint_fruit(p):
    n = complex(p.real / 1.07, p.imag / 1.02)
    r = min(0.985, abs(n))
    n = n / abs(n) * r if abs(n) > 0 else n
    z = math.sqrt(1 - r * r)
    light = max(0.0, -0.46 * n.real + 0.56 * n.imag + 0.69 * z)
    colour = ramp(FLESH, light)
    # Light thrown back from below on the shadow side.
    back = smoothstep(0.62, 0.95, 0.62 * n.real - 0.74 * n.imag + 0.10 * z) * (0.35 + 0.65 * smoothstep(0.55, 0.9, r))
    colour = mix(colour, (0.80, 0.20, 0.22), 0.62 * back)
    # The dimple lies in shadow, with a lit lip in front of it.
    colour = mix(colour, (0.20, 0.01, 0.04), 0.80 * (1 - smoothstep(0.25, 1.1, ellipse(p, 0.01 + 0.80j, 0, 0.30, 0.17))))
    colour = mix(colour, (0.97, 0.42, 0.34), 0.45 * bump(ellipse(p, 0.02 + 0.80j, 0, 0.40, 0.27), 1.0, 0.16) *
                 smoothstep(0.25, -0.35, p.real))
    # The window's reflection: a soft bright patch, its core nearly white, and a spark beside it.
    glow = 1 - smoothstep(0.35, 1.25, ellipse(p, -0.42 + 0.40j, 48, 0.30, 0.19))
    colour = mix(colour, (0.98, 0.62, 0.55), 0.75 * glow)
    core = 1 - smoothstep(0.25, 1.3, ellipse(p, GLARE, 48, 0.19, 0.10))
    colour = mix(colour, (1.0, 0.97, 0.94), core)
    spark = 1 - smoothstep(0.1, 1.2, ellipse(p, SPARK, 75, 0.11, 0.045))
    return mix(colour, (1.0, 0.86, 0.80), 0.85 * spark)


def paint_stalk(p):
    t, offset = STALK_AXIS.project(p)
    across = offset / stalk_width(t)
    colour = ramp([(0.0, (0.33, 0.36, 0.10)), (0.25, (0.47, 0.55, 0.17)), (0.7, (0.50, 0.55, 0.19)), (0.9, (0.46, 0.37, 0.16)),
                   (1.0, (0.36, 0.22, 0.11))], t)
    colour = mix(colour, (0.80, 0.83, 0.48), 0.55 * smoothstep(-0.1, 0.9, across) * (1 - smoothstep(0.8, 1.0, t)))
    colour = mix(colour, (0.20, 0.21, 0.07), 0.60 * smoothstep(0.0, -0.9, across))
    # The torn end: light wood with dark pores.
    end = smoothstep(0.955, 0.985, t)
    wood = mix((0.66, 0.50, 0.31), (0.24, 0.14, 0.07), 0.5 + 0.5 * math.sin(95 * offset + 1.0))
    return mix(colour, wood, 0.8 * end)


def paint_leaf(p):
    u, side, offset = leaf_coordinates(p)
    # The half above the midrib faces the light.
    colour = mix((0.12, 0.40, 0.17), (0.37, 0.63, 0.22), smoothstep(-0.06, 0.06, side))
    colour = mix(colour, (0.06, 0.26, 0.13), 0.55 * smoothstep(0.45, 1.0, abs(side)) * (1.0 if side < 0 else 0.45))
    colour = mix(colour, (0.62, 0.80, 0.36), 0.30 * bump(u, 0.42, 0.18) * smoothstep(0.05, 0.5, side))
    # Side veins follow the rows of the mesh, two to a quad.
    vein = max(bump(u, at, 0.018) for at in LEAF_VEINS) * smoothstep(0.12, 0.2, u)
    colour = mix(colour, (0.66, 0.82, 0.42), 0.42 * vein * (1 - smoothstep(0.55, 0.95, abs(side))))
    rib = 1 - smoothstep(0.2, 1.0, abs(offset) / (0.026 * (1.08 - u)))
    colour = mix(colour, (0.76, 0.86, 0.52), 0.85 * rib)
    return mix(colour, (0.44, 0.50, 0.17), 0.8 * (1 - smoothstep(0.03, 0.15, u)))


LEAF_VEINS = [(a + (b - a) * half) for a, b in zip(LEAF_STOPS[1:], LEAF_STOPS[2:]) for half in (0.0, 0.5)] + [LEAF_STOPS[-1]]
FRUIT_PART, STALK_PART, LEAF_PART = range(3)
PAINT = [paint_fruit, paint_stalk, paint_leaf]


# ---- the input mesh: a hexagon in a ring of quads, a strip of quads for the stalk, another for the leaf ----

def input_mesh():
    """The mesh, the part of each face, and for each part the flat coordinates of its vertices."""
    gap = 3.6
    outer = [90 - gap] + [90 + gap + k * (360 - 2 * gap) / 5 for k in range(5)]
    inner = [(a + b) / 2 for a, b in zip(outer, [60 + 60 * k for k in range(6)])]
    flat = [{}, {}, {}]
    faces, parts = [], []

    def face(part, *corners):
        faces.append(list(corners))
        parts.append(part)

    for k in range(6):
        flat[FRUIT_PART][k] = 0.5 * exp(1j * math.radians(inner[k]))
        flat[FRUIT_PART][6 + k] = exp(1j * math.radians(outer[k]))
    face(FRUIT_PART, *range(6))
    for k in range(6):
        face(FRUIT_PART, k, 6 + k, 6 + (k + 1) % 6, (k + 1) % 6)

    # Flat coordinates of the strips: place along the axis, and side from -1 (right) to 1 (left).
    right, left = [6], [7]
    for _ in STALK_STOPS[1:]:
        right.append(12 + 2 * (len(right) - 1))
        left.append(right[-1] + 1)
    for k, t in enumerate(STALK_STOPS):
        flat[STALK_PART][right[k]] = complex(t, -1)
        flat[STALK_PART][left[k]] = complex(t, 1)
    for k in range(1, len(STALK_STOPS)):
        face(STALK_PART, right[k - 1], right[k], left[k], left[k - 1])

    lower, upper = [right[3]], [right[4]]
    stops = LEAF_STOPS
    first = left[-1] + 1
    for k in range(len(stops) - 1):
        lower.append(first + 2 * k)
        upper.append(first + 2 * k + 1)
    tip = upper[-1] + 1
    for k, u in enumerate(stops):
        flat[LEAF_PART][lower[k]] = complex(u, -1)
        flat[LEAF_PART][upper[k]] = complex(u, 1)
    flat[LEAF_PART][tip] = complex(1, 0)
    for k in range(1, len(stops)):
        face(LEAF_PART, lower[k - 1], lower[k], upper[k], upper[k - 1])
    face(LEAF_PART, lower[-1], tip, upper[-1])

    def polygon_radius(angle):
        degrees = math.degrees(angle) % 360
        for a, b in zip(outer, outer[1:] + [outer[0] + 360]):
            for turned in (degrees, degrees + 360):
                if a <= turned <= b:
                    half = math.radians(b - a) / 2
                    return math.cos(half) / math.cos(math.radians(turned - a) - half)
        raise AssertionError(angle)

    def place(part, q):
        """Where the flat point q of a part stands in the drawing."""
        if part == FRUIT_PART:
            angle = phase(q)
            # Control points stand a little outside the curve they make.
            return abs(q) / polygon_radius(angle) * fruit_radius(angle) * 1.025 * exp(1j * angle)
        if part == STALK_PART:
            return STALK_AXIS.at(q.real, q.imag * stalk_width(q.real))
        return leaf_place(q.real, q.imag)

    positions = {}
    for part in (FRUIT_PART, STALK_PART, LEAF_PART):
        for v, q in flat[part].items():
            positions.setdefault(v, place(part, q))
    mesh = InputMesh([positions[v] for v in range(len(positions))], faces)
    return mesh, parts, flat, place


# ---- the edits ----

def rounded(x):
    return round(x, 6)


class Drawing:
    def __init__(self):
        self.mesh, self.parts, self.flat, self.place = input_mesh()
        self.geometry, self.colours = [], []

    def part_of(self, level, half_edge):
        return self.parts[self.mesh.face[(half_edge >> (2 * level.number)) // 9]]

    def level_0_targets(self, level):
        """Wanted position of every level-0 vertex: the ternary step taken in flat coordinates, then placed."""
        mesh, targets = self.mesh, {}
        for part in (FRUIT_PART, STALK_PART, LEAF_PART):
            flat = self.flat[part]
            for h in range(mesh.interior):
                if self.parts[mesh.face[h]] != part:
                    continue
                corners = [flat[v] for v in mesh.faces[mesh.face[h]]]
                a, b, c = flat[mesh.origin[h]], flat[mesh.target(h)], flat[mesh.origin[mesh.prev[h]]]
                centre = sum(corners) / len(corners)
                edge_point, face_point = level.ternary_points(h)
                far_point = level.ternary_points(mesh.twin[h])[0]
                for vertex, q in ((mesh.origin[h], a), (edge_point, (2 * a + b) / 3), (far_point, (a + 2 * b) / 3),
                                  (face_point, (3 * a + b + c + 4 * centre) / 9)):
                    targets.setdefault(vertex, self.place(part, q))
        return targets

    def move(self, level, targets, beyond=False):
        """Geometry edits that bring vertices to their targets."""
        spokes = level.spokes()
        edits = []
        for v, target in sorted(targets.items()):
            delta = target - level.positions[v]
            if abs(delta) < 2e-4:
                continue
            edit = boundary_edit(level, spokes[v], delta) if beyond else sector_edit(level, spokes[v], delta)
            half_edge, a, b = edit
            edits.append((v, half_edge, rounded(a), rounded(b), beyond))
        for v, half_edge, a, b, beyond in edits:
            entry = {"level": level.number, "half_edge": half_edge, "vertex": v, "a": a, "b": b}
            if beyond:
                entry["frame"] = "boundary"
            self.geometry.append(entry)
        level.edit_geometry([(h, a, b, beyond) for _, h, a, b, beyond in edits])

    def paint(self, level, wanted):
        """Colour edits at the colour vertices that `wanted(part, position, miss)` picks, on all their sectors."""
        spokes = level.spokes()
        edits = []
        for v in sorted(level.colour_vertices):
            sectors = [h for h in spokes[v] if h < level.interior]
            position = level.limit(v, spokes[v])
            painted = {part: tuple(round(x, 3) for x in PAINT[part](position))
                       for part in {self.part_of(level, h) for h in sectors}}
            pick = False
            for h in sectors:
                part = self.part_of(level, h)
                miss = max(abs(x - y) for x, y in zip(painted[part], level.colours[h]))
                pick = pick or wanted(part, position, miss)
            if pick:
                edits += [(h, painted[self.part_of(level, h)]) for h in sectors]
        for h, colour in edits:
            self.colours.append({"level": level.number, "half_edge": h, "colour": list(colour)})
        level.edit_colours(edits)

    def boundary_of(self, level, part):
        """Boundary vertices of one part with their outward direction and position along the outline."""
        spokes = level.spokes()
        for h in range(level.interior):
            if level.twin[h] >= level.interior and self.part_of(level, h) == part:
                v = level.target(h)
                tangent = level.positions[v] - level.positions[level.origin[h]]
                if len(spokes[v]) == 3:
                    yield v, -1j * tangent / abs(tangent), tangent / abs(tangent)


def teeth(drawing, level):
    """The saw edge of the leaf: teeth that lean towards the tip."""
    targets = {}
    for v, out, along in drawing.boundary_of(level, LEAF_PART):
        p = level.positions[v]
        u, offset = LEAF_AXIS.project(p)
        if not 0.17 < u < 0.93:
            continue
        forward = along if (along / (LEAF_AXIS.at(min(1, u + 0.01), 0) - LEAF_AXIS.at(u, 0))).real > 0 else -along
        rise = ((u + (0.0 if offset > 0 else 0.027)) / 0.054) % 1.0
        if rise > 0.55:
            size = 0.020 * smoothstep(0.15, 0.35, u) * (1 - 0.5 * u)
            targets[v] = p + (out + 0.9 * forward) * size
    return targets


def bumps(drawing, level, centres, height, width):
    """Swellings of the stalk's outline at some places along it."""
    targets = {}
    for v, out, _ in drawing.boundary_of(level, STALK_PART):
        t, offset = STALK_AXIS.project(level.positions[v])
        size = sum(height * bump(t, centre, width) for centre, side in centres if (offset > 0) == side)
        if size > 0.15 * height:
            targets[v] = level.positions[v] + out * size
    return targets


def torn_end(drawing, level, depth, pitch):
    """Roughens the end of the stalk."""
    end, back = STALK_AXIS.at(1.0, 0), STALK_AXIS.at(0.97, 0)
    direction = (end - back) / abs(end - back)
    targets = {}
    for v, out, _ in drawing.boundary_of(level, STALK_PART):
        p = level.positions[v]
        if abs(((p - end) / direction).real) < 0.012 and abs(p - end) < 0.055:
            side = ((p - end) / direction).imag
            targets[v] = p + direction * depth * math.sin(pitch * side + 0.7)
    return targets


def draw():
    """The drawing and its finest level."""
    drawing = Drawing()
    level = ternary(drawing.mesh)
    drawing.move(level, drawing.level_0_targets(level))
    drawing.paint(level, lambda part, p, miss: True)

    level = level.catmull_clark()
    drawing.paint(level, lambda part, p, miss: miss > 0.015)

    level = level.catmull_clark()
    drawing.move(level, teeth(drawing, level), beyond=True)
    drawing.paint(level, lambda part, p, miss: miss > (0.03, 0.08, 0.05)[part])

    level = level.catmull_clark()
    drawing.move(level, bumps(drawing, level, [(0.40, True), (0.64, False)], 0.007, 0.02))
    drawing.paint(level, lambda part, p, miss: miss > (0.06, 0.14, 0.04)[part])

    level = level.catmull_clark()
    drawing.move(level, torn_end(drawing, level, 0.008, 90))
    fine = (lambda p: abs(p - GLARE) < 0.3 or abs(p - SPARK) < 0.14, lambda p: STALK_AXIS.project(p)[0] > 0.93,
            lambda p: abs(LEAF_AXIS.project(p)[1]) < 0.05)
    drawing.paint(level, lambda part, p, miss: miss > (0.04, 0.12, 0.09)[part] and fine[part](p))

    level = level.catmull_clark()
    drawing.move(level, torn_end(drawing, level, 0.0012, 300))
    drawing.paint(level, lambda part, p, miss: part != LEAF_PART and miss > (0.05, 0.10)[part] and
                  (part == STALK_PART and STALK_AXIS.project(p)[0] > 0.965 or part == FRUIT_PART and abs(p - SPARK) < 0.14))
    return drawing, level


def main():
    drawing, _ = draw()
    mesh = drawing.mesh
    members = [
        '"$schema": "schema.json"', '"gradtess": 1', '"technique": "subdivision"', '"name": "cherry"',
        listed("vertices", [[rounded(p.real), rounded(p.imag)] for p in mesh.positions]),
        listed("faces", mesh.faces),
        listed("geometry", drawing.geometry),
        listed("colour", drawing.colours),
    ]
    print("{\n  " + ",\n  ".join(members) + "\n}")


def listed(key, elements):
    return f'"{key}": [\n    ' + ",\n    ".join(json.dumps(element) for element in elements) + "\n  ]"


if __name__ == "__main__":
    main()
