// planck, as its expert would set it up.
//
// The scene is ten times larger than life, so that the tolerated overlap of 5 mm is 0.5 mm in real
// size. Every impact rebounds, however slow (velocityThreshold 0). A pair has the larger
// restitution and the root of the product of the frictions: the ball therefore has 0 and 1, the
// board the square of its friction. linearDamping is set so that its rule v / (1 + c dt) equals
// exp(-k dt). Continuous collision is on, sleeping is off.
const SCALE = 10;

export async function load() {
  const planck = await import('planck');
  planck.Settings.velocityThreshold = 0;
  return (board, xs, dt) => create(planck, board, xs, dt);
}

function create(planck, board, xs, dt) {
  const { Circle, Edge, Vec2, World } = planck;
  const at = (x, y) => new Vec2(SCALE * x, SCALE * y);
  const world = new World({ gravity: at(0, board.gravity), allowSleep: false });
  const ground = world.createBody();
  const surface = ([restitution, friction]) => ({ restitution, friction: friction * friction });
  for (const [x, y, r] of board.pegs) {
    ground.createFixture({ shape: new Circle(at(x, y), SCALE * r), ...surface(board.peg) });
  }
  for (const [x1, y1, x2, y2] of board.walls) {
    ground.createFixture({ shape: new Edge(at(x1, y1), at(x2, y2)), ...surface(board.wall) });
  }
  const linearDamping = (Math.exp(board.drag * dt) - 1) / dt;
  const balls = xs.map((x) => {
    const ball = world.createBody({
      type: 'dynamic', position: at(x, board.y), linearDamping, allowSleep: false,
    });
    ball.createFixture({
      shape: new Circle(SCALE * board.radius),
      density: board.density,
      restitution: 0,
      friction: 1,
      filterGroupIndex: -1, // balls pass through each other
    });
    return ball;
  });
  return {
    step() {
      world.step(dt, 8, 3);
    },
    read(states) {
      balls.forEach((ball, i) => {
        const r = ball.getPosition();
        const v = ball.getLinearVelocity();
        states.set([r.x / SCALE, r.y / SCALE, v.x / SCALE, v.y / SCALE], 4 * i);
      });
    },
  };
}
