// Wires the sandbox: a room of balls that touch each other, its canvas, its desk.

import { ApiError, postJson } from "../net/api.js";
import { Chart } from "../instruments/chart.js";
import { Dials } from "./dials.js";
import { byId, make } from "../util/dom.js";
import { FrameLoop } from "../util/frame-loop.js";
import { openPage, showState } from "../board/page.js";
import { SandboxHand } from "./pointer.js";
import { EnergyHistory, energies, massOf, showFacts } from "./energies.js";
import { SandboxRoom } from "./room.js";
import { SandboxView } from "./view.js";

const PUBLIC_ROOM = "sandbox";
const TOKENS = "plinko.tokens.1"; // of the rooms this tab has opened
const CALM_MS = 400; // between two pictures for those who do not want to see motion
const STATE_WORDS = {
  connecting: "Connecting…", live: "Live", asleep: "At rest", paused: "Paused", closed: "Closed",
};
const WORLD = [
  { name: "gravity", label: "Gravity", low: 0, high: 30, step: 0.01, unit: "m/s²" },
  { name: "restitution", label: "Bounce", low: 0, high: 1, step: 0.005, unit: "" },
  { name: "friction", label: "Friction", low: 0, high: 1, step: 0.01, unit: "" },
  { name: "density", label: "Density", low: 1, high: 10000, log: true, unit: "kg/m²" },
  { name: "drag", label: "Air drag", low: 0, high: 3, step: 0.01, unit: "1/s" },
  { name: "damping", label: "Damping", low: 0.9, high: 1, step: 0.001, unit: "a step" },
];
const SOLVER = [
  { name: "dt", label: "Time step", low: 0.001, high: 0.1, log: true, unit: "s",
    show: (value) => `${(1000 * value).toPrecision(3)} ms` },
  { name: "substeps", label: "Substeps", low: 1, high: 32, step: 1, unit: "a step" },
  { name: "correction", label: "Correction", low: 0.4, high: 0.8, step: 0.01, unit: "" },
];
const THROW = [
  { name: "radius", label: "Radius", low: 0.02, high: 0.5, log: true, unit: "m" },
  { name: "speed", label: "Speed", low: 0, high: 30, step: 0.5, unit: "m/s" },
  { name: "angle", label: "Direction", low: -180, high: 180, step: 5, unit: "°",
    show: (value) => `${value}° ${wayOf(value)}` },
];
const BALL = [
  { name: "radius", label: "Radius", low: 0.02, high: 0.5, log: true, unit: "m" },
  { name: "density", label: "Density", low: 1, high: 10000, log: true, unit: "kg/m²" },
  { name: "restitution", label: "Bounce", low: 0, high: 1, step: 0.005, unit: "" },
  { name: "friction", label: "Friction", low: 0, high: 1, step: 0.01, unit: "" },
];

function wayOf(angle) {
  const ways = ["right", "up right", "up", "up left", "left", "down left", "down", "down right"];
  return ways[((Math.round(angle / 45) % 8) + 8) % 8];
}

class SandboxPage {
  #still = window.matchMedia("(prefers-reduced-motion: reduce)");
  #drawn = 0;
  #calm = 0;

  constructor(theme, roomId) {
    const canvases = { still: byId("board-still"), moving: byId("board-moving") };
    this.view = new SandboxView(canvases, theme, () => this.loop?.wake());
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.chart = new Chart(byId("energy"), theme);
    this.history = new EnergyHistory();
    this.throwing = new Dials(byId("throw-sliders"), THROW);
    this.throwing.set({ radius: 0.12, speed: 6, angle: 45 });
    const set = (name, value) => this.room.send({ type: "settings", [name]: value });
    this.world = new Dials(byId("world-sliders"), WORLD, set);
    this.solver = new Dials(byId("solver-sliders"), SOLVER, set);
    this.ball = new Dials(byId("ball-sliders"), BALL, (name, value) =>
      this.room.send({ type: "edit", ball: this.hand.chosen, [name]: value }));
    this.hand = this.#makeHand();
    this.#wireDesk();
    this.room = new SandboxRoom(roomId, {
      onRoom: (hello) => this.#enter(hello),
      onState: (state, detail) => this.#showState(state, detail),
      onEvent: (event) => this.#happened(event),
      onError: (message) => this.#say(message),
      onChange: () => this.loop.wake(),
    });
    this.room.watch(document.visibilityState === "visible");
    document.addEventListener("visibilitychange", () => {
      this.room.watch(document.visibilityState === "visible");
      this.loop.wake();
    });
    window.addEventListener("pagehide", () => this.room.letGo());
  }

  #makeHand() {
    return new SandboxHand(
      this.view,
      (place, reach) => this.#ballAt(place, reach),
      () => this.throwing.value("radius"),
      {
        onDrag: (ball, { x, y }) => this.room.drag(ball, x, y),
        onLetGo: () => this.room.letGo(),
        onChoose: (ball) => this.#choose(ball),
        onThrow: (place, vx, vy) => this.#throw(place, vx, vy),
        onThrowAimed: () => this.#throwAimed(),
        onKick: () => this.#kick(),
        onRemove: () => this.#remove(),
        onSay: (text) => this.#say(text),
        onChange: () => this.loop.wake(),
      },
    );
  }

  #wireDesk() {
    byId("pause").addEventListener("click", () => this.#pause());
    byId("step").addEventListener("click", () => this.#step());
    byId("clear").addEventListener("click", () => this.room.send({ type: "clear" }));
    byId("reset").addEventListener("click", () => this.room.send({ type: "reset" }));
    byId("throw").addEventListener("click", () => this.#throwAimed());
    byId("drop").addEventListener("click", () => this.room.send({ type: "drop" }));
    byId("remove").addEventListener("click", () => this.#remove());
    for (const name of ["gravity", "restitution"]) {
      byId(`${name}-preset`).addEventListener("change", ({ target }) => {
        if (target.value) this.room.send({ type: "settings", [name]: target.value });
      });
    }
    const form = byId("scene-form");
    form.addEventListener("change", () => this.#showSceneFields());
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.room.send({ type: "reset", scene: this.#scene() });
    });
    byId("own").addEventListener("click", () => this.#openOwn());
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Pause and step from anywhere that has no use of its own for the key. */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || this.hand.locked) return;
    if (event.target.closest("input:not([type=range]), select")) return;
    const act = { p: () => this.#pause(), ".": () => this.#step() }[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  }

  // The room.

  #enter(hello) {
    const { arena, extent, board } = hello;
    this.view.setPlace(arena.place, extent);
    this.hand.begin(extent);
    this.history.clear();
    this.#fillPresets(arena.presets);
    this.#showSettings(arena.settings);
    this.#fillScene(arena.scene, hello.limits.balls);
    byId("title").textContent = titleOf(hello);
    byId("drop").hidden = !board;
    byId("scene-panel").hidden = arena.scene === null;
    byId("to-table").href = board && hello.room.startsWith("interacting-")
      ? `./?${new URLSearchParams({ room: hello.room })}` : "./";
    this.#choose(null);
    const token = tokens()[hello.room];
    this.#lock(arena.owned);
    if (arena.owned && token) this.room.send({ type: "claim", token });
    this.#describe();
    this.#say(`${titleOf(hello)}: ${arena.balls.ball.length} balls.`);
    this.loop.wake();
  }

  #lock(locked) {
    this.hand.locked = locked;
    byId("locked").hidden = !locked;
    document.documentElement.dataset.locked = String(locked);
    for (const dials of [this.throwing, this.world, this.solver, this.ball]) dials.disabled = locked;
    for (const control of document.querySelectorAll(".desk button:not(#own), .desk select")) {
      control.disabled = locked;
    }
    byId("step").disabled = locked || !this.room.paused;
  }

  #happened(event) {
    const acts = {
      claimed: () => this.#lock(false),
      settings: () => this.#showSettings(event.settings),
      placed: () => this.#describe(),
      removed: () => this.#gone(event.balls),
      landed: () => {
        this.#gone([event.ball]);
        const where = event.bin === null ? "came to rest on the board" : `fell into bin ${event.bin}`;
        this.#say(`Ball ${event.ball} ${where}.`);
      },
      edited: () => this.hand.chosen !== null && this.#choose(this.hand.chosen),
      diagnostics: () => this.#measured(event),
    };
    acts[event.type]?.();
  }

  #gone(balls) {
    for (const ball of balls) this.hand.forget(ball & 0xffff);
    if (this.hand.chosen === null) this.#choose(null);
    this.#describe();
  }

  #measured(event) {
    const weight = massOf(this.room.made.values()) * this.room.settings.gravity;
    const row = energies(event, weight, this.view.extent.y_max);
    this.history.add(row);
    this.chart.set(this.history.plot());
    showFacts(byId("facts"), event, row);
    byId("energy").setAttribute(
      "aria-label",
      `Energy against time: total ${row.total.toPrecision(3)}, kinetic ` +
      `${row.kinetic.toPrecision(3)}, potential ${row.potential.toPrecision(3)} joules.`,
    );
  }

  #showSettings(settings) {
    this.world.set(settings);
    this.solver.set(settings);
    byId("pause").textContent = this.room.paused ? "Go on" : "Pause";
    byId("step").disabled = this.hand.locked || !this.room.paused;
    for (const [name, options] of Object.entries(this.presets)) {
      const found = Object.entries(options).find(([, value]) => Math.abs(value - settings[name]) < 1e-9);
      const select = byId(`${name}-preset`);
      // Several presets may stand for the same number: what was chosen stays.
      if (!select.value || options[select.value] !== settings[name]) select.value = found?.[0] ?? "";
    }
  }

  #showState(state, detail) {
    showState(state, state === "reconnecting"
      ? `Line lost, trying again in ${detail}` : STATE_WORDS[state]);
    if (state === "closed") this.#say(detail || "The room is closed.");
    if (state === "asleep" && this.room.made.size) this.#say("Everything is at rest.");
    this.loop.wake();
  }

  #fillPresets(presets) {
    this.presets = presets;
    for (const [name, values] of Object.entries(presets)) {
      const select = byId(`${name}-preset`);
      if (select.options.length) continue;
      const own = make("option", { value: "" }, "as set");
      select.append(own, ...Object.entries(values).map(([preset, value]) =>
        make("option", { value: preset }, `${capital(preset)} (${value.toFixed(2)})`)));
    }
  }

  // Acts.

  #throw({ x, y }, vx, vy) {
    const radius = this.throwing.value("radius");
    const sent = this.room.send({ type: "add", x, y, vx, vy, radius });
    const speed = Math.hypot(vx, vy);
    if (!sent) this.#say("There is no line to the room yet. Nothing was thrown.");
    else this.#say(speed ? `Thrown at ${speed.toFixed(1)} m/s.` : "Put down.");
  }

  #aimed() {
    const angle = (this.throwing.value("angle") * Math.PI) / 180;
    const speed = this.throwing.value("speed");
    return [speed * Math.cos(angle), -speed * Math.sin(angle)];
  }

  #throwAimed() {
    this.#throw(this.hand.cross, ...this.#aimed());
  }

  #kick() {
    const ball = this.hand.chosen ?? this.#ballAt(this.hand.cross, Number.POSITIVE_INFINITY);
    if (ball === null) return;
    const [vx, vy] = this.#aimed();
    this.room.send({ type: "kick", ball, vx, vy });
    this.#say(`Kicked ball ${ball}.`);
  }

  #remove() {
    const ball = this.hand.chosen ?? this.#ballAt(this.hand.cross, 0.1);
    if (ball === null) return;
    this.room.send({ type: "remove", ball });
    this.#say(`Ball ${ball} removed.`);
  }

  #pause() {
    this.room.send({ type: "pause", paused: !this.room.paused });
    this.#say(this.room.paused ? "Going on." : "Paused.");
  }

  #step() {
    if (this.room.paused) this.room.send({ type: "step" });
  }

  #choose(ball) {
    this.hand.chosen = ball;
    const made = ball === null ? null : this.room.made.get(ball);
    byId("ball-panel").hidden = !made;
    if (!made) return;
    const mass = massOf([made]);
    byId("ball-title").textContent = `Ball ${ball}, ${mass.toPrecision(3)} kg`;
    this.ball.set(made);
  }

  /** The ball under a place, or the nearest within reach of it. */
  #ballAt({ x, y }, reach) {
    let [best, found] = [reach, null];
    this.room.look(performance.now(), (ball) => {
      const away = Math.max(0, Math.hypot(ball.x - x, ball.y - y) - ball.radius);
      if (away < best || (away === 0 && best === 0 && found === null)) [best, found] = [away, ball.id];
    });
    return found;
  }

  // The scene.

  #scene() {
    const { elements } = byId("scene-form");
    const number = (name) => Number(elements[name].value);
    const settings = Object.fromEntries(
      Object.keys(this.room.settings).map((name) => [name, this.room.settings[name]]),
    );
    const common = { balls: number("balls"), seed: elements.seed.value.trim() || "0" };
    if (elements.scene.value === "galton") return { scene: "galton", ...common };
    return {
      scene: "sandbox", ...common, ...settings, speed: number("speed"),
      radii: [number("low"), number("high")], width: number("width"), height: number("height"),
    };
  }

  #fillScene(scene, most) {
    const { elements } = byId("scene-form");
    elements.balls.max = String(most);
    if (scene === null) return;
    const box = { radii: [0.06, 0.16], width: 6, height: 4, speed: 0, ...scene };
    elements.scene.value = scene.scene;
    elements.balls.value = scene.balls;
    elements.seed.value = scene.seed;
    [elements.low.value, elements.high.value] = box.radii;
    for (const name of ["width", "height", "speed"]) elements[name].value = box[name];
    this.#showSceneFields();
  }

  #showSceneFields() {
    const { value } = byId("scene-form").elements.scene;
    for (const part of document.querySelectorAll("[data-of]")) part.hidden = part.dataset.of !== value;
  }

  async #openOwn() {
    try {
      const { id, token } = await postJson("rooms", this.#scene());
      sessionStorage.setItem(TOKENS, JSON.stringify({ ...tokens(), [id]: token }));
      window.location.assign(`sandbox.html?${new URLSearchParams({ room: id })}`);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.#say(error.message);
    }
  }

  // The picture.

  #draw(now) {
    if (this.#still.matches && now - this.#drawn < CALM_MS) {
      // Less often, and the last one all the same.
      this.#calm ||= setTimeout(() => {
        this.#calm = 0;
        this.loop.wake();
      }, CALM_MS);
      return false;
    }
    this.#drawn = now;
    this.view.draw((see) => this.room.look(now, see), this.hand);
    return this.room.busy;
  }

  #describe() {
    byId("board-moving").setAttribute(
      "aria-label", `Box with ${this.room.made.size} balls that touch each other`,
    );
  }

  #say(text) {
    byId("result").textContent = text;
  }
}

function titleOf({ board, board_name: name, arena }) {
  if (board) return `Balls that touch, on ${name}`;
  return arena.scene.scene === "galton" ? "Galton pile" : "Sandbox";
}

function tokens() {
  return JSON.parse(sessionStorage.getItem(TOKENS) ?? "{}");
}

function capital(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

openPage(async (theme) => {
  const asked = new URLSearchParams(window.location.search);
  return new SandboxPage(theme, asked.get("room") || PUBLIC_ROOM);
});
