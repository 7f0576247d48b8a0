// Box2D 2.4 compiled to WebAssembly, set up as in planck.mjs.
//
// The velocityThreshold of 1 m/s, below which no impact rebounds, is set to 0 on each fixture.
const SCALE = 10;

export async function load() {
  globalThis.fetch = undefined; // with fetch, the loader would fetch a file path; without, it reads
  const { default: Box2DFactory } = await import('box2d-wasm');
  const b2 = await Box2DFactory();
  return (board, xs, dt) => create(b2, board, xs, dt);
}

function create(b2, board, xs, dt) {
  const at = (x, y) => new b2.b2Vec2(SCALE * x, SCALE * y);
  const world = new b2.b2World(at(0, board.gravity));
  world.SetAllowSleeping(false);
  const ground = world.CreateBody(new b2.b2BodyDef());
  const add = (body, shape, density, restitution, friction, group) => {
    const definition = new b2.b2FixtureDef();
    definition.set_shape(shape);
    definition.set_density(density);
    definition.set_restitution(restitution);
    definition.set_restitutionThreshold(0);
    definition.set_friction(friction);
    definition.get_filter().set_groupIndex(group);
    body.CreateFixture(definition);
  };
  const disc = (x, y, r) => {
    const shape = new b2.b2CircleShape();
    shape.set_m_p(at(x, y));
    shape.set_m_radius(SCALE * r);
    return shape;
  };
  const [pegRestitution, pegFriction] = board.peg;
  const [wallRestitution, wallFriction] = board.wall;
  for (const [x, y, r] of board.pegs) {
    add(ground, disc(x, y, r), 0, pegRestitution, pegFriction ** 2, 0);
  }
  for (const [x1, y1, x2, y2] of board.walls) {
    const edge = new b2.b2EdgeShape();
    edge.SetTwoSided(at(x1, y1), at(x2, y2));
    add(ground, edge, 0, wallRestitution, wallFriction ** 2, 0);
  }
  const balls = xs.map((x) => {
    const definition = new b2.b2BodyDef();
    definition.set_type(b2.b2_dynamicBody);
    definition.set_position(at(x, board.y));
    definition.set_linearDamping((Math.exp(board.drag * dt) - 1) / dt);
    definition.set_allowSleep(false);
    const ball = world.CreateBody(definition);
    add(ball, disc(0, 0, board.radius), board.density, 0, 1, -1); // balls pass through each other
    return ball;
  });
  return {
    step() {
      world.Step(dt, 8, 3);
    },
    read(states) {
      balls.forEach((ball, i) => {
        const r = ball.GetPosition();
        const v = ball.GetLinearVelocity();
        states.set([r.x / SCALE, r.y / SCALE, v.x / SCALE, v.y / SCALE], 4 * i);
      });
    },
    free() {
      b2.destroy(world);
    },
  };
}
