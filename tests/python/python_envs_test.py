"""The environments: what Gymnasium expects of them, repeatability, and that actions meet the robot's own limits."""

import inspect
import os
import pathlib
import subprocess
import sys
import unittest
import warnings

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env

import panda_twin.envs
from panda_twin.envs import tasks

SOURCE = pathlib.Path(__file__).resolve().parents[2]
NAMES = ("Reach", "Push", "PickAndPlace", "Peg", "Wipe")
INTERFACES = ("cartesian_pose", "joint_position", "joint_velocity", "torque")


def make(task, **options):
    return gymnasium.make(f"PandaTwin/{task}-v0", **options)


def make_vec(task, **options):
    return gymnasium.make_vec(f"PandaTwin/{task}-v0", num_envs=2, **options)


def same(a, b):
    """Whether two observations have the same bytes."""
    return a.keys() == b.keys() and all(a[key].tobytes() == b[key].tobytes() for key in a)


def wander(env, seed, steps, scale=1.0):
    """Observations and rewards under random actions."""
    rng = np.random.default_rng(seed)
    observation, info = env.reset(seed=seed)
    history = [observation]
    rewards = []
    for _ in range(steps):
        action = rng.uniform(-scale, scale, env.action_space.shape).astype(np.float32)
        observation, reward, terminated, truncated, info = env.step(action)
        history.append(observation)
        rewards.append(reward)
        if terminated or truncated:
            observation, info = env.reset()
            history.append(observation)
    return history, rewards, info


def lead_to(env, point, steps, fingers=None, speed=1.0):
    """Leads the end effector to a point by actions; returns the last step's result."""
    base = env.unwrapped
    for _ in range(steps):
        position = base._cell.targets[0, :3]
        way = (np.asarray(point) - position) / (0.5 * base._cell._period)
        action = np.clip(way, -speed, speed)
        if fingers is not None:
            action = np.append(action, fingers)
        result = env.step(action)
    return result


class Interface(unittest.TestCase):
    def test_every_task_passes_gymnasiums_checker_in_both_kinds_of_observation(self):
        for name in NAMES:
            for more in ({}, {"observation": "pixels", "size": (48, 32), "depth": True}):
                with self.subTest(task=name, **more), warnings.catch_warnings():
                    warnings.simplefilter("error")
                    # Goals and torques have no bounds, as those of gymnasium-robotics.
                    warnings.filterwarnings("ignore", message=".*(infinity|maximum|minimum).*")
                    env = make(name, render_mode="rgb_array", **more)
                    check_env(env.unwrapped)
                    env.close()

    def test_importing_the_package_registers(self):
        code = "import panda_twin, gymnasium; gymnasium.spec('PandaTwin/Wipe-v0')"
        subprocess.run([sys.executable, "-c", code], check=True, env=os.environ)

    def test_gymnasium_imports_the_package_when_the_name_says_so(self):
        code = "import gymnasium; gymnasium.make('panda_twin:PandaTwin/Reach-v0').reset(seed=1)"
        subprocess.run([sys.executable, "-c", code], check=True, env=os.environ)

    def test_rewards_take_batches_of_goals(self):
        rng = np.random.default_rng(1)
        for name in NAMES:
            for kind in ("sparse", "dense"):
                env = make(name, reward=kind).unwrapped
                achieved, desired = rng.uniform(0, 0.2, (2, 5, 4, 3))
                rewards = env.compute_reward(achieved, desired, {})
                self.assertEqual(rewards.shape, (5, 4))
                self.assertEqual(rewards[2, 1], env.compute_reward(achieved[2, 1], desired[2, 1], {}))
                self.assertEqual(env.compute_reward(achieved[0, 0], achieved[0, 0], {}), 0)
                self.assertTrue(np.all(rewards <= 0))

    def test_rendering_shows_the_scene_and_moves_with_it(self):
        env = make("PickAndPlace", render_mode="rgb_array")
        env.reset(seed=1)
        first = env.render()
        self.assertEqual((first.shape, first.dtype), ((480, 640, 3), np.uint8))
        self.assertGreater(first.std(), 10)
        for _ in range(10):
            env.step(np.array([1, 0, -1, 1], dtype=np.float32))
        self.assertFalse(np.array_equal(first, env.render()))
        self.assertEqual(env.metadata["render_fps"], 20)

    def test_vectors_take_the_options_of_a_single_environment(self):
        from panda_twin.envs.vector import Options

        one = inspect.signature(panda_twin.envs.PandaEnv).parameters
        self.assertEqual([name for name in one if name != "task"], list(Options.__annotations__))
        many = make_vec("Reach", control_hz=50, reward="dense", observation="pixels", cameras=("overview",), size=(32, 24), depth=True)
        observed, _ = many.reset(seed=1)
        self.assertEqual(observed["overview_depth"].shape, (2, 24, 32, 1))
        self.assertEqual(many.metadata["render_fps"], 50)
        self.assertEqual(panda_twin.envs.PandaVectorEnv.metadata["render_fps"], 20)
        _, rewards, *_ = many.step(many.action_space.sample())
        self.assertTrue(np.all((-1 < rewards) & (rewards < 0)), rewards)

    def test_wrong_options_are_refused_in_words(self):
        for options, words in (
            ({"interface": "telepathy"}, "cartesian_pose"),
            ({"control_hz": 1000}, r"\[5, 100\]"),
            ({"reward": "much"}, "sparse"),
            ({"randomize": {"weather": (0, 1)}}, "load.mass"),
            ({"randomize": {"friction": (0, 1)}}, "needs an object"),
            ({"losses": 2}, "share"),
            ({"viability": -3}, "viability"),
        ):
            with self.subTest(**options), self.assertRaisesRegex(ValueError, words):
                make("Reach", **options)
        env = make("Reach").unwrapped
        with self.assertRaisesRegex(ValueError, "reset"):
            env.step(np.zeros(3))
        env.reset(seed=1)
        with self.assertRaisesRegex(ValueError, "shape"):
            env.step(np.zeros(4))
        with self.assertRaisesRegex(ValueError, "finite"):
            env.step(np.array([np.nan, 0, 0]))


class Repeatability(unittest.TestCase):
    def test_the_same_seed_gives_the_same_bytes_in_one_and_in_two_environments(self):
        for name in NAMES:
            for interface in INTERFACES:
                with self.subTest(task=name, interface=interface):
                    options = {"interface": interface, "losses": 0.02}
                    env = make(name, **options)
                    first, rewards, _ = wander(env, 3, 12, 0.3)
                    second, again, _ = wander(env, 3, 12, 0.3)
                    third, _, _ = wander(make(name, **options), 3, 12, 0.3)
                    self.assertTrue(all(map(same, first, second)) and all(map(same, first, third)))
                    self.assertEqual(rewards, again)
                    other, _, _ = wander(env, 4, 12, 0.3)
                    self.assertFalse(all(map(same, first, other)))

    def test_the_same_seed_gives_the_same_pixels(self):
        env = make("Push", observation="pixels", size=(64, 48), depth=True)
        first, _, _ = wander(env, 5, 3)
        second, _, _ = wander(env, 5, 3)
        self.assertTrue(all(map(same, first, second)))
        self.assertEqual(first[0]["overview"].shape, (48, 64, 3))
        self.assertGreater(first[0]["panda_hand_depth"].max(), 0.05)
        self.assertNotIn("box", first[0])

    def test_observations_share_no_memory(self):
        env = make("Push")
        a, _ = env.reset(seed=1)
        b, _, _, _, info = env.step(env.action_space.sample())
        c, _, _, _, later = env.step(env.action_space.sample())
        for key in a:
            for x, y in ((a, b), (b, c), (a, c)):
                self.assertFalse(np.shares_memory(x[key], y[key]))
        self.assertFalse(np.shares_memory(info["contact_wrench"], later["contact_wrench"]))


class Robot(unittest.TestCase):
    def test_random_actions_never_trip_the_robot_behind_the_viability_filter(self):
        env = make("Reach")
        env.reset(seed=1)
        rng = np.random.default_rng(1)
        for _ in range(300):
            _, _, terminated, _, info = env.unwrapped.step(rng.uniform(-1, 1, 3))
            self.assertFalse(terminated, info)
            self.assertEqual((info["cycles_served"], info["cycles_held"]), (50, 0))
            self.assertGreater(info["margin"], -1e-3)

    def test_without_the_filter_a_reflex_ends_the_episode_and_is_explained(self):
        env = make("Reach", interface="torque", viability=None)
        env.reset(seed=1)
        for _ in range(40):
            _, _, terminated, _, info = env.step(np.array([1, 1, 1, 1, 1, 1, 1], dtype=np.float32))
            if terminated:
                break
        self.assertTrue(terminated)
        self.assertTrue(info["errors"])
        self.assertRegex(info["reflex"], r"joint \d")
        _, info = env.reset()
        self.assertNotIn("reflex", info)
        self.assertEqual(info["errors"], [])

    def test_an_action_moves_the_end_effector_by_what_it_says(self):
        for hz in (10, 20, 100):
            env = make("Reach", control_hz=hz, max_episode_steps=1000)
            observation, _ = env.reset(seed=1)
            before = observation["achieved_goal"]
            steps = hz // 5
            for _ in range(steps):
                env.step(np.array([0.5, 0, 0]))
            for _ in range(hz):
                observation, *_ = env.step(np.zeros(3))
            moved = observation["achieved_goal"] - before
            np.testing.assert_allclose(moved, [0.25 * 0.2, 0, 0], atol=1.5e-3)

    def test_a_goal_is_reached_and_rewarded(self):
        env = make("Reach")
        observation, _ = env.reset(seed=2)
        _, reward, _, _, info = lead_to(env, observation["desired_goal"], 30)
        self.assertTrue(info["is_success"])
        self.assertEqual(reward, 0)

    def test_losses_and_delays_reach_the_link(self):
        env = make("Reach", losses=0.1)
        env.reset(seed=1)
        held = sum(env.step(np.zeros(3))[4]["cycles_held"] for _ in range(40))
        self.assertTrue(280 < held < 480, held)  # 19 % of 2000
        env = make("Reach", delays={"state_delay": {"normal": {"mean": "0.8 ms", "sigma": "0.1 ms"}}})
        env.reset(seed=1)
        held = sum(env.step(np.zeros(3))[4]["cycles_held"] for _ in range(40))
        self.assertTrue(220 < held < 420, held)  # 16 % come less than 0.1 ms before the cycle
        env = make("Reach", delays=SOURCE / "models" / "experiments", losses=0.1)
        env.reset(seed=1)
        held = sum(env.step(np.zeros(3))[4]["cycles_held"] for _ in range(40))
        self.assertTrue(280 < held < 490, held)

    def test_randomisation_is_drawn_from_the_seed_and_reported(self):
        ranges = {"load.mass": (0, 1), "friction": (0.5, 1.5), "object.mass": ("log_uniform", 0.05, 0.5),
                  "delay": ("normal", 0.0002, 0.00001), "loss": lambda rng: 0.05 * rng.random(), "q_start": (-0.02, 0.02)}
        env = make("Push", randomize=ranges)
        _, first = env.reset(seed=1)
        _, other = env.reset(seed=2)
        _, again = env.reset(seed=1)
        self.assertEqual(first["randomized"], again["randomized"])
        self.assertNotEqual(first["randomized"], other["randomized"])
        self.assertTrue(0 <= first["randomized"]["load.mass"] <= 1)
        history, _, _ = wander(env, 9, 10)
        self.assertTrue(all(map(same, history, wander(env, 9, 10)[0])))

    def test_a_heavier_load_changes_what_the_robot_feels(self):
        def force(mass):
            env = make("Reach", randomize={"load.mass": (mass, mass)})
            env.reset(seed=1)
            for _ in range(20):
                *_, info = env.step(np.zeros(3))
            return info["estimated_wrench"][2]

        self.assertAlmostEqual(force(1.0) - force(0.001), 9.81, delta=1.0)


class Tasks(unittest.TestCase):
    def test_a_box_is_pushed(self):
        env = make("Push", max_episode_steps=1000)
        env.reset(seed=1)
        box = env.unwrapped._cell.task.achieved(env.unwrapped._cell.rows)[0]
        lead_to(env, box + (0, -0.08, 0.1), 40)
        lead_to(env, box + (0, -0.08, 0.0), 20)
        observation, _, terminated, _, info = lead_to(env, box + (0, 0.05, 0.0), 60, speed=0.3)
        self.assertFalse(terminated, info)
        self.assertGreater(observation["achieved_goal"][1], box[1] + 0.03)

    def test_a_box_is_picked_and_placed_in_the_air(self):
        env = make("PickAndPlace", max_episode_steps=1000)
        observation, _ = env.reset(seed=1)
        box = observation["achieved_goal"]
        lead_to(env, box + (0, 0, 0.1), 40, 1)
        lead_to(env, box + (0, 0, 0.005), 30, 1)
        lead_to(env, box + (0, 0, 0.005), 20, -1)
        goal = np.array([box[0], box[1], 0.45])
        observation, _, terminated, _, info = lead_to(env, goal, 50, -1)
        self.assertFalse(terminated, info)
        np.testing.assert_allclose(observation["achieved_goal"], goal, atol=0.02)
        self.assertGreater(info["contact_wrench"][2], 0.5)  # it carries the box's weight

    def test_a_peg_goes_into_its_hole(self):
        env = make("Peg", max_episode_steps=1000)
        observation, info = env.reset(seed=1)
        self.assertAlmostEqual(observation["achieved_goal"][2], 0.35, delta=0.003)
        grip = env.unwrapped._cell.targets[0, :3] - observation["achieved_goal"]
        above = observation["desired_goal"] + (0, 0, 0.09)
        lead_to(env, observation["achieved_goal"] + grip + (0, 0, 0.1), 40, speed=0.3)
        observation, *_ = lead_to(env, above + grip, 60, speed=0.3)
        off = (observation["achieved_goal"] - above) * (1, 1, 0)
        grip = grip - off
        lead_to(env, above + grip, 30)
        observation, _, terminated, _, info = lead_to(env, observation["desired_goal"] + grip, 120, speed=0.1)
        self.assertFalse(terminated, info)
        self.assertTrue(info["is_success"], observation["achieved_goal"] - observation["desired_goal"])

    def test_a_table_is_wiped_with_a_force(self):
        env = make("Wipe", max_episode_steps=1000)
        observation, _ = env.reset(seed=1)
        x, y, force = observation["desired_goal"]
        lead_to(env, (x, y, 0.35), 60)
        height = 0.33
        for _ in range(200):
            height -= float(np.clip(1e-4 * (force - observation["achieved_goal"][2]), -2e-3, 1e-3))
            observation, _, terminated, _, info = lead_to(env, (x, y, height), 1)
            self.assertFalse(terminated, info)
        self.assertTrue(info["is_success"], observation["achieved_goal"] - observation["desired_goal"])
        self.assertAlmostEqual(-info["contact_wrench"][2], force, delta=3)

    def test_a_task_of_ones_own(self):
        class Beside(panda_twin.envs.Task):
            scenario = "objects: [{name: box, shape: box, size: [0.05 m, 0.05 m, 0.05 m], on: ground, position: [0.6 m, 0.3 m, 0 m]}]\n"
            q_start = (0.1, -0.19371, 0.0, -1.90879, 0.0, 1.71508, -0.7854)

            def draw(self, rng):
                return panda_twin.envs.Draw(rng.uniform((0.4, 0, 0.4), (0.5, 0.1, 0.5)), {})

            def achieved(self, rows):
                return rows[:, panda_twin.envs.field("position")].copy()

        env = gymnasium.make("PandaTwin/Reach-v0", task=Beside)
        observation, _ = env.reset(seed=3)
        self.assertAlmostEqual(np.arctan2(*observation["achieved_goal"][1::-1]), 0.1, places=3)
        self.assertTrue(((0.4, 0, 0.4) <= observation["desired_goal"]).all() and (observation["desired_goal"] <= (0.5, 0.1, 0.5)).all())
        *_, info = lead_to(env, observation["desired_goal"], 20)
        self.assertTrue(info["is_success"])
        vector = gymnasium.make_vec("PandaTwin/Reach-v0", num_envs=2, task=Beside)
        np.testing.assert_array_equal(vector.reset(seed=3)[0]["desired_goal"][0], observation["desired_goal"])

    def test_fields_name_every_number_of_a_report(self):
        self.assertEqual(tasks.field("q"), slice(0, 7))
        self.assertEqual(tasks.field("is_moving"), slice(tasks.REPORT_SIZE - 1, tasks.REPORT_SIZE))


if __name__ == "__main__":
    unittest.main()
