"""A ball that drag brakes on a circle, whose enclosure shrinks with the motion.

The signs of the terms of a braked motion's series alternate, so a series multiplies the width of an
enclosure by e^(k s), although the motion divides the width by it. So the middle of the enclosure is
followed separately, and the distance from it by the derivative: the mean value form.
"""

from dataclasses import replace

from flint import arb, ctx

from plinko.engine.certified.balls import ONE, ZERO, Proof
from plinko.engine.certified.contact.derivative import Parting, carried
from plinko.engine.certified.contact.series import ROLLING, Contact, Stretch
from plinko.engine.certified.scene import Scene
from plinko.engine.certified.surfaces import Surface, unit_vector

STRONG = 0.5
"""1/s. Drag from which on the mean value form pays."""


def stretch_of(scene: Scene, surface: Surface, start: Contact, proof: Proof) -> Stretch:
    """The motion from `start` on."""
    law = scene.law_on(surface)
    plain = law.drag <= STRONG or law.curvature.is_zero() or start.u.is_exact()
    return (Stretch if plain else DampedStretch)(scene, surface, start, proof)


class DampedStretch(Stretch):
    """A stretch on a circle that also follows the middle of the starts, and the derivative."""

    def __init__(self, scene: Scene, surface: Surface, start: Contact, proof: Proof) -> None:
        mx, my = start.nx.mid(), start.ny.mid()
        length = (mx * mx + my * my).sqrt()
        mx, my = mx / length, my / length
        middle = replace(start, nx=mx, ny=my, u=start.u.mid(), omega=start.omega.mid())
        turn = (mx * start.ny - my * start.nx).asin()
        self._apart = turn / surface.curvature, start.u - middle.u, start.omega - middle.omega
        # All starts between the middle and any other: their normals lie on an arc, not a chord.
        bulge = arb(0, (turn * turn).abs_upper()) + arb(0, arb(2) ** -ctx.prec)
        nx, ny = start.nx.union(mx) + bulge, start.ny.union(my) + bulge
        self._middle = Stretch(scene, surface, middle, proof)
        super().__init__(scene, surface, replace(start, nx=nx, ny=ny), proof)
        ratio = self._middle.unit / self.unit * (1.0 - 1e-15)
        self.end = min(self.end, self._middle.end * ratio)

    def at(self, share: arb) -> Contact:
        hull = super().at(share)
        time = share * arb(self.unit)
        middle = self._middle.at(time / arb(self._middle.unit))
        by_way = carried(self, share, Parting(ZERO, ONE, ZERO, ZERO, ZERO))
        by_speed = carried(self, share, Parting(ZERO, ZERO, ZERO, ONE, ZERO))
        way, speed, spin = self._apart
        ahead = by_way.way * way + by_speed.way * speed
        faster = by_way.along * way + by_speed.along * speed
        turn = self.law.curvature * ahead
        nx, ny = unit_vector(
            hull.nx.intersection(middle.nx - hull.ny * turn),
            hull.ny.intersection(middle.ny + hull.nx * turn),
        )
        x, y = self.surface.at_contact(hull.x, hull.y, nx, ny)
        u = hull.u.intersection(middle.u + faster)
        omega = u / self.scene.radius
        if self.start.mode != ROLLING:
            turned = by_way.omega * way + by_speed.omega * speed + spin
            omega = hull.omega.intersection(middle.omega + turned)
        return replace(hull, x=x, y=y, nx=nx, ny=ny, u=u, omega=omega)
