// The pages' own solver on V8: `node page.mjs` reads one JSON task per line on stdin.
//
// Task: {board, drops}: drops with seeds from 0, in slices like static/js/solver/many/worker.js.
// Answer: {seconds, bins, x_ends}, one JSON line on stdout; the caller compares bins and x_ends.
import { readFileSync } from 'node:fs';
import { createInterface } from 'node:readline';

import { openSolver } from '../../static/js/solver/solver.js';

const AT_ONCE = 500;
const KERNELS = new URL('../../static/js/solver/kernels.wasm', import.meta.url);

const solver = await openSolver(readFileSync(KERNELS));

function play({ board, drops }) {
  const whole = solver.read(board);
  const bins = new Int32Array(drops);
  const ends = new Float64Array(drops);
  const start = performance.now();
  for (let first = 0; first < drops; first += AT_ONCE) {
    const many = Math.min(AT_ONCE, drops - first);
    const found = solver.dropMany(whole, Array.from({ length: many }, (_, i) => BigInt(first + i)));
    bins.set(found.bins, first);
    ends.set(found.xEnds, first);
  }
  const seconds = (performance.now() - start) / 1000;
  return { seconds, bins: [...bins], x_ends: [...ends] };
}

for await (const line of createInterface({ input: process.stdin })) {
  let answer;
  try {
    answer = play(JSON.parse(line));
  } catch (error) {
    answer = { error: String(error) };
  }
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}
