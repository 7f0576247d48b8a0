// Rapier 2D, as its expert would set it up.
//
// Lengths are in metres, with lengthUnit 0.1 (the size of a ball), from which Rapier derives its
// tolerances. The ball's combination rule is Max for restitution and friction, and the ball's own
// values are 0, so that a pair has the board's values. linearDamping is set so that its rule
// v / (1 + c dt) equals exp(-k dt). Continuous collision is on, sleeping is off.
const BALLS = 0x0001_0002; // in group 1, touches group 2
const BOARD = 0x0002_0001;

export async function load() {
  const { default: rapier } = await import('@dimforge/rapier2d-compat');
  await rapier.init();
  return (board, xs, dt) => create(rapier, board, xs, dt);
}

function create(rapier, board, xs, dt) {
  const world = new rapier.World({ x: 0, y: board.gravity });
  world.timestep = dt;
  world.lengthUnit = 0.1;
  const ground = (shape, [restitution, friction]) => {
    world.createCollider(
      shape.setRestitution(restitution).setFriction(friction).setCollisionGroups(BOARD),
    );
  };
  const { ColliderDesc } = rapier;
  for (const [x, y, r] of board.pegs) {
    ground(ColliderDesc.ball(r).setTranslation(x, y), board.peg);
  }
  for (const [x1, y1, x2, y2] of board.walls) {
    ground(ColliderDesc.segment({ x: x1, y: y1 }, { x: x2, y: y2 }), board.wall);
  }
  const damping = (Math.exp(board.drag * dt) - 1) / dt;
  const balls = xs.map((x) => {
    const body = world.createRigidBody(
      rapier.RigidBodyDesc.dynamic()
        .setTranslation(x, board.y)
        .setLinearDamping(damping)
        .setCanSleep(false)
        .setCcdEnabled(true),
    );
    const disc = ColliderDesc.ball(board.radius)
      .setDensity(board.density)
      .setRestitution(0)
      .setRestitutionCombineRule(rapier.CoefficientCombineRule.Max)
      .setFriction(0)
      .setFrictionCombineRule(rapier.CoefficientCombineRule.Max)
      .setCollisionGroups(BALLS);
    world.createCollider(disc, body);
    return body;
  });
  return {
    step() {
      world.step();
    },
    read(states) {
      balls.forEach((ball, i) => {
        const r = ball.translation();
        const v = ball.linvel();
        states.set([r.x, r.y, v.x, v.y], 4 * i);
      });
    },
    free() {
      world.free();
    },
  };
}
