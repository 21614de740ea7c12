#!/usr/bin/env python3
"""Writes the coarse meshes of scenes/pattern/: a displaced sphere, a character with two creases, an ocean.

usage: tools/draw_patterns.py [FOLDER]
"""
import json
import math
import sys
from pathlib import Path


def icosahedron():
    phi = (1 + 5**0.5) / 2
    points = []
    for a in (-1, 1):
        for b in (-phi, phi):
            points += [(0, a, b), (a, b, 0), (b, 0, a)]
    points = [unit(p) for p in points]
    edge = min(distance(points[0], q) for q in points[1:])
    faces = []
    for i in range(12):
        for j in range(i + 1, 12):
            for k in range(j + 1, 12):
                if all(distance(points[a], points[b]) < 1.01 * edge for a, b in ((i, j), (j, k), (k, i))):
                    faces.append((i, j, k) if det(points[i], points[j], points[k]) > 0 else (i, k, j))
    return points, faces


def unit(p):
    n = math.sqrt(sum(x * x for x in p))
    return tuple(x / n for x in p)


def distance(p, q):
    return math.dist(p, q)


def det(a, b, c):
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def halve(points, faces):
    points, made, out = list(points), {}, []

    def middle(a, b):
        key = (min(a, b), max(a, b))
        if key not in made:
            made[key] = len(points)
            points.append(unit(tuple((x + y) / 2 for x, y in zip(points[a], points[b]))))
        return made[key]

    for a, b, c in faces:
        ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
        out += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return points, out


def rounded(rows, digits=6):
    return [[round(x, digits) + 0.0 for x in row] for row in rows]


def sphere():
    points, faces = halve(*icosahedron())
    return {
        "name": "displaced sphere",
        "level": 64,
        "evaluator": "pn",
        "displacement": {"kind": "sine", "amplitude": 0.04, "frequency": 40.0},
        "positions": rounded([(p[0] * 1.0, p[1] * 0.8, p[2] * 0.9) for p in points]),
        "normals": rounded([unit((p[0], p[1] / 0.8, p[2] / 0.9)) for p in points]),
        "colours": rounded([(0.75 + 0.2 * p[0], 0.6 + 0.2 * p[1], 0.5 - 0.2 * p[2]) for p in points], 3),
        "faces": [list(f) for f in faces],
    }


def tube(rings, segments):
    """Closed surface of rings (centre y, radius x, radius z, shift z), a point at both ends."""
    points = [(0.0, rings[0][0], rings[0][3])]
    for y, rx, rz, z in rings[1:-1]:
        for k in range(segments):
            t = 2 * math.pi * k / segments
            points.append((rx * math.sin(t), y, rz * math.cos(t) + z))
    points.append((0.0, rings[-1][0], rings[-1][3]))
    at = lambda ring, k: 1 + (ring - 1) * segments + k % segments
    faces = [(0, at(1, k + 1), at(1, k)) for k in range(segments)]
    for r in range(1, len(rings) - 2):
        for k in range(segments):
            a, b, c, d = at(r, k), at(r, k + 1), at(r + 1, k + 1), at(r + 1, k)
            faces += [(a, b, c), (a, c, d)]
    last = len(points) - 1
    faces += [(last, at(len(rings) - 2, k), at(len(rings) - 2, k + 1)) for k in range(segments)]
    return points, faces, at


def character():
    # Body and head: 10 segments and 8 full rings make 2 * 10 + 7 * 20 = 160 triangles.
    rings = [
        (-1.0, 0, 0, 0.0),
        (-0.95, 0.45, 0.4, 0.0),
        (-0.6, 0.62, 0.55, 0.02),
        (-0.2, 0.5, 0.42, 0.0),
        (0.08, 0.3, 0.26, 0.0),
        (0.3, 0.44, 0.4, 0.05),
        (0.6, 0.5, 0.5, 0.07),
        (0.85, 0.4, 0.38, 0.03),
        (1.0, 0.2, 0.2, 0.0),
        (1.05, 0, 0, 0.0),
    ]
    points, faces, at = tube(rings, 10)
    tags = []
    # Two creases: the belt under the chest and the brim above the brow.
    for ring, sharp in ((2, 1.0), (6, 0.9)):
        for k in range(10):
            tags.append({"vertex": at(ring, k), "sharpness": sharp, "bias": 0.0, "deviation": [0.0, 0.9, 0.0]})
    tags.append({"vertex": len(points) - 1, "tension": 0.6})
    colours = []
    for p in points:
        colours.append((0.85, 0.68, 0.55) if p[1] > 0.25 else (0.35, 0.5, 0.75) if p[1] > -0.65 else (0.3, 0.28, 0.35))
    return {
        "name": "character",
        "level": 32,
        "evaluator": "st",
        "positions": rounded(points),
        "colours": rounded(colours, 3),
        "tags": tags,
        "faces": [list(f) for f in faces],
    }


def ocean():
    n = 8
    points = [(4.0 * i / n - 2.0, 0.0, 4.0 * j / n - 2.0) for j in range(n + 1) for i in range(n + 1)]
    faces = []
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i
            faces += [(a, a + n + 1, a + n + 2), (a, a + n + 2, a + 1)]
    return {
        "name": "ocean",
        "level": 32,
        "evaluator": "linear",
        "displacement": {"kind": "noise", "amplitude": 0.25, "frequency": 1.1, "octaves": 5, "gain": 0.45, "speed": 0.6},
        "positions": rounded(points),
        "normals": [[0, 1, 0]] * len(points),
        "colours": [[0.1, 0.35, 0.5]] * len(points),
        "faces": [list(f) for f in faces],
    }


def write(path, scene):
    whole = {"$schema": "../schema.json", "gradtess": 1, "technique": "pattern", **scene}
    lines = []
    for key, value in whole.items():
        if isinstance(value, list):
            rows = ",\n    ".join(json.dumps(row) for row in value)
            lines.append(f"  {json.dumps(key)}: [\n    {rows}\n  ]")
        else:
            lines.append(f"  {json.dumps(key)}: {json.dumps(value)}")
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent / "scenes/pattern")
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in (("sphere", sphere), ("character", character), ("ocean", ocean)):
        write(folder / f"{name}.json", make())
