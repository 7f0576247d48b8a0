// Checks Merkle proofs of RFC 6962 as in RFC 9162: that a leaf is in the tree, and that the tree only grew.

import { hexOf, joined, sha256 } from "./crypto.js";

/** @import { Bytes } from "./crypto.js" */

/** @param {Bytes} leaf */
export const leafHash = (leaf) => sha256(joined(Uint8Array.of(0), leaf));

/** @param {Uint8Array} left @param {Uint8Array} right */
export const nodeHash = (left, right) => sha256(joined(Uint8Array.of(1), left, right));

/**
 * Whether a proof shows that the leaf is at this index in the tree of this size and root.
 * @param {Bytes} leaf
 * @param {{index: number, size: number, root: Bytes}} tree
 * @param {Bytes[]} proof
 */
export async function isIncluded(leaf, { index, size, root }, proof) {
  if (!(index >= 0 && index < size)) return false;
  let digest = await leafHash(leaf);
  const climbed = await climb(index, size - 1, proof, async (sibling, isLeft) => {
    digest = await (isLeft ? nodeHash(sibling, digest) : nodeHash(digest, sibling));
  });
  return climbed && hexOf(digest) === hexOf(root);
}

/**
 * Whether a proof shows that the second tree begins with all leaves of the first.
 * @param {{size: number, root: Bytes}} first
 * @param {{size: number, root: Bytes}} second
 * @param {Bytes[]} proof
 */
export async function isConsistent(first, second, proof) {
  if (first.size === second.size) {
    return proof.length === 0 && hexOf(first.root) === hexOf(second.root);
  }
  if (!(first.size > 0 && first.size < second.size)) return false;
  const complete = Number.isInteger(Math.log2(first.size));
  const path = complete ? [first.root, ...proof] : [...proof];
  const start = path.shift();
  if (!start) return false;
  let [place, last] = [first.size - 1, second.size - 1];
  while (place % 2 === 1) [place, last] = [half(place), half(last)];
  let [before, after] = [start, start];
  const climbed = await climb(place, last, path, async (sibling, isLeft) => {
    if (isLeft) before = await nodeHash(sibling, before);
    after = await (isLeft ? nodeHash(sibling, after) : nodeHash(after, sibling));
  });
  return climbed && hexOf(before) === hexOf(first.root) && hexOf(after) === hexOf(second.root);
}

/** @param {number} number whole, up to 2^53 */
const half = (number) => Math.floor(number / 2);

/**
 * Climbs from a node to the root, and calls `meet` with each sibling in the proof.
 * @param {number} place
 * @param {number} last the place of the last node of this level
 * @param {Bytes[]} proof
 * @param {(sibling: Bytes, isLeft: boolean) => Promise<void>} meet
 * @returns {Promise<boolean>} whether the proof ended at the root
 */
async function climb(place, last, proof, meet) {
  let [at, end] = [place, last];
  for (const sibling of proof) {
    if (end === 0) return false;
    const isLeft = at % 2 === 1 || at === end;
    await meet(sibling, isLeft);
    while (isLeft && at % 2 === 0 && at !== 0) [at, end] = [half(at), half(end)];
    [at, end] = [half(at), half(end)];
  }
  return end === 0;
}
