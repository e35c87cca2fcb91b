"""The vector environment: independent of its threads, equal to single environments, and Gymnasium's autoreset."""

import os
import unittest

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode

import panda_twin  # noqa: F401: registers the environments

NAMES = ("Reach", "Push", "PickAndPlace", "Peg", "Wipe")
STEPS = int(os.environ.get("TWIN_VECTOR_STEPS", "1000"))


def make(task, count, **options):
    return gymnasium.make_vec(f"PandaTwin/{task}-v0", num_envs=count, **options)


def actions_of(env, steps, seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform(-1, 1, (steps, *env.action_space.shape)).astype(np.float32)


def digest(step):
    """All bytes of a step's result but the texts."""
    observations, rewards, terminated, truncated, infos = step
    parts = [observations[key].tobytes() for key in sorted(observations)]
    parts += [rewards.tobytes(), terminated.tobytes(), truncated.tobytes()]
    parts += [infos[key].tobytes() for key in sorted(infos) if getattr(infos[key], "dtype", None) in (float, int, bool)]
    return b"".join(parts)


class Vector(unittest.TestCase):
    def test_results_do_not_depend_on_the_number_of_threads(self):
        for name in NAMES:
            with self.subTest(task=name):
                envs = [make(name, 4, threads=threads, losses=0.02) for threads in (1, 2, 4)]
                first, *others = ([env.reset(seed=1)[0] for env in envs])
                for other in others:
                    self.assertEqual({k: v.tobytes() for k, v in first.items()}, {k: v.tobytes() for k, v in other.items()})
                for k, actions in enumerate(actions_of(envs[0], STEPS)):
                    one, two, four = (digest(env.step(actions)) for env in envs)
                    self.assertEqual(one, two, k)
                    self.assertEqual(one, four, k)

    def test_each_robot_does_what_a_single_environment_does(self):
        vector = make("Push", 3, threads=2, autoreset_mode=AutoresetMode.DISABLED)
        singles = [gymnasium.make("PandaTwin/Push-v0") for _ in range(3)]
        observations, _ = vector.reset(seed=11)
        for i, single in enumerate(singles):
            observation, _ = single.reset(seed=11 + i)
            for key, value in observation.items():
                self.assertEqual(value.tobytes(), observations[key][i].tobytes())
        for actions in actions_of(vector, 20):
            observations, rewards, _, _, infos = vector.step(actions)
            for i, single in enumerate(singles):
                observation, reward, _, _, info = single.step(actions[i])
                self.assertEqual(reward, rewards[i])
                for key, value in observation.items():
                    self.assertEqual(value.tobytes(), observations[key][i].tobytes())
                self.assertEqual(info["margin"], infos["margin"][i])
                self.assertEqual(info["is_success"], infos["is_success"][i])

    def test_next_step_resets_in_the_step_after_the_last(self):
        env = make("Reach", 2, max_episode_steps=3)
        self.assertEqual(env.metadata["autoreset_mode"], AutoresetMode.NEXT_STEP)
        first, _ = env.reset(seed=1)
        actions = np.ones(env.action_space.shape, dtype=np.float32)
        for _ in range(2):
            *_, truncated, _ = env.step(actions)
            self.assertFalse(truncated.any())
        last, _, terminated, truncated, _ = env.step(actions)
        self.assertTrue(truncated.all() and not terminated.any())
        after, rewards, terminated, truncated, _ = env.step(actions)
        self.assertFalse(truncated.any() or terminated.any())
        np.testing.assert_array_equal(rewards, 0)
        self.assertFalse(np.array_equal(after["desired_goal"], last["desired_goal"]))
        np.testing.assert_allclose(after["achieved_goal"], first["achieved_goal"], atol=1e-12)

    def test_same_step_resets_at_once_and_gives_the_last_observation(self):
        env = make("Reach", 2, max_episode_steps=3, autoreset_mode="SameStep")
        plain = make("Reach", 2, max_episode_steps=3)
        first, _ = env.reset(seed=1)
        plain.reset(seed=1)
        actions = np.ones(env.action_space.shape, dtype=np.float32)
        for _ in range(3):
            observations, rewards, _, truncated, infos = env.step(actions)
            last, plain_rewards, *_ = plain.step(actions)
            np.testing.assert_array_equal(rewards, plain_rewards)
        self.assertTrue(truncated.all())
        for i in range(2):
            for key in last:
                np.testing.assert_array_equal(infos["final_obs"][i][key], last[key][i])
        self.assertTrue(infos["_final_obs"].all() and infos["_final_info"].all())
        np.testing.assert_array_equal(infos["final_info"]["cycles_served"], [50, 50])
        np.testing.assert_allclose(observations["achieved_goal"], first["achieved_goal"], atol=1e-12)
        *_, truncated, _ = env.step(actions)
        self.assertFalse(truncated.any())

    def test_a_reflex_ends_one_robots_episode_and_no_other(self):
        env = make("Reach", 2, interface="torque", viability=None, max_episode_steps=1000)
        env.reset(seed=1)
        actions = np.zeros(env.action_space.shape, dtype=np.float32)
        actions[1] = 1
        for _ in range(40):
            _, _, terminated, _, infos = env.step(actions)
            if terminated.any():
                break
        np.testing.assert_array_equal(terminated, [False, True])
        np.testing.assert_array_equal(infos["_reflex"], [False, True])
        self.assertRegex(infos["reflex"][1], r"joint \d")
        _, _, terminated, _, infos = env.step(actions)
        self.assertFalse(terminated.any() or "reflex" in infos)

    def test_disabled_asks_for_a_reset_mask(self):
        env = make("Reach", 2, max_episode_steps=1, autoreset_mode=AutoresetMode.DISABLED)
        env.reset(seed=1)
        actions = np.zeros(env.action_space.shape, dtype=np.float32)
        env.step(actions)
        with self.assertRaisesRegex(ValueError, "reset_mask"):
            env.step(actions)
        env.reset(options={"reset_mask": np.array([True, True])})
        env.step(actions)

    def test_observations_and_rewards_have_the_spaces_shapes(self):
        env = make("PickAndPlace", 2, observation="pixels", size=(32, 24), depth=True, render_mode="rgb_array")
        observations, _ = env.reset(seed=1)
        self.assertTrue(env.observation_space.contains(observations))
        observations, rewards, *_ = env.step(env.action_space.sample())
        self.assertTrue(env.observation_space.contains(observations))
        self.assertEqual(rewards.shape, (2,))
        self.assertEqual([picture.shape for picture in env.render()], [(480, 640, 3)] * 2)


if __name__ == "__main__":
    unittest.main()
