// The kernels for touching balls, loaded for tests.

import { readFileSync } from "node:fs";

import { Machine } from "../../../static/js/solver/machine.js";

export const machine = await Machine.open(
  readFileSync(new URL("../../../static/js/solver/touching/touching.wasm", import.meta.url)),
);
