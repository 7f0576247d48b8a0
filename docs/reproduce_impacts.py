"""When a ball hits a circle or a line: the searches of the solver in reproduce.md.

reproduce_drop.py defines the other names that this file uses, and calls `circle_hit`, `circle_hit_again`,
`circle_hit_after_lifting`, `circle_hit_after_rolling`, `line_hit`, `line_hit_again`, `wall_hit` and
`foot_inside`. All of them share one namespace.
"""

LEAST_X = -4.0  # below, Halley's step is less than two thirds of the way to the parabola's root


def minorant_root(f, fd, m):
    square = fd * fd - 2.0 * m * f
    if square < 0.0:
        return NO_HIT
    if fd > 0.0:
        return (fd + sqrt(square)) / -m if m < 0.0 else NO_HIT
    divisor = sqrt(square) - fd
    return 2.0 * f / divisor if divisor > 0.0 else NO_HIT


def halley_step(f, fd, m):
    if fd >= 0.0:
        return minorant_root(f, fd, m)
    square, fm = fd * fd, f * m
    if square < fm + fm:
        return NO_HIT
    return 2.0 * f * fd / (fm - (square + square))


def stays_positive(f, b, c, h):  # f + 2 b d + c d^2 on all of [0, h]
    e = b + c * h
    if c > 0.0 and e > 0.0:
        return f > 0.0 and (b >= 0.0 or b * b < c * f)
    return f > 0.0 and f + h * (b + e) > 0.0


def third_below(va, aa, qa, k, h):  # f''' is at least this on [0, h]
    bound = 6.0 * va if va < 0.0 else 0.0
    if k > 0.0:
        rise = qa + 0.5 * aa * h * h
        if va > 0.0:
            rise += va * h
        if rise > 0.0:
            bound -= 2.0 * k * rise
    return bound


def third_size(va, aa, qa, k, h):  # and |f'''| at most this
    size = 6.0 * (abs(va) + aa * h)
    if k > 0.0:
        size += 2.0 * k * (abs(qa) + (abs(va) + 0.5 * aa * h) * h)
    return size


def flown(q, s):  # place, velocity, and v.q and q.a of a motion after s
    qx, qy, vx, vy, ax, ay, k = q
    decay, phi, psi = short_basis(k, s)
    px, py = qx + vx * s + ax * psi, qy + vy * s + ay * psi
    ux, uy = vx + ax * phi, vy + ay * phi
    fd = 2.0 * (px * ux + py * uy)
    return px * px + py * py, fd, 2.0 * (ux * ux + uy * uy + decay * (px * ax + py * ay))


def first_root(q, scale, is_divided, horizon, s, f, fd, fdd, low3):  # of f, or of g = f / s
    qx, qy, vx, vy, ax, ay, k = q
    size3 = third_size(vx * ax + vy * ay, ax * ax + ay * ay, qx * ax + qy * ay, k, horizon)
    g0, enough, h = f, NEGLIGIBLE * scale, horizon - s
    for _ in range(MOST_STEPS):
        m = fdd + low3 * h * (1.0 / 3.0)
        step = halley_step(f, fd, m)
        if fd < 0.0 and (s + step == s or (is_divided and f * m < LEAST_X * (fd * fd))):
            step = minorant_root(f, fd, m)
        before = s
        if step == NO_HIT or step > h:
            if s + h >= horizon:
                return NO_HIT
            step, h = h, h + h
        elif comes_near(f, fd, m, step, h, low3, size3, enough, is_divided):
            s = s + step
            return s if s <= horizon else NO_HIT
        elif not is_divided:
            h = step
        s = s + step
        if s > horizon:
            return NO_HIT
        if s == before:
            return s
        if is_divided:
            f, fd = divided(q, g0, s)
        else:
            square, fd, fdd = flown(q, s)
            f = square - scale
        if f <= 0.0:
            return s
        if is_divided or h > horizon - s:
            h = horizon - s
            if h <= 0.0:
                return NO_HIT
    return s


def divided(q, g0, s):  # g and g' at s
    qx, qy, vx, vy, ax, ay, k = q
    qa, c = qx * ax + qy * ay, phi2(k * s) if k > 0.0 else 0.5
    c1 = s * c
    c1d = 1.0 - k * c1 - c
    wx, wy = vx + ax * c1, vy + ay * c1
    ww = wx * wx + wy * wy
    g = g0 + 2.0 * qa * c1 + s * ww
    return g, 2.0 * qa * c1d + ww + 2.0 * s * c1d * (wx * ax + wy * ay)


def comes_near(f, fd, m, step, h, low3, size3, enough, is_divided):
    if is_divided:
        return 2.0 * (size3 * (1.0 / 3.0)) * step * step <= enough
    square, fm = fd * fd, f * m
    if (size3 * step - low3 * h) * step * step > 3.0 * enough:
        return False
    return f * fm * fm <= enough * square * square


def circle_hit(q, d2, horizon):
    qx, qy, vx, vy, ax, ay, k = q
    f, b = qx * qx + qy * qy - d2, qx * vx + qy * vy
    va, aa, qa = vx * ax + vy * ay, ax * ax + ay * ay, qx * ax + qy * ay
    c = vx * vx + vy * vy + qa
    low3 = third_below(va, aa, qa, k, horizon)
    if stays_positive(f, b, c + low3 * horizon * (1.0 / 6.0), horizon):
        return NO_HIT
    if f > 0.0:
        return first_root(q, d2, False, horizon, 0.0, f, 2.0 * b, 2.0 * c, low3)
    return 0.0 if b < 0.0 else circle_hit_again(q, horizon)


def circle_hit_again(q, horizon):
    qx, qy, vx, vy, ax, ay, k = q
    return search_again(q, 2.0 * (qx * vx + qy * vy), horizon)


def circle_hit_after_lifting(q, d2, horizon):
    qx, qy, vx, vy, ax, ay, k = q
    if vx * vx + vy * vy + qx * ax + qy * ay > 0.0:
        return search_again(q, 0.0, horizon)
    return circle_hit_after_rolling(q, d2, horizon)


def search_again(q, g0, horizon):
    qx, qy, vx, vy, ax, ay, k = q
    va, aa, qa = vx * ax + vy * ay, ax * ax + ay * ay, qx * ax + qy * ay
    m = third_below(va, aa, qa, k, horizon) * (1.0 / 3.0)
    g, gd = max(g0, 0.0), vx * vx + vy * vy + qa
    if g == 0.0 and gd <= 0.0:
        return 0.0
    if g > 0.0 and stays_positive(g, 0.5 * gd, 0.5 * m, horizon):
        return NO_HIT
    return first_root(q, g, True, horizon, 0.0, g, gd, m, 0.0)


def circle_hit_after_rolling(q, d2, horizon):
    qx, qy, vx, vy, ax, ay, k = q
    va, vv, aa = vx * ax + vy * ay, vx * vx + vy * vy, ax * ax + ay * ay
    h0 = va + k * vv / 3.0
    if h0 <= 0.0 or k == 0.0:
        return NO_HIT
    a = sqrt(aa)
    speed = sqrt(vv) + a * horizon
    low4 = -8.0 * k * speed * a - 2.0 * k * k * a * (sqrt(d2) + speed * horizon)
    s = -24.0 * h0 / low4
    if s >= horizon:
        return NO_HIT
    square, fd, fdd = flown(q, s)
    if square - d2 <= 0.0:
        return s
    low3 = third_below(va, aa, qx * ax + qy * ay, k, horizon)
    return first_root(q, d2, False, horizon, s, square - d2, fd, fdd, low3)


def line_hit(h, hd, hdd, k, horizon):
    if h > 0.0:
        return line_search(h, hd, hdd, k, horizon)
    if hd < 0.0:
        return 0.0
    if hdd >= 0.0:
        return NO_HIT
    out = line_exit(h, hd, hdd, k, horizon)
    if out == NO_HIT:
        return line_hit_again(hd, hdd, k, horizon)
    decay, phi, _ = short_basis(k, out)
    again = line_hit_again(hd + hdd * phi, hdd * decay, k, horizon - out)
    return NO_HIT if again == NO_HIT else out + again


def line_search(h, hd, hdd, k, horizon):
    m = hdd * (1.0 - k * horizon) if hdd > 0.0 else hdd
    s, a, b = 0.0, h, hd
    for _ in range(MOST_STEPS):
        if stays_positive(a, 0.5 * b, 0.5 * m, horizon - s):
            return NO_HIT
        step = minorant_root(a, b, m)
        before, s = s, s + step
        if step == NO_HIT or s > horizon:
            return NO_HIT
        if s == before:
            return s
        _, phi, psi = short_basis(k, s)
        a = h + hd * s + hdd * psi
        if a <= 0.0:
            return s
        b = hd + hdd * phi
    return s


def line_exit(h, hd, hdd, k, horizon):
    s, a, b = 0.0, h, hd
    for _ in range(MOST_STEPS):
        if b <= 0.0:
            return NO_HIT
        before, s = s, s - a / b
        if s > horizon:
            return NO_HIT
        _, phi, psi = short_basis(k, s)
        a = h + hd * s + hdd * psi
        if a >= 0.0 or s == before:
            return s
        b = hd + hdd * phi
    return NO_HIT


def line_hit_again(hd, hdd, k, horizon):
    if hd <= 0.0:
        return 0.0 if hdd < 0.0 or hd < 0.0 else NO_HIT
    if hdd >= 0.0:
        return NO_HIT
    target = -hd / hdd
    s = 2.0 * target
    if k == 0.0:
        return s if s <= horizon else NO_HIT
    for _ in range(MOST_STEPS):
        if s > horizon or k * s > 0.25:
            return NO_HIT
        c = phi2(k * s)
        gap = target - s * c
        if gap <= 0.0:
            return s
        before, s = s, s + gap / (1.0 - k * s * c - c)
        if s == before:
            return s
    return s


def foot_inside(line, q, s):
    x, y, vx, vy, ax, ay, k = q
    _, _, psi = short_basis(k, s)
    x, y = x + vx * s + ax * psi, y + vy * s + ay * psi
    foot, near = (x - line.x) * line.tx + (y - line.y) * line.ty, rounding(x, y)
    return -near <= foot <= line.length + near


def onto_line(line, q, begin, h, hd, hdd, horizon):  # from the line's extension, touched at `begin`
    x, y, vx, vy, ax, ay, k = q
    foot = line.tx * (x - line.x) + line.ty * (y - line.y)
    along, pull = line.tx * vx + line.ty * vy, line.tx * ax + line.ty * ay
    if foot < 0.0:
        s = line_hit(-foot, -along, -pull, k, horizon)
    else:
        s = line_hit(foot - line.length, along, pull, k, horizon)
    if s == NO_HIT:
        return NO_HIT
    _, _, psi = short_basis(k, s)
    far = abs(h + hd * s + hdd * psi) > rounding(x, y)
    return NO_HIT if s < begin or far else s


def wall_hit(board, line, left, q, horizon):  # `left`: the surface just left, or None
    x, y, vx, vy, ax, ay, k = q
    dx, dy = x - line.x, y - line.y
    d, dv, da = (line.nx * u + line.ny * v for u, v in ((dx, dy), (vx, vy), (ax, ay)))
    found, found_side = NO_HIT, 0.0
    for side in (1.0, -1.0):
        h, hd, hdd = side * d - board.radius, side * dv, side * da
        if h > 0.0:
            if h + hd * horizon > 0.0 and hdd >= 0.0:
                continue
        elif side * d <= 0.0 and h + hd * horizon <= 0.0:
            continue
        s = line_hit(h, hd, hdd, k, horizon)
        if s == NO_HIT or (found != NO_HIT and s >= found):
            continue
        if not foot_inside(line, q, s):
            s = onto_line(line, q, s, h, hd, hdd, horizon)
        if s != NO_HIT and (found == NO_HIT or s < found):
            found, found_side = s, side
    if found != NO_HIT and left is not None and leaves_by(line, left, vx, vy):
        _, phi, _ = short_basis(k, found)
        if leaves_by(line, left, vx + ax * phi, vy + ay * phi):
            found = NO_HIT
    return found, found_side


def leaves_by(line, end, u, v):
    along = u * line.tx + v * line.ty
    return (end == line.ends[0] and along < 0.0) or (end == line.ends[1] and along > 0.0)
