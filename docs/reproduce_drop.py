"""The exact solver without any code of the project; reproduce.md explains it.

    plinko boards triangle-8 > board.json
    plinko drop triangle-8 --seed 42 --json > record.json
    python reproduce_drop.py board.json record.json

computes the drop again and prints both digests. The other files named reproduce_*.py are the rest of
the solver; all of them share one namespace.
"""

import hashlib
import json
import sys
from math import sqrt
from pathlib import Path
from struct import pack

PHYSICS_VERSION = 6
NO_HIT = -1.0
MOST_STEPS = 1000  # of one search
NEGLIGIBLE, PLACE_ROUNDING, TRUE_WITHIN = 2.0**-54, 2.0**-50, 1e-9
MAX_EVENTS, MAX_TIME = 100_000, 1000.0  # s
LANDED, WEDGED, BALANCED, EVENT_LIMIT, TIME_LIMIT = 0, 1, 2, 4, 5  # how a drop ends
IMPULSE_LIMIT, FALSE_PATH = 7, 8
PEG, WALL, BEGINS, CHANGES, ENDS, LANDING = range(6)  # kinds of events


def start_x(seed, zone, aim=None):
    mask = 2**64 - 1
    z = (seed + 0x9E3779B97F4A7C15) & mask
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
    fraction = ((z ^ (z >> 31)) >> 11) * 2.0**-53
    middle = zone["x"] if aim is None else aim
    return middle + zone["jitter"] * (2.0 * fraction - 1.0)


def pair(a, b):
    return max(a["restitution"], b["restitution"]), sqrt(a["friction"] * b["friction"])


class Board:
    def __init__(self, form):
        self.ball, self.radius = form["ball"], form["ball"]["radius"]
        self.gravity, self.drag = form["gravity"], form["drag"]
        self.bins_y, self.edges = form["bins"]["y"], form["bins"]["edges"]
        self.pegs = len(form["pegs"])
        self.materials = (
            pair(self.ball, form["peg_material"]),
            pair(self.ball, form["wall_material"]),
        )
        self.surfaces = lay_out(form["pegs"], form["walls"], self.radius)
        self.travel = 0.35 * self.pitch(form)
        self.fall = sqrt(2.0 * self.travel / self.gravity) if self.gravity > 0.0 else 1.0

    def pitch(self, form):  # mean spacing of the pegs
        if self.pegs < 2:
            lines = [each for each in self.surfaces if each.is_line]
            sides = [abs(b - a) for w in lines for a, b in zip((w.x, w.y), w.end)]
            return max(max([self.radius, *sides]) / 8.0, 4.0 * self.radius)
        xs, ys = [p["x"] for p in form["pegs"]], [p["y"] for p in form["pegs"]]
        width, height = max(xs) - min(xs), max(ys) - min(ys)
        area = max(width, 1e-3 * height) * max(height, 1e-3 * width)
        return max(sqrt(area / self.pegs), self.radius)

    def pair_of(self, number):
        return self.materials[0 if number < self.pegs else 1]

    def wall_at(self, number, x, y):  # the wall that a ball at (x, y) touches
        surface = self.surfaces[number]
        if not surface.is_line:
            return (number - self.pegs) // 3
        foot = (x - surface.x) * surface.tx + (y - surface.y) * surface.ty
        return min(surface.pieces, key=lambda piece: max(piece[1] - foot, foot - piece[2], 0.0))[0]

    def index(self, number, x, y):  # as contact events name a surface
        return number if number < self.pegs else -1 - self.wall_at(number, x, y)


C = [1.0 / n for n in (2, 6, 24, 120, 720, 5040, 40320, 362880, 3628800, 39916800, 479001600)]


def phi2(z):
    w = z * z
    even = C[0] + w * (C[2] + w * (C[4] + w * (C[6] + w * (C[8] + w * C[10]))))
    odd = C[1] + w * (C[3] + w * (C[5] + w * (C[7] + w * C[9])))
    return even - z * odd


def short_basis(k, s):
    if k == 0.0:
        return 1.0, s, 0.5 * s * s
    psi = s * s * phi2(k * s)
    phi = s - k * psi
    return 1.0 - k * phi, phi, psi


def basis(k, s):
    h, doublings = s, 0
    while k * h > 0.25:
        h, doublings = h * 0.5, doublings + 1
    decay, phi, psi = short_basis(k, h)
    for _ in range(doublings):
        psi = psi + phi * h + decay * psi
        phi = phi + decay * phi
        decay, h = decay * decay, h + h
    return decay, phi, psi


BOUNCED, ROLLED_OFF, LIFTED = 1, 2, 3  # how the surface was left; None: a flight begins on none
BINS, NOWHERE = -1, -2


def length_bound(x, y):
    x, y = abs(x), abs(y)
    return max(x, y) + 0.41421356237309515 * min(x, y)


def next_impact(board, x0, y0, vx0, vy0, left, left_side, how, also, time_left):
    k = board.drag
    ax0, ay0 = -k * vx0, board.gravity - k * vy0
    x, y, vx, vy, ax, ay = x0, y0, vx0, vy0, ax0, ay0
    rise = board.travel / board.fall + 0.5 * board.fall * length_bound(ax0, ay0)
    straight = NEGLIGIBLE * board.radius * k * k
    start = 0.0
    while True:
        speed = length_bound(vx, vy)
        horizon = 2.0 * board.travel / (speed + length_bound(speed, rise))
        if k * horizon > 0.25:
            horizon = 0.25 / k
        best, item, side = horizon, NOWHERE, 0.0
        touched = {}
        if how is not None:
            touched[left] = how, left_side
            if also is not None:
                at_rest = vx * vx + vy * vy == 0.0
                touched[also] = LIFTED if at_rest else BOUNCED, side_of(board, also, x, y)
        order = [*touched, *(n for n in range(len(board.surfaces)) if n not in touched)]
        for number in order:
            surface = board.surfaces[number]
            if surface.owner != number and number not in touched:
                continue
            q = x, y, vx, vy, ax, ay, k
            if number in touched:
                s, s_side = hit_again(surface, q, horizon, *touched[number])
            else:
                s, s_side = hit(board, surface, q, horizon, None if how is None else left)
            earlier = s < best or item == NOWHERE
            if s != NO_HIT and (earlier or (s == best and number < item and number not in touched)):
                best, item, side = s, number, s_side
        if y + board.travel >= board.bins_y:
            s = line_hit(board.bins_y - y, -vy, -ay, k, horizon)
            if s != NO_HIT and (s < best or (item == NOWHERE and s <= best)):
                best, item = s, BINS
        if item != NOWHERE:
            return start + best, item, side
        start = start + horizon
        if start > time_left:
            return start, NOWHERE, 0.0
        how, k = None, board.drag
        decay, phi, psi = basis(k, start)
        x, y = x0 + vx0 * start + ax0 * psi, y0 + vy0 * start + ay0 * psi
        vx, vy = vx0 + ax0 * phi, vy0 + ay0 * phi
        ax, ay = ax0 * decay, ay0 * decay
        if k > 0.0 and length_bound(ax, ay) <= straight:
            vx, vy, ax, ay, k = vx + ax / k, vy + ay / k, 0.0, 0.0, 0.0
            if vx != 0.0 or vy != 0.0:
                rise = 0.0


def hit(board, surface, q, horizon, left):
    if surface.is_line:
        return wall_hit(board, surface, left, q, horizon)
    return circle_hit(seen_from(surface, q), surface.d2, horizon), 0.0


def seen_from(circle, q):
    return q[0] - circle.x, q[1] - circle.y, *q[2:]


def hit_again(surface, q, horizon, how, side):
    if not surface.is_line:
        q = seen_from(surface, q)
        if how == BOUNCED:
            return circle_hit_again(q, horizon), side
        if how == LIFTED:
            return circle_hit_after_lifting(q, surface.d2, horizon), side
        return circle_hit_after_rolling(q, surface.d2, horizon), side
    if how == LIFTED:
        return NO_HIT, side
    _, _, vx, vy, ax, ay, k = q
    hd = side * (surface.nx * vx + surface.ny * vy)
    hdd = side * (surface.nx * ax + surface.ny * ay)
    s = line_hit_again(hd, hdd, k, horizon)
    return (s if s != NO_HIT and foot_inside(surface, q, s) else NO_HIT), side


def side_of(board, number, x, y):
    line = board.surfaces[number]
    if not line.is_line:
        return 0.0
    d = (x - line.x) * line.nx + (y - line.y) * line.ny
    return 1.0 if d > 0.0 else -1.0


class FalsePath(Exception):
    pass


def is_near(board, number, side, x, y):
    surface = board.surfaces[number]
    dx, dy = x - surface.x, y - surface.y
    if surface.is_line:
        gap = side * (dx * surface.nx + dy * surface.ny) - board.radius
    else:
        d = surface.distance
        gap = 0.5 * (dx * dx + dy * dy - d * d) * surface.inverse
    return abs(gap) <= TRUE_WITHIN * board.radius


def rebound(board, number, side, x, y, vx, vy, omega):
    surface = board.surfaces[number]
    restitution, friction = board.pair_of(number)
    is_true, spin = is_near(board, number, side, x, y), 0.5 * board.radius * board.radius
    energy = vx * vx + vy * vy + spin * omega * omega
    dx, dy = x - surface.x, y - surface.y
    if surface.is_line:
        nx, ny = side * surface.nx, side * surface.ny
        gap = board.radius - (dx * nx + dy * ny)
        x, y = x + gap * nx, y + gap * ny
    else:
        nx, ny = dx * surface.inverse, dy * surface.inverse
        unit = 1.5 - 0.5 * (nx * nx + ny * ny)
        nx, ny = nx * unit, ny * unit
        x, y = surface.x + surface.distance * nx, surface.y + surface.distance * ny
    sticks = False
    if vx * nx + vy * ny < 0.0:
        jn = -(1.0 + restitution) * (vx * nx + vy * ny)
        vx, vy = vx + jn * nx, vy + jn * ny
        if friction > 0.0:
            jt = (vy * nx - vx * ny - omega * board.radius) * (-1.0 / 3.0)
            limit = friction * jn
            sticks = -limit <= jt <= limit
            jt = min(max(jt, -limit), limit)
            vx, vy = vx - jt * ny, vy + jt * nx
            omega = omega - 2.0 * jt / board.radius
    is_true &= vx * vx + vy * vy + spin * omega * omega <= energy * (1.0 + TRUE_WITHIN)
    return x, y, vx, vy, omega, nx, ny, sticks, is_true


def is_pressed_on(board, number, u, ny):
    return -board.gravity * ny - board.surfaces[number].curvature * u * u > 0.0


DEAD = 1e-8
FLIES, LIFTS, STAYS, LIES, BOUNCES_ON = range(5)  # what a ball does next that touches two surfaces
AT_BINS, ON_ONE, MET = -1, -2, -3  # what a flight ends with, besides an outcome


class Ball:
    t = vx = vy = theta = omega = 0.0

    def event(self, kind, index):
        return (self.t, self.x, self.y, self.vx, self.vy, self.omega), kind, index


def drop(board, x, y):
    ball, events = Ball(), []
    ball.x, ball.y = x, y
    try:
        outcome = follow(board, ball, events)
    except FalsePath:
        outcome = FALSE_PATH
    return ball, events, outcome


def follow(board, ball, events):
    number, side, how, also, lies, roots = None, 0.0, None, None, False, 0
    while True:
        if lies:
            cause, number, side, other, other_side, also = contact(
                board, ball, number, side, roots, also, events
            )
            lies = False
            if cause == LAND:
                return landed(board, ball, events)
            if cause in (REST, LATE, MANY):
                return {REST: BALANCED, LATE: TIME_LIMIT, MANY: EVENT_LIMIT}[cause]
            if cause != HIT:
                how = ROLLED_OFF if cause == LEFT else LIFTED
                events.append(ball.event(ENDS, board.index(number, ball.x, ball.y)))
                continue
        else:
            end, number, side, other, other_side, how, sticks = flight(
                board, ball, number, side, how, also, events
            )
            if end == AT_BINS:
                return landed(board, ball, events)
            if end == ON_ONE:
                events.append(ball.event(BEGINS, board.index(number, ball.x, ball.y)))
                lies, also, roots = True, None, 1 if sticks else 0
                continue
            if end != MET:
                return end
        noted = len(events)
        met, (number, side), also, roots = meet(
            board, ball, (number, side), (other, other_side), events
        )
        if met in (LIES, BOUNCES_ON):
            return WEDGED if met == LIES else IMPULSE_LIMIT
        if met == LIFTS and len(events) == noted:  # an impact ends a contact by itself
            events.append(ball.event(ENDS, board.index(number, ball.x, ball.y)))
        lies, how = met == STAYS, BOUNCED if met == FLIES else LIFTED


def flight(board, ball, number, side, how, also, events):
    if how is not None and not is_near(board, number, side, ball.x, ball.y):
        raise FalsePath
    while True:
        if len(events) >= MAX_EVENTS:
            return EVENT_LIMIT, number, side, None, 0.0, how, False
        left = MAX_TIME - ball.t
        s, hit_number, hit_side = next_impact(
            board, ball.x, ball.y, ball.vx, ball.vy, number, side, how, also, left
        )
        if hit_number == NOWHERE:
            return TIME_LIMIT, number, side, None, 0.0, how, False
        ax, ay = -board.drag * ball.vx, board.gravity - board.drag * ball.vy
        _, phi, psi = basis(board.drag, s)
        t, x, y = ball.t, ball.x, ball.y
        ball.t += s
        ball.x, ball.y = x + ball.vx * s + ax * psi, y + ball.vy * s + ay * psi
        ball.vx, ball.vy = ball.vx + ax * phi, ball.vy + ay * phi
        ball.theta = ball.theta + ball.omega * s
        if hit_number == BINS:
            return AT_BINS, number, side, None, 0.0, how, False
        moved = abs(ball.x - x) + abs(ball.y - y)
        stood = ball.t == t or moved <= rounding(ball.x, ball.y)
        if stood and how is not None and hit_number != number:
            return MET, number, side, hit_number, hit_side, how, False
        number, side, how, also = hit_number, hit_side, BOUNCED, None
        nx, ny, sticks = strike(board, ball, number, side, events)
        if ball.vx * nx + ball.vy * ny <= DEAD:
            u = ball.vy * nx - ball.vx * ny
            ball.vx, ball.vy = -u * ny, u * nx
            if is_pressed_on(board, number, u, ny):
                return ON_ONE, number, side, None, 0.0, how, sticks
            how = LIFTED


def landed(board, ball, events):
    low, high = 0, len(board.edges) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if ball.x >= board.edges[middle]:
            low = middle
        else:
            high = middle
    events.append(ball.event(LANDING, low))
    return LANDED


def digest(board_digest, x, y, events, outcome):
    start = pack("<5d", x, y, 0.0, 0.0, 0.0)
    rows = b"".join(pack("<6d2i", *state, kind, index) for state, kind, index in events)
    head = b"plinko drop" + bytes.fromhex(board_digest) + pack("<IB", PHYSICS_VERSION, 0)
    return hashlib.sha256(head + start + pack("<BQ", outcome, len(events)) + rows).hexdigest()


def block_hash(board_digest, rows):
    head = b"plinko drops" + bytes.fromhex(board_digest) + pack("<IB", PHYSICS_VERSION, 0)
    return hashlib.sha256(b"\0" + head + b"".join(pack("<idid", *row) for row in rows)).digest()


def batch_digest(hashes):
    if len(hashes) == 1:
        return hashes[0]
    left = 1 << (len(hashes) - 1).bit_length() - 1
    return hashlib.sha256(
        b"\1" + batch_digest(hashes[:left]) + batch_digest(hashes[left:])
    ).digest()


def main(board_file, record_file):
    for part in ("surfaces", "impacts", "contacts"):
        exec(
            (Path(__file__).parent / f"reproduce_{part}.py").read_text(encoding="utf-8"), globals()
        )
    form, record = (json.loads(Path(file).read_text()) for file in (board_file, record_file))
    x, y = record.get("x"), form["drop"]["y"]
    if x is None:
        x = start_x(int(record["seed"]), form["drop"], record.get("aim"))
    _, events, outcome = drop(Board(form), x, y)
    print("computed", digest(record["board_digest"], x, y, events, outcome))
    print("recorded", record["digest"])


if __name__ == "__main__":
    main(*sys.argv[1:])
