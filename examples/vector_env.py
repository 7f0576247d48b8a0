"""A vectorised environment in the form of Gymnasium: choose where each ball starts.

    pip install plinko-sim
    python vector_env.py

Each episode is one drop. The observation is the bin to hit, the action the start x in metres, and
the reward minus the distance from that bin. It prints the mean reward of two simple policies.
"""

import numpy as np

import plinko


class PlinkoVectorEnv:
    """`num_envs` boards side by side; the next episodes begin in the same step."""

    def __init__(self, board="classic", num_envs=256):
        self.metadata = {"autoreset_mode": "SameStep"}
        self.board = plinko.Board.named(board)
        self.num_envs = num_envs
        zone = self.board.drop
        self.low, self.high = zone.x - zone.span, zone.x + zone.span

    def reset(self, *, seed=None, options=None):
        self.random = np.random.default_rng(seed)
        self.goals = self.random.integers(self.board.bins.count, size=self.num_envs)
        return self.goals.astype(np.float32)[:, None], {}

    def step(self, actions):
        xs = np.clip(np.ravel(actions), self.low, self.high)
        batch = plinko.drop_many(self.board, xs=xs)
        rewards = -np.abs(batch.bin - self.goals).astype(np.float64)
        info = {"bin": batch.bin, "final_obs": self.goals.astype(np.float32)[:, None]}
        self.goals = self.random.integers(self.board.bins.count, size=self.num_envs)
        landed = batch.bin >= 0  # a ball in perfect balance never lands
        return self.goals.astype(np.float32)[:, None], rewards, landed, ~landed, info


if __name__ == "__main__":
    env = PlinkoVectorEnv()
    edges = np.array(env.board.bins.edges)
    middles = 0.5 * (edges[1:] + edges[:-1])
    for name in ("above the goal", "anywhere"):
        goals, _ = env.reset(seed=1)
        aimed = middles[goals[:, 0].astype(int)] + env.random.normal(0.0, 0.01, env.num_envs)
        xs = aimed if name == "above the goal" else env.random.uniform(env.low, env.high, 256)
        print(f"{name}: mean reward {env.step(xs)[1].mean():.2f}")
