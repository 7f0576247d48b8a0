"""Rolling, sliding and notches: a part of the solver in reproduce.md, whose names it uses.

reproduce_drop.py calls `contact` and `meet`; all of them share one namespace.
"""

# A ball on a surface moves by power series of degree 20 in time. Each stretch begins with new series
# at the ball's position, after a true square root has moved the centre onto the surface. The series:
# normal, speed along the tangent, spin, angle, path, normal force. A stretch ends at the first zero of
# a polynomial; of several at one instant, the first one in the order below counts.

ROLLING, SLIDING, FREE = range(3)
ORDER = 20


def touch(board, number, side, x, y):
    surface = board.surfaces[number]
    dx, dy = x - surface.x, y - surface.y
    if surface.is_line:
        nx, ny = side * surface.nx, side * surface.ny
        gap = board.radius - (dx * nx + dy * ny)
        return nx, ny, x + gap * nx, y + gap * ny
    length = sqrt(dx * dx + dy * dy)
    nx, ny = dx / length, dy / length
    return nx, ny, surface.x + surface.distance * nx, surface.y + surface.distance * ny


class Series:
    def __init__(self, board, number, mode, slip_sign, nx, ny, u, spin, angle):
        g, k, R = board.gravity, board.drag, board.radius
        bend, friction = board.surfaces[number].curvature, board.pair_of(number)[1]
        self.nx, self.ny, self.u, self.spin = [nx], [ny], [u], [spin]
        self.angle, self.path, self.force = [angle], [0.0], []
        if mode == ROLLING:
            self.spin = [u / R]
        nx, ny, u = self.nx, self.ny, self.u
        for i in range(ORDER + 1):
            turn_x = turn_y = square = 0.0
            if bend > 0.0:
                for j in range(i + 1):
                    turn_x += u[j] * ny[i - j]
                    turn_y += u[j] * nx[i - j]
                    square += u[j] * u[i - j]
            self.force.append(-g * ny[i] - bend * square)
            if i == ORDER:
                break
            share = 1.0 / (i + 1.0)
            nx.append(-bend * turn_x * share)
            ny.append(bend * turn_y * share)
            drive = g * nx[i] - k * u[i]
            if mode == ROLLING:
                u.append(drive * share * (2.0 / 3.0))
                self.spin.append(u[i + 1] / R)
            elif mode == SLIDING:
                pull = friction * slip_sign * self.force[i]
                u.append((drive - pull) * share)
                self.spin.append(2.0 * pull / R * share)
            else:
                u.append(drive * share)
                self.spin.append(0.0)
            self.angle.append(self.spin[i] * share)
            self.path.append(u[i] * share)


def value(c, s):
    total = c[-1]
    for term in c[-2::-1]:
        total = total * s + term
    return total


def magnitudes(c, first, s):
    total = 0.0
    for term in c[: first - 1 if first else None : -1]:
        total = total * s + abs(term)
    return total


def step_length(board, f):
    last = before = 0.0
    for row, scale in ((f.nx, 1.0), (f.ny, 1.0), (f.u, 1.0), (f.spin, board.radius)):
        last, before = max(last, scale * abs(row[20])), max(before, scale * abs(row[19]))
    h = 0.25
    while True:
        power = 1.0
        for _ in range(ORDER - 1):
            power *= h
        near = h * magnitudes(f.u, 0, h) <= board.travel
        if power * (before + last * h) <= 6.9e-18 and near:
            return h
        h *= 0.5


def first_zero(c, skip, horizon):  # of c / s^skip
    if not c[skip] > 0.0:
        return 0.0
    if c[skip] > horizon * magnitudes(c, skip + 1, horizon):
        return NO_HIT
    third = 0.0
    for i in range(ORDER, skip + 2, -1):
        j = i - skip
        third = third * horizon + j * (j - 1) * (j - 2) * abs(c[i])
    s, h = 0.0, horizon
    for _ in range(MOST_STEPS):
        f = fd = half = 0.0
        for i in range(ORDER, skip - 1, -1):
            half = half * s + fd
            fd = fd * s + f
            f = f * s + c[i]
        if f <= 0.0:
            return s
        step = minorant_root(f, fd, 2.0 * half - third * h)
        if step == NO_HIT or step > h:
            if s + h >= horizon:
                return NO_HIT
            step, h = h, h + h
        else:
            h = step
        before, s = s, s + step
        if s == before:
            return s
        if h > horizon - s:
            h = horizon - s
            if h <= 0.0:
                return NO_HIT
    return s


def first_touch(f, horizon):
    if f[0] > 0.0:
        return first_zero(f, 0, horizon)
    if f[1] < 0.0 or (f[1] == 0.0 and f[2] < 0.0):
        return 0.0
    return next_touch(f, horizon)


def next_touch(f, horizon):  # of a surface that the ball touches and leaves
    roots = 1 if f[1] != 0.0 else 2
    return first_zero(f, roots, horizon) if f[roots] > 0.0 else NO_HIT


def position(board, f, number, x, y, s):
    surface = board.surfaces[number]
    if surface.is_line:
        path = value(f.path, s)
        return x - f.ny[0] * path, y + f.nx[0] * path
    return (
        surface.x + surface.distance * value(f.nx, s),
        surface.y + surface.distance * value(f.ny, s),
    )


# What can end a stretch: another surface (not one as which the ball's own continues); the place where
# a ball that is behind a line comes out, because only from there on can it be seen to touch that line;
# the landing; a normal force of zero; the end of the line, or a line that is flush with the circle; the
# end of slipping; rolling that needs more friction than there is. `is_in_reach` keeps the lines that
# the ball may touch in this stretch.


def affine(start, rate, row):
    return [start, *(rate * term for term in row[1:])]


def touch_time(board, f, number, x, y, other, moves_off, horizon):
    search = next_touch if moves_off else first_touch
    here, there = board.surfaces[number], board.surfaces[other]
    dx, dy = x - there.x, y - there.y
    tx, ty = -f.ny[0], f.nx[0]
    if not there.is_line:
        if here.is_line:
            along, p = 2.0 * (dx * tx + dy * ty), f.path
            c = [along * p[i] + products(p, i) for i in range(1, ORDER + 1)]
        else:
            px, py, twice = here.x - there.x, here.y - there.y, 2.0 * here.distance
            c = [twice * (px * a + py * b) for a, b in zip(f.nx[1:], f.ny[1:])]
        return search([dx * dx + dy * dy - there.d2, *c], horizon), 0.0
    d = there.nx * dx + there.ny * dy
    side = 1.0 if d > 0.0 else -1.0
    if here.is_line:
        c = affine(0.0, side * (there.nx * tx + there.ny * ty), f.path)[1:]
    else:
        reach = side * here.distance
        c = [reach * (there.nx * a + there.ny * b) for a, b in zip(f.nx[1:], f.ny[1:])]
    c = [side * d - board.radius, *c]
    if not moves_off and c[0] < -rounding(x, y):  # behind the line: when does the ball come out?
        return first_zero([-term for term in c], 0, horizon), 0.0
    s = search(c, horizon)
    if s != NO_HIT:
        px, py = position(board, f, number, x, y, s)
        foot, near = (px - there.x) * there.tx + (py - there.y) * there.ty, rounding(px, py)
        if not -near <= foot <= there.length + near:
            s = NO_HIT
    return s, side


def products(p, i):
    total = 0.0
    for j in range(1, i):
        total += p[j] * p[i - j]
    return total


def others_touched(board, f, number, side, x, y, also, horizon):
    best, found, found_side = horizon, None, 0.0
    end_x, end_y = position(board, f, number, x, y, horizon)
    middle = 0.5 * (x + end_x), 0.5 * (y + end_y)
    for other, surface in enumerate(board.surfaces):
        if other == number or surface.owner != other:
            continue
        if continues(board, number, side, other, x, y):
            continue
        s, other_side = touch_time(board, f, number, x, y, other, other == also, best)
        if surface.is_line and other_side == 0.0:
            if s != NO_HIT and s < best and is_in_reach(board, surface, *middle):
                best, found = s, None  # the stretch ends where the ball comes out
        elif s != NO_HIT and (s < best or found is None):
            best, found, found_side = s, other, other_side
    return best, found, found_side


def is_in_reach(board, line, x, y):
    dx, dy, reach = x - line.x, y - line.y, board.radius + 0.503 * board.travel
    along = min(max(dx * line.tx + dy * line.ty, 0.0), line.length)
    dx, dy = dx - along * line.tx, dy - along * line.ty
    return dx * dx + dy * dy <= reach * reach


def ends_in(line, number):
    return line.is_line and number in line.ends


def continues(board, number, side, other, x, y):  # from one surface to the other without an angle
    here, there = board.surfaces[number], board.surfaces[other]
    if not here.is_line:
        flush_side = side_of(board, other, x, y)
        return ends_in(there, number) and is_flush(board.radius, there, flush_side, here)
    return not there.is_line and is_flush(board.radius, here, side, there)


def surface_change(board, f, number, x, y, horizon):
    here, best, onto = board.surfaces[number], NO_HIT, None
    if here.is_line:
        foot = (x - here.x) * here.tx + (y - here.y) * here.ty
        along = -f.ny[0] * here.tx + f.nx[0] * here.ty
        rest = (1.0, foot, here.ends[0]), (-1.0, here.length - foot, here.ends[1])
        for sign, gap, end in rest:
            s = first_touch(affine(gap, sign * along, f.path), horizon)
            if s != NO_HIT and (best == NO_HIT or s < best):
                best, onto = s, end
        return best, onto
    for line in board.surfaces:
        if line.owner != line.number or not ends_in(line, number):
            continue
        out = -1.0 if line.ends[0] == number else 1.0
        s = first_touch([out * (line.tx * a + line.ty * b) for a, b in zip(f.nx, f.ny)], horizon)
        if s == NO_HIT or (best != NO_HIT and s >= best):
            continue
        up = value(f.nx, s) * line.nx + value(f.ny, s) * line.ny
        if is_flush(board.radius, line, 1.0 if up > 0.0 else -1.0, here):
            best, onto = s, line.number
    return best, onto


def rolling_end(board, f, friction, horizon):
    best, sign = NO_HIT, 0.0
    for way in (1.0, -1.0):
        c = [
            3.0 * friction * n - way * (board.gravity * a - board.drag * u)
            for n, a, u in zip(f.force, f.nx, f.u)
        ]
        s = first_touch(c, horizon)
        if s != NO_HIT and (best == NO_HIT or s < best):
            best, sign = s, way
    return best, sign


# A contact phase goes from stretch to stretch. `roots` is the number of roots that the slip already has
# at the beginning: 1 after friction has stopped it or after rolling, 2 when a rolling ball has just
# begun to slip in the direction `slip_sign`. `also` is a second surface that the ball touches when
# the phase begins, and leaves.

LEFT, HIT, LAND, REST, LATE, MANY, STEP, MODE, OVER = range(9)


def contact(board, ball, number, side, roots, also, events):
    g, k, R, slip_sign, fresh = board.gravity, board.drag, board.radius, 0.0, False
    while True:
        if len(events) >= MAX_EVENTS and not fresh:
            return MANY, number, side, None, 0.0, also
        if not ball.t <= MAX_TIME:
            return LATE, number, side, None, 0.0, also
        if not is_near(board, number, side, ball.x, ball.y):
            raise FalsePath
        surface, friction = board.surfaces[number], board.pair_of(number)[1]
        nx, ny, ball.x, ball.y = touch(board, number, side, ball.x, ball.y)
        u = ball.vy * nx - ball.vx * ny
        force = -g * ny - surface.curvature * u * u
        if force <= 0.0:
            return STEP, number, side, None, 0.0, also  # there was no force from the start
        mode = SLIDING
        if roots != 2:
            mode, slip_sign = mode_of(board, u, ball.omega, force, nx, friction, roots == 1)
        if nx == 0.0 and mode != SLIDING and has_stopped(board, u):
            return REST, number, side, None, 0.0, also
        nx, ny, _, _ = touch(board, number, side, ball.x, ball.y)  # again, at its new position
        u = ball.vy * nx - ball.vx * ny
        f = Series(board, number, mode, slip_sign, nx, ny, u, ball.omega, ball.theta)
        s, hit_number, sign = others_touched(
            board, f, number, side, ball.x, ball.y, also, step_length(board, f)
        )
        cause, other = (STEP, None) if hit_number is None else (HIT, hit_number)
        row, rate = (f.path, -surface.ty) if surface.is_line else (f.ny, -surface.distance)
        for ask in (
            lambda s: (first_zero(affine(board.bins_y - ball.y, rate, row), 0, s), LAND, None, 0.0),
            lambda s: (first_zero(f.force, 0, s), LEFT, None, 0.0),
            lambda s: changed(board, f, number, ball, s),
            lambda s: slipped(board, f, mode, slip_sign, roots, friction, s),
        ):
            when, why, onto, new_sign = ask(s)
            if why == MODE and fresh and when == 0.0:
                when = NO_HIT  # the mode has just changed at this instant
            if when != NO_HIT and (when < s or cause == STEP):
                s, cause, other, sign = when, why, onto, new_sign
        x, y = position(board, f, number, ball.x, ball.y, s)
        u = value(f.u, s)
        ball.t, ball.x, ball.y = ball.t + s, x, y
        ball.vx, ball.vy = -u * value(f.ny, s), u * value(f.nx, s)
        ball.theta, ball.omega = value(f.angle, s), value(f.spin, s)
        roots = 1 if mode == ROLLING else 0
        if s > 0.0:
            also = None
        fresh = cause == MODE and s == 0.0
        if cause == MODE:
            events.append(ball.event(CHANGES, board.index(number, ball.x, ball.y)))
            slip_sign, roots = sign, 2 if mode == ROLLING else 1
        elif cause == OVER:
            events.append(ball.event(CHANGES, board.index(other, ball.x, ball.y)))
            number, side = other, side_of(board, other, ball.x, ball.y)
        elif cause != STEP:
            return cause, number, side, other, sign, also


def changed(board, f, number, ball, horizon):
    s, onto = surface_change(board, f, number, ball.x, ball.y, horizon)
    return s, OVER, onto, 0.0


def slipped(board, f, mode, slip_sign, roots, friction, horizon):
    if mode == SLIDING:
        c = [slip_sign * (u - board.radius * spin) for u, spin in zip(f.u, f.spin)]
        return first_zero(c, roots, horizon), MODE, None, 0.0
    if mode == ROLLING:
        s, sign = rolling_end(board, f, friction, horizon)
        return s, MODE, None, sign
    return NO_HIT, MODE, None, 0.0


def mode_of(board, u, omega, force, nx, friction, rolls):
    if friction == 0.0:
        return FREE, 0.0
    slip = 0.0 if rolls else u - omega * board.radius
    drive = board.gravity * nx - board.drag * u
    if slip != 0.0:
        return SLIDING, 1.0 if slip > 0.0 else -1.0
    if abs(drive) <= 3.0 * friction * force:
        return ROLLING, 0.0
    return SLIDING, 1.0 if drive > 0.0 else -1.0


def has_stopped(board, u):
    if u == 0.0 or board.drag == 0.0:
        return u == 0.0
    return board.radius + 1.5 * abs(u) / board.drag == board.radius


# A ball meets a second surface if it hits it while it is on a first one, or if a flight from the first
# to the second takes no time or leads no farther than rounding. The ball strikes each of the two that
# it approaches faster than 1e-8 m/s, the lower number first, until it approaches neither. After a
# thousand impulses the drop ends without a result. A ball that is too slow to rise by more than rounding has
# stopped, too. Otherwise it leaves each surface from which it moves away faster than 1e-8 m/s. If it
# leaves neither, the two are nearly parallel: it slides from one onto the other, or is jammed.


def meet(board, ball, a, b, events):  # a, b: number and side
    last, sticks, impulses = b, False, 0
    while True:
        off_a, off_b = speed_off(board, ball, a), speed_off(board, ball, b)
        if off_a >= -DEAD and off_b >= -DEAD:
            break
        if impulses == 1000:
            return BOUNCES_ON, b, a[0], 0
        impulses += 1
        last = a if off_a < -DEAD and (a < b or off_b >= -DEAD) else b
        _, _, sticks = strike(board, ball, *last, events, meets=True)
    height = rounding(ball.x, ball.y)
    slow = max((8.0 * DEAD) * (8.0 * DEAD), 2.0 * board.gravity * height)
    if ball.vx * ball.vx + ball.vy * ball.vy <= slow:
        ball.vx = ball.vy = 0.0
        return rest(board, ball, a, b, events)
    if off_a > DEAD and off_b > DEAD:
        return FLIES, last, (b if last is a else a)[0], 0
    if off_a <= DEAD and off_b <= DEAD:
        for first, other in (a, b), (b, a):
            if slides_off(board, ball, first, other):
                return stay(board, ball, first, other, 0, events)
        ball.vx = ball.vy = 0.0
        return rest(board, ball, a, b, events)
    first, other = (a, b) if off_a <= DEAD else (b, a)
    return stay(board, ball, first, other, 1 if sticks and last is first else 0, events)


def normal(board, ball, surface):
    return touch(board, *surface, ball.x, ball.y)[:2]


def speed_off(board, ball, surface):
    nx, ny = normal(board, ball, surface)
    return ball.vx * nx + ball.vy * ny


def slides_off(board, ball, surface, other):  # moving along the one, not into the other
    (nx, ny), (ox, oy) = normal(board, ball, surface), normal(board, ball, other)
    return (ball.vy * nx - ball.vx * ny) * (oy * nx - ox * ny) >= 0.0


def strike(board, ball, number, side, events, meets=False):
    ball.x, ball.y, ball.vx, ball.vy, ball.omega, nx, ny, sticks, is_true = rebound(
        board, number, side, ball.x, ball.y, ball.vx, ball.vy, ball.omega
    )
    if is_true or meets:
        is_peg = number < board.pegs
        index = number if is_peg else board.wall_at(number, ball.x, ball.y)
        events.append(ball.event(PEG if is_peg else WALL, index))
    if not is_true:
        raise FalsePath
    return nx, ny, sticks


def stay(board, ball, surface, other, roots, events):
    nx, ny = normal(board, ball, surface)
    u = ball.vy * nx - ball.vx * ny
    ball.vx, ball.vy = -u * ny, u * nx
    if not is_pressed_on(board, surface[0], u, ny):
        return LIFTS, surface, other[0], 0
    events.append(ball.event(BEGINS, board.index(surface[0], ball.x, ball.y)))
    return STAYS, surface, other[0], roots


# A ball at rest in a notch spins until friction has stopped it, if both surfaces push; or one contact
# opens, and the ball continues along the other surface; or it lies still.

FALLS, ON_A, ON_B, SPINS, RESTS, JAMS = range(6)


def opens(g, pull, nx, ny, ox, oy):
    force = -g * ny
    return force > 0.0 and (g * nx + pull * force) * (oy * nx - ox * ny) >= 0.0


def in_notch(g, omega, ax, ay, mu_a, bx, by, mu_b):
    if g * ay >= 0.0 and g * by >= 0.0:
        return FALLS, 0.0
    if omega == 0.0 or mu_a == mu_b == 0.0:
        if opens(g, 0.0, ax, ay, bx, by):
            return ON_A, 0.0
        return (ON_B if opens(g, 0.0, bx, by, ax, ay) else RESTS), 0.0
    s = 1.0 if omega > 0.0 else -1.0
    rax, ray = ax - s * mu_a * ay, ay + s * mu_a * ax
    rbx, rby = bx - s * mu_b * by, by + s * mu_b * bx
    cross = rax * rby - ray * rbx
    force_a, force_b = (g * rbx / cross, -g * rax / cross) if cross != 0.0 else (0.0, 0.0)
    if force_a > 0.0 and force_b > 0.0:
        return SPINS, mu_a * force_a + mu_b * force_b
    on_a, on_b = opens(g, s * mu_a, ax, ay, bx, by), opens(g, s * mu_b, bx, by, ax, ay)
    if on_a and (force_b <= 0.0 or not on_b):
        return ON_A, 0.0
    return (ON_B if on_b else JAMS), 0.0


def rest(board, ball, a, b, events):
    g, mu_a, mu_b = board.gravity, board.pair_of(a[0])[1], board.pair_of(b[0])[1]
    (ax, ay), (bx, by) = normal(board, ball, a), normal(board, ball, b)
    what, brake = in_notch(g, ball.omega, ax, ay, mu_a, bx, by, mu_b)
    spun = what == SPINS
    if spun:
        events.append(ball.event(BEGINS, board.index(a[0], ball.x, ball.y)))
        events.append(ball.event(BEGINS, board.index(b[0], ball.x, ball.y)))
        rate = (-2.0 if ball.omega > 0.0 else 2.0) * brake / board.radius
        s = -ball.omega / rate
        ball.t, ball.theta = ball.t + s, ball.theta + 0.5 * ball.omega * s
    if spun or what == JAMS:
        ball.omega = 0.0
        what, _ = in_notch(g, 0.0, ax, ay, mu_a, bx, by, mu_b)
    if what == RESTS:
        return LIES, b, None, 0
    if what == FALLS:
        return LIFTS, b, a[0], 0
    stays, opened = (a, b) if what == ON_A else (b, a)
    kind, which = (ENDS, opened) if spun else (BEGINS, stays)
    events.append(ball.event(kind, board.index(which[0], ball.x, ball.y)))
    return STAYS, stays, opened[0], 0
