// matter-js, as its expert would set it up.
//
// Lengths are in pixels, 100 per metre, because its tolerances are made for that. Its circles are
// polygons with at most one side per pixel of radius: ours have 64 sides. By default no impact
// slower than 2 pixels per frame rebounds; that limit is lowered to 0.001. Making a body static
// sets its restitution to 0 and its friction to 1, so both are set again afterwards. A pair has the
// larger restitution and the smaller friction: the ball therefore has 0 and 1. There is no
// continuous collision, so a wall is half a metre thick, on the side away from the ball. Friction
// is an impulse per frame and not Coulomb's, which no setting changes. frictionAir is set so that
// its rule v (1 - f dt / (1/60 s)) equals exp(-k dt). Sleeping is off.
import Matter from 'matter-js';

const SCALE = 100;
const SIDES = 64;
const THICKNESS = 0.5; // m
const FRAME = 1000 / 60; // ms; matter-js states velocities per frame

const { Bodies, Body, Composite, Engine, Resolver } = Matter;

export async function load() {
  Resolver._restingThresh = 0.001;
  return create;
}

function create(board, xs, dt) {
  const engine = Engine.create({ enableSleeping: false });
  engine.gravity.y = 1;
  engine.gravity.scale = board.gravity * SCALE * 1e-6; // pixels / ms^2
  const ground = (body, [restitution, friction]) => {
    Object.assign(body, { restitution, friction, frictionStatic: 0 });
    Composite.add(engine.world, body);
  };
  for (const [x, y, r] of board.pegs) {
    const peg = Bodies.polygon(SCALE * x, SCALE * y, SIDES, SCALE * r, { isStatic: true });
    ground(peg, board.peg);
  }
  for (const [x1, y1, x2, y2] of board.walls) {
    const length = Math.hypot(x2 - x1, y2 - y1);
    const [tx, ty] = [(x2 - x1) / length, (y2 - y1) / length];
    const side = (xs[0] - x1) * -ty + (board.y - y1) * tx > 0 ? -0.5 : 0.5;
    const wall = Bodies.rectangle(
      SCALE * ((x1 + x2) / 2 - side * THICKNESS * ty),
      SCALE * ((y1 + y2) / 2 + side * THICKNESS * tx),
      SCALE * length,
      SCALE * THICKNESS,
      { isStatic: true, angle: Math.atan2(ty, tx) },
    );
    ground(wall, board.wall);
  }
  const frictionAir = ((1 - Math.exp(-board.drag * dt)) * FRAME) / (1000 * dt);
  const balls = xs.map((x) => Bodies.polygon(SCALE * x, SCALE * board.y, SIDES, SCALE * board.radius, {
    restitution: 0,
    friction: 1,
    frictionStatic: 0,
    frictionAir,
    slop: 0.01,
    collisionFilter: { group: -1 }, // balls pass through each other
  }));
  Composite.add(engine.world, balls);
  return {
    step() {
      Engine.update(engine, 1000 * dt);
    },
    read(states) {
      balls.forEach((ball, i) => {
        const velocity = Body.getVelocity(ball);
        states[4 * i] = ball.position.x / SCALE;
        states[4 * i + 1] = ball.position.y / SCALE;
        states[4 * i + 2] = (velocity.x * 60) / SCALE;
        states[4 * i + 3] = (velocity.y * 60) / SCALE;
      });
    },
  };
}
