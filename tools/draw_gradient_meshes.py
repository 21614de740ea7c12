#!/usr/bin/env python3
"""Draws scenes/ferguson/*.json: locally refinable gradient meshes, one scene for each thing that they can do.

Each drawing is a few maps from a rectangle to the plane, sampled into quads with the maps' own derivatives as handles and
twists, and then operations: splits where there is detail, colours of single points and sectors.

Usage: tools/draw_gradient_meshes.py [FOLDER]     (default: scenes/ferguson beside this file)
"""

import json
import math
import sys
from pathlib import Path

STEP = 1e-4


def mix(a, b, t):
    return [x + (y - x) * t for x, y in zip(a, b)]


def shade(colour, light):
    """Darker below 1, towards white above."""
    return [c * light for c in colour] if light <= 1 else mix(colour, [1, 1, 1], light - 1)


class Drawing:
    def __init__(self, name):
        self.name = name
        self.points, self.known, self.curves, self.patches, self.operations = [], {}, {}, [], []

    def point(self, at):
        key = (round(at[0], 6), round(at[1], 6))
        if key not in self.known:
            self.known[key] = len(self.points)
            self.points.append([round(x, 6) + 0.0 for x in at])
        return self.known[key]

    def sheet(self, f, us, vs, colour):
        """Patches over a grid of parameters. `f(u, v)` is a place, `colour(u, v, i, j)` that of a corner of cell (i, j).
        Returns the numbers of the patches: [j][i]."""
        rows = []
        for j in range(len(vs) - 1):
            row = []
            for i in range(len(us) - 1):
                du, dv = us[i + 1] - us[i], vs[j + 1] - vs[j]
                ring = [(us[i], vs[j]), (us[i + 1], vs[j]), (us[i + 1], vs[j + 1]), (us[i], vs[j + 1])]

                def along(u, v, k):
                    e = STEP * (du if k == 0 else dv)
                    a, b = (f(u - e, v), f(u + e, v)) if k == 0 else (f(u, v - e), f(u, v + e))
                    return [(y - x) / (2 * STEP) for x, y in zip(a, b)]

                def twist(u, v):
                    e, g = STEP * du, STEP * dv
                    q = [f(u + e, v + g), f(u - e, v + g), f(u + e, v - g), f(u - e, v - g)]
                    return [round((q[0][k] - q[1][k] - q[2][k] + q[3][k]) / (4 * STEP * STEP), 4) + 0.0 for k in (0, 1)]

                ids = [self.point(f(u, v)) for u, v in ring]
                for side in range(4):
                    k, sign = side % 2, 1 if side < 2 else -1
                    (u0, v0), (u1, v1) = ring[side], ring[(side + 1) % 4]
                    a, b = f(u0, v0), f(u1, v1)
                    s, t = along(u0, v0, k), along(u1, v1, k)
                    pair = (ids[side], ids[(side + 1) % 4])
                    handles = [[a[x] + sign * s[x] / 3 for x in (0, 1)], [b[x] - sign * t[x] / 3 for x in (0, 1)]]
                    if pair[::-1] not in self.curves:
                        self.curves[pair] = [[round(x, 6) + 0.0 for x in h] for h in handles]
                row.append(len(self.patches))
                self.patches.append({
                    "points": ids,
                    "colours": [[round(min(1, max(0, c)), 4) for c in colour(u, v, i, j)] for u, v in ring],
                    "twists": [twist(u, v) for u, v in ring],
                })
            rows.append(row)
        self.count = len(self.patches)
        return rows

    def split(self, patch, axis, at=0.5):
        """Number of the new patch, the part with the greater parameter."""
        self.operations.append({"split": patch, axis: at})
        self.count += 1
        return self.count - 1

    def quarter(self, patch, u=0.5, v=0.5):
        """Two splits that cross: the four parts at corners A, B, C, D."""
        b = self.split(patch, "u", u)
        return [patch, b, self.split(b, "v", v), self.split(patch, "v", v)]

    def spot(self, patch, colour, u=0.5, v=0.5, tight=0.0):
        """A point inside a patch with a colour of its own; `tight`: how much of the patch around it stays as it was."""
        if tight > 0:
            high = self.split(patch, "u", 1 - tight)
            patch = self.split(patch, "u", tight / (1 - tight))
            self.split(patch, "v", 1 - tight)
            patch = self.split(patch, "v", tight / (1 - tight))
        parts = self.quarter(patch, u, v)
        self.colour(parts[0], 2, colour)
        return parts

    def colour(self, patch, corner, colour):
        self.operations.append({"colour": [patch, corner], "to": colour})

    def sector(self, patch, corner, colour):
        self.operations.append({"sector": [patch, corner], "to": colour})

    def write(self, folder):
        lines = lambda items: "[\n    " + ",\n    ".join(json.dumps(item) for item in items) + "\n  ]"
        curves = [{"points": list(pair), "handles": h} for pair, h in self.curves.items()]
        parts = [
            '"gradtess": 1', '"technique": "ferguson"', f'"name": {json.dumps(self.name)}',
            '"points": ' + lines(self.points), '"curves": ' + lines(curves), '"patches": ' + lines(self.patches),
        ]
        if self.operations:
            parts.append('"operations": ' + lines(self.operations))
        (folder / f"{self.name}.json").write_text("{\n  " + ",\n  ".join(parts) + "\n}\n")


def steps(a, b, n):
    return [a + (b - a) * k / n for k in range(n + 1)]


def local_refinement():
    """A plum: nine patches, and detail in three of them only."""
    d = Drawing("local_refinement")

    def f(u, v):
        x, y = 2 * u - 1, 2 * v - 1
        return 50 + 44 * x * math.sqrt(1 - 0.42 * y * y), 48 + 40 * y * math.sqrt(1 - 0.42 * x * x) + 5 * x * x

    def colour(u, v, i, j):
        light = 0.45 + 0.75 * v - 0.35 * u
        return shade(mix([0.33, 0.10, 0.38], [0.72, 0.22, 0.36], 0.8 * u * (1 - v) + 0.1), light + 0.35)

    rows = d.sheet(f, steps(0, 1, 3), steps(0, 1, 3), colour)
    # The light: a point in a quarter of the upper left patch, its neighbours as they were.
    d.spot(rows[2][0], [0.97, 0.93, 0.98], tight=0.22)
    # A bloom on the flank and a bruise below, each within one patch.
    parts = d.quarter(rows[1][1])
    d.colour(parts[0], 2, [0.62, 0.45, 0.78])
    d.spot(parts[2], [0.80, 0.66, 0.88])
    d.spot(rows[0][2], [0.35, 0.03, 0.10], u=0.4, v=0.55)
    return d


def sections():
    """The chain of the paper's Fig. 10: T1 and T2 on one curve, the stem of T1 points at T3, that of T3 at T4; then a
    handle of the curve is moved, and all of them follow."""
    d = Drawing("sections")

    def f(u, v):
        return 90 * u + 6 * math.sin(3 * v + 1), 60 * v + 5 * math.sin(4 * u)

    def colour(u, v, i, j):
        return mix(mix([0.93, 0.55, 0.20], [0.20, 0.40, 0.75], u), mix([0.95, 0.90, 0.55], [0.10, 0.15, 0.35], u), v)

    rows = d.sheet(f, steps(0, 1, 3), steps(0, 1, 2), colour)
    # The bar runs from P1 to P2 between the columns; the patch to its right is cut in three along it.
    low = rows[0][1]
    high = d.split(low, "v")
    top = d.split(high, "v")
    # The stem of T1 is the bar of T3, the stem of T3 that of T4.
    right = d.split(low, "u")
    upper = d.split(right, "v")
    d.split(upper, "u")
    d.split(top, "u", 0.4)
    d.colour(low, 1, [0.98, 0.25, 0.30])
    d.operations.append({"handle": [rows[0][0], 1, 0], "to": [41.0, 12.0]})
    d.operations.append({"move": [rows[0][0], 2], "to": [35.0, 37.0]})
    return d


def annulus(cx, cy, rx, ry):
    """Parameters: turns, radius."""
    return lambda u, v: (cx + rx * v * math.cos(math.tau * u), cy + ry * v * math.sin(math.tau * u))


def radial():
    """A flower (Fig. 15): rings of patches that close, petals that branch off, colours that differ by sector."""
    d = Drawing("radial")
    n = 6
    f = annulus(0, 0, 1, 1)

    def petal(u, v):
        wave = 1 + 0.14 * max(0, v - 30) / 15 * math.cos(math.tau * n * u)
        return f(u, v * wave)

    def inner(u, v, i, j):
        return shade([0.95, 0.75, 0.15], 0.75 + 0.3 * (v - 12) / 10 - 0.25 * math.sin(math.tau * u - 0.7))

    rows = d.sheet(petal, steps(0, 1, n), [10, 18, 26], inner)

    hues = [[0.90, 0.20, 0.35], [0.95, 0.45, 0.25], [0.80, 0.20, 0.60], [0.55, 0.25, 0.75], [0.30, 0.35, 0.85], [0.25, 0.6, 0.8]]

    def outer(u, v, i, j):
        return shade(hues[i], 1.45 - 0.45 * (v - 26) / 22 - (0.25 if abs(u * n - i) > 0.5 else 0))

    petals = d.sheet(petal, steps(0, 1, n), [26, 46], outer)[0]
    # Branches: every other petal has a tip.
    for i in range(0, n, 2):
        def tip(u, v, i=i):
            w = (v - 46) / 26
            base = petal(u, 46)
            a = math.tau * (i + 0.5) / n
            narrow = 1 - 0.62 * w
            mid = petal((i + 0.5) / n, 46)
            return (mid[0] + (base[0] - mid[0]) * narrow + 24 * w * math.cos(a),
                    mid[1] + (base[1] - mid[1]) * narrow + 24 * w * math.sin(a))
        d.sheet(tip, [i / n, (i + 1) / n], [46, 72], lambda u, v, a, b, i=i: shade(hues[i], 1.1 - 0.5 * (v - 46) / 26))
    for p in petals[1::2]:
        d.spot(p, [1.0, 0.97, 0.85], v=0.45)
    d.spot(rows[1][1], [1.0, 1.0, 0.8], tight=0.2)
    return d


def branching():
    """A key: a shaft with teeth, and a head that is one closed loop round a hole. Handles join smoothly where it forks."""
    d = Drawing("branching")
    brass = [0.80, 0.62, 0.22]

    def lit(u, v):
        return shade(brass, 0.62 + 0.75 * v + 0.12 * math.sin(6 * u))

    # The loop closes on itself: from one corner of the shaft round to the other.
    half = math.atan2(5.0, 16.0) / math.tau
    start, end = half, 1 - half
    ring = lambda u, v: (v * math.cos(math.tau * u) - 16, -v * math.sin(math.tau * u))
    turns = steps(start, end, 6)
    d.sheet(ring, turns, [10, math.hypot(16, 5)],
            lambda u, v, i, j: shade(brass, 0.95 - 0.45 * math.sin(math.tau * u - 0.6) * (1 if v < 12 else -0.6)))
    inside = [ring(start, 10), ring(end, 10)]
    outside = [ring(start, math.hypot(16, 5)), ring(end, math.hypot(16, 5))]

    # Between the ends of the loop, a patch with the shaft beside it.
    def neck(u, v):
        y = -1 + 2 * v
        a = (inside[0][0] + (0.8 * (1 - y * y)), inside[1][1] * y)
        b = (outside[0][0], outside[1][1] * y)
        return a[0] + (b[0] - a[0]) * u, a[1] + (b[1] - a[1]) * u

    d.sheet(neck, [0, 1], [0, 1], lambda u, v, i, j: lit(0, v))
    x0, w = outside[1]
    shaft = lambda u, v: (x0 + u, w * (2 * v - 1))
    cuts = [0, 14, 28, 34, 40, 46, 54]
    rows = d.sheet(shaft, cuts, [0, 1], lambda u, v, i, j: lit(u / 20, v))
    # Teeth: branches below the shaft.
    for i, deep in ((2, 9), (4, 12)):
        tooth = lambda u, v, deep=deep: (x0 + u, -w - deep * (1 - v))
        d.sheet(tooth, [cuts[i], cuts[i + 1]], [0, 1], lambda u, v, i, j: shade(brass, 0.45 + 0.2 * v))
    d.spot(rows[0][0], [1.0, 0.96, 0.75], v=0.7)
    d.split(rows[0][1], "v", 0.75)
    return d


def sharp_colours():
    """A flag of three bands in a wind: colours differ by sector along the seams, and one seam fades away."""
    d = Drawing("sharp_colours")

    def f(u, v):
        return 100 * u, 60 * v + 6 * math.sin(6.5 * u + 0.4 * v) * (0.3 + u)

    bands = [[0.16, 0.25, 0.60], [0.95, 0.93, 0.86], [0.80, 0.14, 0.20]]

    def colour(u, v, i, j):
        return shade(bands[j], 0.84 + 0.2 * math.cos(6.5 * u + 0.4))

    rows = d.sheet(f, steps(0, 1, 4), steps(0, 1, 3), colour)
    # A badge in the middle band: four colours meet in one point.
    parts = d.quarter(rows[1][1])
    for part, corner, c in zip(parts, (2, 3, 0, 1), ([0.9, 0.7, 0.1], [0.1, 0.5, 0.3], [0.9, 0.4, 0.1], [0.1, 0.3, 0.6])):
        d.sector(part, corner, c)
    # The upper seam is sharp at the mast only: further out both bands have one colour.
    for i in (2, 3):
        for u, corners in ((0, (3, 0)), (1, (2, 1))):
            if i + u > 2:
                c = [round(x, 4) for x in shade(mix(bands[1], bands[2], 0.5), 0.84 + 0.2 * math.cos(6.5 * (i + u) / 4 + 0.4))]
                d.sector(rows[1][i], corners[0], c)
                d.sector(rows[2][i], corners[1], c)
    return d


def still_life():
    """A mug and a doughnut on a table, and all that these meshes can do."""
    d = Drawing("still_life")
    # Wall and table: colours are sharp where they meet.
    horizon = 66
    wall, wood = [0.55, 0.60, 0.62], [0.56, 0.36, 0.22]

    def paint(u, v, i, j):
        if j == 1:
            return shade(wall, 1.28 - u / 200 - (120 - v) / 300)
        return shade(wood, 0.72 + 0.7 * v / horizon - u / 500)

    xs = [0, 44, 88, 128, 170]
    flat = lambda u, v: (u, v)
    rows = d.sheet(flat, xs, [0, horizon, 120], paint)
    # Shadows in the table: splits in the patches that have them.
    for p, u, v, dark in ((rows[0][1], 0.55, 0.5, 0.32), (rows[0][2], 0.62, 0.36, 0.28)):
        parts = d.quarter(p, u, v)
        d.colour(parts[0], 2, shade(wood, dark))
    parts = d.quarter(rows[0][3], 0.45, 0.4)
    d.colour(parts[0], 2, shade(wood, 0.45))
    d.spot(rows[1][0], [0.90, 0.93, 0.92], u=0.4, v=0.6)
    room_operations = d.operations
    d.operations = []
    clay = [0.16, 0.42, 0.52]
    cx, r, y0, h, b = 58.0, 24.0, 30.0, 48.0, 7.0
    body = lambda u, v: (cx + r * (2 * u - 1), y0 + h * v - b * (1 - (2 * u - 1) ** 2))

    def glaze(u, v, i, j):
        light = 0.55 + 0.95 * math.exp(-((u - 0.28) / 0.22) ** 2) - 0.12 * (u > 0.9)
        return shade([0.90, 0.86, 0.78] if j == 1 else clay, min(light, 1.25))

    rows = d.sheet(body, steps(0, 1, 4), [0, 0.3, 0.7, 1.0], glaze)
    # Rim and inside: two more rows in the same mesh, sharp against the glaze.
    top = y0 + h
    rim = lambda u, v: (cx + r * (2 * u - 1) * (1 - 0.02 * v), top - b * (1 - (2 * u - 1) ** 2) + 1.6 * v)
    d.sheet(rim, steps(0, 1, 4), [0, 1], lambda u, v, i, j: shade([0.93, 0.90, 0.84], 1.1 - 0.35 * u))
    side = lambda u: 2 * u - 1
    inner = lambda u, v: (cx + r * side(u) * 0.98, (top - b * (1 - side(u) ** 2) + 1.6) * (1 - v) + v * (top + 3.2 + b * (1 - side(u) ** 2)))
    d.sheet(inner, steps(0, 1, 4), [0, 1], lambda u, v, i, j: shade([0.62, 0.50, 0.40], 0.35 + 0.5 * v + 0.35 * u))
    # The handle: a branch that leaves the mug and comes back, so that there is a hole.
    ym, low, high = y0 + 0.5 * h, 0.2 * h, 0.5 * h
    xr = cx + r
    bow = lambda u, v: (xr + 1.05 * v * math.sin(math.pi * u), ym + v * math.cos(math.pi * u))
    d.sheet(bow, steps(0, 1, 4), [low, high],
            lambda u, v, i, j: shade(clay, (1.15 if v > 12 else 0.6) - 0.5 * u * u))
    # The doughnut: rings that close round a hole; icing and dough are sharp against each other.
    cake = annulus(124, 27, 1, 0.62)
    n = 8
    wavy = lambda u, v: cake(u, v + (1.3 * math.sin(math.tau * 3 * u + 0.5) * max(0, 1 - abs(v - 22) / 4)))
    dough, icing = [0.78, 0.52, 0.26], [0.93, 0.50, 0.62]

    def bake(u, v, i, j):
        sun = math.cos(math.tau * u - 2.2)
        if j == 0:
            return shade(dough, 0.55 - 0.25 * sun)
        if j == 1:
            return shade(icing, 1.0 + (0.22 if v > 20 else 0.05) * sun)
        return shade(dough, 0.80 + (0.30 if v < 25 else 0.15) * sun)

    # Orientation as in the other maps: u runs clockwise, v outwards.
    turned = lambda u, v: wavy(-u, v)
    cakes = d.sheet(turned, steps(0, 1, n), [6.5, 10, 22, 29], lambda u, v, i, j: bake(-u, v, i, j))
    # Patches have numbers now; the room's splits come first in the file, so the others count on from there.
    shift = sum(1 for o in room_operations if "split" in o)
    d.operations = renumbered(room_operations, len(d.patches) - 8)
    d.count = len(d.patches) + shift
    # Lights: local refinement of one patch each, and a chain of T-sections down the mug.
    d.spot(rows[1][1], [1.0, 1.0, 0.98], u=0.3, v=0.6, tight=0.15)
    lower = d.split(rows[0][1], "u", 0.4)
    d.split(lower, "v", 0.5)
    d.spot(lower, [0.45, 0.75, 0.82])
    for i in (4, 5):
        d.spot(cakes[1][i], [1.0, 0.93, 0.95], v=0.6)
    d.sector(cakes[1][1], 2, [0.99, 0.80, 0.30])
    return d


def colour_spaces():
    """Two rows of three patches in pure colours, as the paper compares spaces with (Fig. 18): blue beside yellow, red beside
    cyan, green beside red."""
    d = Drawing("colour_spaces")
    red, yellow, green, cyan, blue, magenta = [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1], [1, 0, 1]
    grid = [[blue, yellow, red, cyan], [yellow, magenta, green, red], [green, blue, yellow, blue]]
    d.sheet(lambda u, v: (40 * u, 40 * v), [0, 1, 2, 3], [0, 1, 2], lambda u, v, i, j: grid[v][u])
    return d


def renumbered(operations, by):
    """Operations that were written when there were only eight patches: numbers of split parts move up."""
    move = lambda p: p if p < 8 else p + by
    out = []
    for o in operations:
        o = dict(o)
        for key in ("split",):
            if key in o:
                o[key] = move(o[key])
        for key in ("colour", "sector"):
            if key in o:
                o[key] = [move(o[key][0]), o[key][1]]
        out.append(o)
    return out


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent / "scenes" / "ferguson"
    folder.mkdir(parents=True, exist_ok=True)
    for drawing in (local_refinement(), sections(), radial(), branching(), sharp_colours(), still_life(), colour_spaces()):
        drawing.write(folder)


if __name__ == "__main__":
    main()
