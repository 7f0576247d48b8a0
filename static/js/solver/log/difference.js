// Compares a drop's record with the recomputed drop, field by field and bit by bit. Pure.

/** @typedef {ReturnType<import("../drop.js").Drop["record"]>} Computed */
/** @typedef {{field: string, expected: unknown, actual: unknown}} Difference expected: recorded; actual: recomputed */

/** The fields of a record that are results, in the order of comparison. */
const FIELDS = /** @type {const} */ (["board_digest", "physics_version", "bin", "score", "duration",
  "x_end"]);

/**
 * @param {Record<string, unknown>} record
 * @param {Computed} computed
 * @returns {{same: number, difference: Difference | null}} same: how many first
 *   impacts are equal
 */
export function compareRecords(record, computed) {
  const given = /** @type {number[][]} */ (record.impacts ?? computed.impacts);
  const wrong = computed.impacts.findIndex((row, i) => !isSame(row, given[i] ?? []));
  const same = wrong < 0 ? computed.impacts.length : wrong;
  const field = FIELDS.find((name) => name in record && record[name] !== computed[name]);
  if (field) return { same, difference: { field, expected: record[field], actual: computed[field] } };
  if (given.length !== computed.impacts.length) {
    const [expected, actual] = [given, computed.impacts].map(({ length }) => `${length} impacts`);
    return { same, difference: { field: "impacts", expected, actual } };
  }
  if (wrong >= 0) {
    const [expected, actual] = [given[wrong], computed.impacts[wrong]];
    return { same, difference: { field: `impacts[${wrong}]`, expected, actual } };
  }
  if (record.digest === computed.digest) return { same, difference: null };
  return { same, difference: { field: "digest", expected: record.digest, actual: computed.digest } };
}

/** @param {number[]} one @param {number[]} other */
function isSame(one, other) {
  return one.length === other.length && one.every((value, i) => Object.is(value, other[i]));
}
