// Energies, momenta and contacts of an arena, as in engine/multibody/diagnostics.py.

/** @import { Arena } from "./arena.js" */

/**
 * Energies in J (potential: zero at y = 0), momenta in kg m/s and kg m²/s, penetration in m.
 * @param {Arena} arena
 */
export function diagnose(arena) {
  const { table, settings } = arena;
  const sum = { kinetic: 0, potential: 0, rotational: 0, px: 0, py: 0, angular: 0, asleep: 0 };
  for (let row = 0; row < table.n; row += 1) {
    const [x, y, , radius] = table.pos.subarray(4 * row, 4 * row + 4);
    const [vx, vy, rimSpeed, inverseMass] = table.vel.subarray(4 * row, 4 * row + 4);
    const mass = 1 / inverseMass;
    sum.kinetic += 0.5 * mass * (vx * vx + vy * vy);
    sum.potential -= settings.gravity * mass * y;
    sum.rotational += 0.25 * mass * rimSpeed * rimSpeed;
    sum.px += mass * vx;
    sum.py += mass * vy;
    sum.angular += mass * (x * vy - y * vx + 0.5 * radius * rimSpeed);
    if (table.isAsleep(row)) sum.asleep += 1;
  }
  const total = sum.kinetic + sum.potential + sum.rotational;
  return { ...sum, total, ...arena.overlap(), count: table.n, time: arena.time };
}
