"""Subdivision gradient meshes for drawing scripts: names and places of everything that can be edited.

A slow, plain second implementation of M^l = C^l T M, used to draw scenes and never by the program itself. Numbers follow
ZHHK22 App. A: interior half-edges first, face by face; half-edge k of an input face ends in the face's vertex k.
Positions are complex numbers, colours tuples.
"""

import cmath
import math


class Topology:
    """Half-edges: origin, next, prev and twin; `interior` is their number inside faces, boundary ones follow."""

    def target(self, h):
        return self.origin[self.next[h]] if h < self.interior else self.origin[self.twin[h]]

    def spokes(self):
        """The half-edges that leave each vertex, boundary ones included."""
        spokes = [[] for _ in self.positions]
        for h, v in enumerate(self.origin):
            spokes[v].append(h)
        return spokes


class InputMesh(Topology):
    def __init__(self, positions, faces):
        self.positions, self.faces = positions, faces
        self.origin, self.next, self.prev, self.face = [], [], [], []
        for f, corners in enumerate(faces):
            first, n = len(self.origin), len(corners)
            for k in range(n):
                self.origin.append(corners[k - 1])
                self.next.append(first + (k + 1) % n)
                self.prev.append(first + (k - 1) % n)
                self.face.append(f)
        self.interior = len(self.origin)
        by_ends = {(self.origin[h], self.origin[self.next[h]]): h for h in range(self.interior)}
        assert len(by_ends) == self.interior, "an edge occurs twice in the same direction"
        self.twin = [by_ends.get((b, a)) for (a, b) in by_ends]
        leaving = {}
        for h in range(self.interior):
            if self.twin[h] is None:
                self.twin[h] = len(self.origin)
                leaving[self.origin[self.next[h]]] = len(self.origin)
                self.origin.append(self.origin[self.next[h]])
                self.twin.append(h)
        close_boundary(self)


def close_boundary(mesh):
    """Links the boundary half-edges into loops."""
    boundary = range(mesh.interior, len(mesh.origin))
    leaving = {mesh.origin[g]: g for g in boundary}
    del mesh.next[mesh.interior:], mesh.prev[mesh.interior:]
    mesh.next += [leaving[mesh.origin[mesh.twin[g]]] for g in boundary]
    mesh.prev += [0] * len(boundary)
    for g in boundary:
        mesh.prev[mesh.next[g]] = g


def ternary(mesh):
    """M^0 of an input mesh, white."""
    s, every, vertices = mesh.interior, len(mesh.origin), len(mesh.positions)
    level = Level(0, 9 * s)
    level.ternary_points = lambda h: (vertices + h, vertices + every + h if h < s else None)
    first_boundary = lambda g: 9 * s + 3 * (g - s)
    level.origin, level.next = [0] * (9 * s), [0] * (9 * s)
    level.twin, level.face = [0] * (9 * s), [0] * (9 * s)
    for h in range(s):
        n, p, t = mesh.next[h], mesh.prev[h], mesh.twin[h]
        b, c = level.ternary_points(h)
        far, c_next = level.ternary_points(t)[0], level.ternary_points(n)[1]
        level.origin[9 * h:9 * h + 9] = [mesh.origin[h], b, far, b, c, far, c_next, c_next, c]
        corner, middle = [9 * h, 9 * h + 3, 9 * p + 6, 9 * p + 2], [9 * h + 1, 9 * h + 5, 9 * h + 7, 9 * h + 4]
        for face, loop in ((2 * h, corner), (2 * h + 1, middle)):
            for k in range(4):
                level.next[loop[k - 1]] = loop[k]
                level.face[loop[k]] = face
        level.next[9 * h + 8] = 9 * n + 8
        level.face[9 * h + 8] = 2 * s + mesh.face[h]
        for k in range(3):
            level.twin[9 * h + k] = 9 * t + 2 - k if t < s else first_boundary(t) + 2 - k
        for k in (3, 5, 7):
            level.twin[9 * h + k], level.twin[9 * h + k + 1] = 9 * h + k + 1, 9 * h + k
    for g in range(s, every):
        for k in range(3):
            twin = 9 * mesh.twin[g] + 2 - k
            level.twin.append(twin)
            level.origin.append(level.origin[level.next[twin]])
    level.faces = 2 * s + len(mesh.faces)
    level.finish()
    positions = list(mesh.positions) + [0j] * (every + s)
    for h in range(every):
        a, b = mesh.positions[mesh.origin[h]], mesh.positions[mesh.target(h)]
        positions[vertices + h] = (2 * a + b) / 3
        if h < s:
            c = mesh.positions[mesh.origin[mesh.prev[h]]]
            corners = mesh.faces[mesh.face[h]]
            centre = sum(mesh.positions[v] for v in corners) / len(corners)
            positions[vertices + every + h] = (3 * a + b + c + 4 * centre) / 9
    level.positions = positions
    level.colours = [(1.0, 1.0, 1.0)] * (9 * s)
    level.sharp = [h >= 9 * s or level.twin[h] >= 9 * s for h in range(len(level.origin))]
    level.colour_vertices = set(range(vertices))
    return level


def average(colours):
    n = len(colours)
    return tuple(sum(c[k] for c in colours) / n for k in range(3))


class Level(Topology):
    """M^number with positions, a colour for each interior half-edge (its origin's corner) and sharp flags."""

    def __init__(self, number, interior):
        self.number, self.interior = number, interior

    def finish(self):
        self.prev = [0] * len(self.next)
        for h, n in enumerate(self.next):
            self.prev[n] = h
        close_boundary(self)

    def straight(self, h):
        """The spoke opposite to `h` at its target, where one is."""
        if h >= self.interior:
            return self.next[h]
        across = self.twin[self.next[h]]
        return self.next[across] if across < self.interior else None

    def limit(self, v, spokes):
        """Limit position of a vertex."""
        p, n = self.positions[v], len(spokes)
        outside = [h for h in spokes if h >= self.interior]
        if outside:
            if n == 2:
                return p
            return (self.positions[self.target(outside[0])] + 4 * p
                    + self.positions[self.origin[self.prev[outside[0]]]]) / 6
        total = 0
        for h in spokes:
            corners, e = [], h
            while not corners or e != h:
                corners.append(self.positions[self.origin[e]])
                e = self.next[e]
            total += (p + self.positions[self.target(h)]) / 2 + sum(corners) / len(corners)
        return (n - 3) / (n + 5) * p + 4 / (n * (n + 5)) * total

    def edit_geometry(self, edits):
        """Adds the displacements of (half-edge, a, b, beyond) edits, all measured before any of them."""
        moves = []
        for h, a, b, beyond in edits:
            if beyond:
                e1, e2, v = boundary_frame(self, h)
                angle = cmath.phase(e1) + opening(e1, e2) * a
                moves.append((v, math.sqrt(b * abs(e1) * abs(e2)) * cmath.exp(1j * angle)))
            else:
                e1, e2, v = sector_frame(self, h)
                moves.append((v, a * e1 + b * e2))
        for v, move in moves:
            self.positions[v] += move

    def edit_colours(self, edits):
        """Sets colours of sectors, spreads them over the one-ring and finds the new sharp edges."""
        for h, colour in edits:
            self.colours[h] = colour
        edited = {self.origin[h] for h, _ in edits}
        # Sectors of an edited vertex spread their colour whether they are edited themselves or not.
        for h in [h for h in range(self.interior) if self.origin[h] in edited]:
            colour = self.colours[h]
            to_c = self.next[h]
            from_d = self.prev[h]
            self.colours[to_c] = self.colours[from_d] = colour
            c = start = self.next[to_c]
            while True:
                self.colours[c] = colour
                c = self.twin[self.prev[c]]
                if c == start or c >= self.interior:
                    break
            for e in (to_c, self.next[to_c]):
                across = self.twin[e]
                if across < self.interior:
                    # `e` runs a to c or c to d; the corner of a (of d) in the face beyond.
                    self.colours[self.next[across] if e == to_c else across] = colour
        for h, _ in edits:
            for spoke, other in ((h, self.next[self.twin[h]]), (self.twin[self.prev[h]], self.twin[self.prev[h]])):
                outside = self.twin[h] >= self.interior if spoke == h else spoke >= self.interior
                if outside or self.colours[other] != self.colours[h]:
                    e = spoke
                    for _ in range(3):
                        self.sharp[e] = self.sharp[self.twin[e]] = True
                        e = self.straight(e)

    def catmull_clark(self):
        """M^(number + 1)."""
        s, every, old = self.interior, len(self.origin), len(self.positions)
        edge_point, ranked = [0] * every, old
        for h in range(s):
            if h < self.twin[h]:
                edge_point[h] = edge_point[self.twin[h]] = ranked
                ranked += 1
        fine = Level(self.number + 1, 4 * s)
        face_point = [old + every // 2 + f for f in self.face]
        fine.origin, fine.next, fine.twin, fine.face = ([0] * (4 * s) for _ in range(4))
        fine.sharp = [False] * (4 * s)
        for h in range(s):
            p, t = self.prev[h], self.twin[h]
            fine.origin[4 * h:4 * h + 4] = [self.origin[h], edge_point[h], edge_point[h], face_point[h]]
            loop = (4 * h, 4 * h + 2, 4 * p + 3, 4 * p + 1)
            for k in range(4):
                fine.next[loop[k - 1]] = loop[k]
                fine.face[loop[k]] = h
            outer = 4 * t if t < s else 4 * s + 2 * (t - s)
            fine.twin[4 * h:4 * h + 4] = [outer + 1, outer, 4 * h + 3, 4 * h + 2]
            fine.sharp[4 * h] = fine.sharp[4 * h + 1] = self.sharp[h]
        for g in range(s, every):
            t = self.twin[g]
            fine.origin += [self.origin[g], edge_point[g]]
            fine.twin += [4 * t + 1, 4 * t]
            fine.sharp += [True, True]
        fine.faces = s
        fine.finish()
        self.refine_positions(fine, edge_point, old + every // 2)
        self.refine_colours(fine)
        fine.find_colour_vertices(self.colour_vertices)
        return fine

    def refine_positions(self, fine, edge_point, first_face):
        s, every, p = self.interior, len(self.origin), self.positions
        total, count = [0j] * self.faces, [0] * self.faces
        for h in range(s):
            total[self.face[h]] += p[self.origin[h]]
            count[self.face[h]] += 1
        centres = [a / n for a, n in zip(total, count)]
        positions = list(p) + [0j] * (every // 2) + centres
        around, faces, valence = [0j] * len(p), [0j] * len(p), [0] * len(p)
        for h in range(every):
            around[self.origin[h]] += p[self.target(h)]
            valence[self.origin[h]] += 1
            if h < s:
                faces[self.origin[h]] += centres[self.face[h]]
                ends = p[self.origin[h]] + p[self.target(h)]
                t = self.twin[h]
                if t >= s:
                    positions[edge_point[h]] = ends / 2
                elif h < t:
                    positions[edge_point[h]] = (ends + centres[self.face[h]] + centres[self.face[t]]) / 4
        for v, n in enumerate(valence):
            positions[v] = ((n - 2) * p[v] + around[v] / n + faces[v] / n) / n
        for g in range(s, every):
            v = self.origin[g]
            a, b = p[self.target(g)], p[self.origin[self.prev[g]]]
            positions[v] = p[v] if valence[v] == 2 else (a + 6 * p[v] + b) / 8
        fine.positions = positions

    def refine_colours(self, fine):
        s, c = self.interior, self.colours
        corners = [[] for _ in range(self.faces)]
        for h in range(s):
            corners[self.face[h]].append(c[h])
        centre = [average(colours) for colours in corners]
        fine.colours = [None] * (4 * s)
        for h in range(s):
            own = (c[h], c[self.next[h]])
            beyond = (centre[self.face[h]], centre[self.face[self.twin[h]]]) if not self.sharp[h] else ()
            edge = average(own + beyond)
            fine.colours[4 * h + 1] = fine.colours[4 * h + 2] = edge
            fine.colours[4 * h + 3] = centre[self.face[h]]
        for spokes in self.spokes():
            cuts = [h for h in spokes if self.sharp[h]]
            if len(cuts) <= 1:
                n = len(spokes)
                star = average([average([c[self.next[h]], c[self.twin[h]]]) for h in spokes])
                faces = average([centre[self.face[h]] for h in spokes])
                own = average([c[h] for h in spokes])
                colour = tuple(((n - 2) * v + a + f) / n for v, a, f in zip(own, star, faces))
                for h in spokes:
                    fine.colours[4 * h] = colour
                continue
            for first in cuts:
                if first >= s:
                    continue
                sector, e = [first], self.twin[self.prev[first]]
                while not self.sharp[e]:
                    sector.append(e)
                    e = self.twin[self.prev[e]]
                a, b = c[self.next[first]], c[self.prev[sector[-1]]]
                for h in sector:
                    kept = c[h] if len(sector) == 1 else tuple((x + 6 * y + z) / 8 for x, y, z in zip(a, c[h], b))
                    fine.colours[4 * h] = kept

    def find_colour_vertices(self, known):
        """Vertices reached from the known ones in steps of three edges straight on."""
        spokes = self.spokes()
        found, waiting = set(known), list(known)
        while waiting:
            for h in spokes[waiting.pop()]:
                for _ in range(2):
                    h = self.straight(h) if h is not None else None
                if h is not None and self.target(h) not in found:
                    found.add(self.target(h))
                    waiting.append(self.target(h))
        self.colour_vertices = found


def sector_frame(level, h):
    """e1, e2 and the vertex of a sector edit at half-edge h."""
    v = level.origin[h]
    e2 = level.twin[level.prev[h]]
    p = level.positions
    return p[level.target(h)] - p[v], p[level.target(e2)] - p[v], v


def boundary_frame(level, h):
    """e1, e2 and the vertex of a boundary edit at the interior half-edge h."""
    return sector_frame(level, level.twin[h])


def opening(e1, e2):
    """The angle from e1 to e2, from 0 to a full turn."""
    return (cmath.phase(e2) - cmath.phase(e1)) % (2 * math.pi)


def sector_edit(level, spokes, delta):
    """(half-edge, a, b) of a displacement, in the sector where it is best expressed."""
    best = None
    for h in spokes:
        if h >= level.interior:
            continue
        e1, e2, _ = sector_frame(level, h)
        area = (e1.conjugate() * e2).imag
        if abs(area) < 1e-9:
            continue
        a, b = (delta.conjugate() * e2).imag / area, (e1.conjugate() * delta).imag / area
        # Small coordinates that point into the sector are what a person dragging the vertex would make.
        cost = abs(a) + abs(b) + (0 if a >= 0 and b >= 0 else 0.5)
        if best is None or cost < best[0]:
            best = (cost, h, a, b)
    return best[1:]


def boundary_edit(level, spokes, delta):
    """(half-edge, a, b) of a displacement beyond the boundary."""
    outside = next(h for h in spokes if h >= level.interior)
    h = level.twin[outside]
    e1, e2, _ = boundary_frame(level, h)
    return h, opening(e1, delta) / opening(e1, e2), abs(delta) ** 2 / (abs(e1) * abs(e2))
