// Plays boards on one Node.js engine: `node runner.mjs ENGINE` reads a JSON task per line on stdin.
//
// Task: {board, xs, dt, steps, poll, record}. board: {gravity, drag, radius, density, y, bins_y,
// pegs: [[x, y, r]], walls: [[x1, y1, x2, y2]], peg: [e, mu], wall: [e, mu]}, SI, pair values.
// record: the file for float64 x, y, vx, vy of all balls at steps 0 … steps. null: step until all
// balls are below bins_y, which is checked every `poll` steps; the checks are not timed.
// Answer: {seconds} or {error}, one JSON line on stdout.
import { writeFileSync } from 'node:fs';
import { createInterface } from 'node:readline';

const engine = process.argv[2];
const { load } = await import(`./${engine}.mjs`);
const create = await load();

function play(task) {
  const count = task.xs.length;
  const world = create(task.board, task.xs, task.dt);
  const states = new Float64Array(4 * count);
  if (task.record !== null) return record(task, world, count);
  let seconds = 0;
  for (let step = 0; step < task.steps; step += task.poll) {
    const start = performance.now();
    for (let i = 0; i < task.poll; i += 1) world.step();
    seconds += (performance.now() - start) / 1000;
    world.read(states);
    if (allBelow(states, task.board.bins_y)) break;
  }
  world.free?.();
  return { seconds };
}

function record(task, world, count) {
  const all = new Float64Array(4 * count * (task.steps + 1));
  for (let step = 0; step <= task.steps; step += 1) {
    if (step > 0) world.step();
    world.read(all.subarray(4 * count * step, 4 * count * (step + 1)));
  }
  world.free?.();
  writeFileSync(task.record, new Uint8Array(all.buffer));
  return { seconds: 0 };
}

function allBelow(states, y) {
  for (let i = 1; i < states.length; i += 4) if (!(states[i] >= y)) return false;
  return true;
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
