"""Which surface owns each point of a board's boundary: a part of the solver in reproduce.md.

reproduce_drop.py calls `lay_out`, `is_flush` and `rounding`; all of them share one namespace.
"""


class Circle:
    is_line = False

    def __init__(self, number, x, y, distance):
        self.number, self.x, self.y, self.distance = number, x, y, distance
        self.d2, self.inverse, self.curvature = distance * distance, 1.0 / distance, 1.0 / distance
        self.owner = number


class Line:
    is_line, curvature = True, 0.0

    def __init__(self, number, x1, y1, x2, y2):
        self.number = self.owner = number
        self.ends, self.pieces = [number + 1, number + 2], []
        self.reach(x1, y1, x2, y2)

    def reach(self, x1, y1, x2, y2):
        dx, dy = x2 - x1, y2 - y1
        self.x, self.y, self.end, self.length = x1, y1, (x2, y2), sqrt(dx * dx + dy * dy)
        self.tx, self.ty = dx / self.length, dy / self.length
        self.nx, self.ny = -dy / self.length, dx / self.length

    def place(self, x, y):  # along the line and across it, and the rounding of both
        dx, dy = x - self.x, y - self.y
        along, across = dx * self.tx + dy * self.ty, dx * self.nx + dy * self.ny
        return along, across, rounding(x, y) + rounding(self.x, self.y)


def rounding(x, y):
    return PLACE_ROUNDING * (abs(x) + abs(y))


def lay_out(pegs, walls, radius):
    surfaces = [Circle(i, p["x"], p["y"], radius + p["radius"]) for i, p in enumerate(pegs)]
    lines = []
    for wall in walls:
        x1, y1, x2, y2 = (wall[name] for name in ("x1", "y1", "x2", "y2"))
        line = Line(len(surfaces), x1, y1, x2, y2)
        ends = Circle(line.number + 1, x1, y1, radius), Circle(line.number + 2, x2, y2, radius)
        surfaces += [line, *ends]
        lines.append((line, x1, y1, x2, y2))
    for i, (line, *_) in enumerate(lines):
        join(surfaces, line, [other for other, *_ in lines[i + 1 :]])
    for line, x1, y1, x2, y2 in lines:
        whole = surfaces[line.owner]
        places = whole.place(x1, y1)[0], whole.place(x2, y2)[0]
        whole.pieces.append(((line.number - len(pegs)) // 3, min(places), max(places)))
        for end in surfaces[line.number + 1 : line.number + 3]:
            end.owner = line.owner
    whole_lines = [line for line, *_ in lines if line.owner == line.number]
    for line in whole_lines:
        share_ends(surfaces[len(pegs) :], surfaces, line)
    for line in whole_lines:
        for which in (0, 1):
            pass_on_end(surfaces, whole_lines, surfaces[: len(pegs)], radius, line, which)
    return surfaces


def join(surfaces, line, later):
    grows = line.owner == line.number
    while grows:
        grows = False
        for other in later:
            if other.owner == other.number and are_one(line, other):
                extend(surfaces, line, other)
                other.owner, grows = line.number, True


def are_one(a, b):
    base, other = (b, a) if a.length < b.length else (a, b)
    s1, off1, near1 = base.place(other.x, other.y)
    s2, off2, near2 = base.place(*other.end)
    if abs(off1) > near1 or abs(off2) > near2:
        return False
    near = max(near1, near2)
    return max(s1, s2) >= -near and min(s1, s2) <= base.length + near


def extend(surfaces, line, other):
    first, last, low, high = (line.x, line.y), line.end, 0.0, line.length
    ends = list(line.ends)
    for number in other.ends:
        point = surfaces[number].x, surfaces[number].y
        along = line.place(*point)[0]
        if along < low:
            low, first, ends[0] = along, point, number
        if along > high:
            high, last, ends[1] = along, point, number
    line.reach(*first, *last)
    line.ends = ends


def share_ends(of_walls, surfaces, line):  # with an earlier wall's end in the same place
    for which in (0, 1):
        end = surfaces[line.ends[which]]
        end.owner = end.number
        for other in of_walls:
            if other is end or other.is_line or other.owner != other.number:
                continue
            if abs(end.x - other.x) + abs(end.y - other.y) <= rounding(end.x, end.y):
                end.owner = line.ends[which] = other.number
                break


def pass_on_end(surfaces, lines, pegs, radius, line, which):  # to what the end lies on
    end = surfaces[line.ends[which]]
    for other in lines:
        along, across, near = other.place(end.x, end.y)
        if abs(across) <= near < along < other.length - near:
            end.owner = other.number
    for peg in pegs:
        dx, dy = end.x - peg.x, end.y - peg.y
        reach = peg.distance - radius + rounding(end.x, end.y)
        if abs(dx) <= reach and abs(dy) <= reach and dx * dx + dy * dy <= reach * reach:
            end.owner = peg.number
            if is_flush(radius, line, 1.0, peg) or is_flush(radius, line, -1.0, peg):
                line.ends[which] = peg.number


def is_flush(radius, line, side, circle):
    dx, dy = circle.x - line.x, circle.y - line.y
    height = side * (line.nx * dx + line.ny * dy) + circle.distance
    near = rounding(circle.x, circle.y) + rounding(line.x, line.y)
    return abs(height - radius) <= near + PLACE_ROUNDING * circle.distance
