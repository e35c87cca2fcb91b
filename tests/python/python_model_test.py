"""panda_twin.model: the reference figures of tests/data, identities of rigid bodies, shapes, and the GIL."""

import json
import pathlib
import threading
import time
import unittest

import numpy as np

from panda_twin import model

DATA = json.loads((pathlib.Path(__file__).parents[1] / "data/model_reference.json").read_text())
DIGITS = 1e-9  # how far the reference's twelve digits reach


def configurations(count, seed=1):
    return np.random.default_rng(seed).uniform(model.Q_MIN, model.Q_MAX, (count, 7))


def load_of(sample):
    load = DATA["loads"][sample["load"]]
    return {} if load is None else {"mass": load["m"], "centre": load["F_x_C"], "inertia": np.reshape(load["I"], (3, 3)).T}


class Reference(unittest.TestCase):
    def test_dynamics(self):
        for sample in DATA["samples"]:
            q, load = sample["q"], load_of(sample)
            np.testing.assert_allclose(model.gravity(q, **load), sample["g"], rtol=0, atol=DIGITS * 100)
            np.testing.assert_allclose(model.coriolis(q, sample["dq"], **load), sample["c"], rtol=0, atol=DIGITS * 100)
            np.testing.assert_allclose(model.mass(q, **load), np.reshape(sample["M"], (7, 7)).T, rtol=0, atol=DIGITS)

    def test_kinematics(self):
        q = np.array([sample["q"] for sample in DATA["samples"]])
        poses = np.array([np.reshape(sample["O_T_F"], (4, 4)).T for sample in DATA["samples"]])
        jacobians = np.array([np.reshape(sample["O_J_F"], (7, 6)).T for sample in DATA["samples"]])
        np.testing.assert_allclose(model.fk(q, "flange"), poses, rtol=0, atol=DIGITS)
        np.testing.assert_allclose(model.jacobian(q, "flange"), jacobians, rtol=0, atol=DIGITS)

    def test_the_hand_is_the_robots(self):
        self.assertEqual(model.HAND["mass"], 0.73)
        turn = np.cos(np.pi / 4)
        np.testing.assert_allclose(model.F_T_HAND, [[turn, turn, 0, 0], [-turn, turn, 0, 0], [0, 0, 1, 0.1034], [0, 0, 0, 1]],
                                   atol=1e-12)


class Identities(unittest.TestCase):
    def test_the_jacobian_is_the_derivative_of_the_pose(self):
        step = 1e-6
        q = configurations(20)
        for frame in ("joint4", "flange", "EE"):
            J = model.jacobian(q, frame)
            for j in range(7):
                ahead, behind = q.copy(), q.copy()
                ahead[:, j] += step
                behind[:, j] -= step
                slope = (model.fk(ahead, frame) - model.fk(behind, frame)) / (2 * step)
                np.testing.assert_allclose(J[:, :3, j], slope[:, :3, 3], atol=1e-8)
                spin = slope[:, :3, :3] @ model.fk(q, frame)[:, :3, :3].swapaxes(1, 2)
                np.testing.assert_allclose(J[:, 3:, j], np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], 1), atol=1e-8)

    def test_the_body_jacobian_is_the_same_twist_in_the_frames_axes(self):
        q = configurations(20)
        R = model.fk(q)[:, :3, :3].swapaxes(1, 2)
        J, body = model.jacobian(q), model.jacobian(q, axes="body")
        np.testing.assert_allclose(body[:, :3], R @ J[:, :3], atol=1e-12)
        np.testing.assert_allclose(body[:, 3:], R @ J[:, 3:], atol=1e-12)

    def test_a_point_load_weighs_by_the_jacobian(self):
        q = configurations(20)
        centre = np.array([0.01, -0.02, 0.1034])
        F_T_C = np.eye(4)
        F_T_C[:3, 3] = centre
        J = model.jacobian(q, F_T_EE=F_T_C)[:, :3]
        loaded = model.gravity(q, mass=2.0, centre=centre) - model.gravity(q)
        np.testing.assert_allclose(loaded, 2.0 * 9.81 * J[:, 2], atol=1e-12)
        np.testing.assert_allclose(model.mass(q, mass=2.0, centre=centre) - model.mass(q), 2.0 * J.swapaxes(1, 2) @ J, atol=1e-12)

    def test_coriolis_is_half_the_change_of_kinetic_energy(self):
        """dq' c(q, dq) = dq' (dM/dt) dq / 2, as dM/dt - 2 C is skew-symmetric."""
        q, dq, step = configurations(20), np.random.default_rng(2).normal(size=(20, 7)), 1e-6
        for figures in ("robot", "plant"):
            rate = (model.mass(q + step * dq, figures=figures) - model.mass(q - step * dq, figures=figures)) / (2 * step)
            power = np.einsum("ni,ni->n", dq, model.coriolis(q, dq, figures=figures))
            np.testing.assert_allclose(power, np.einsum("ni,nij,nj->n", dq, rate, dq) / 2, atol=1e-6)

    def test_gravity_follows_its_direction(self):
        q = configurations(5)
        np.testing.assert_allclose(model.gravity(q, g_earth=(0, 0, 9.81)), -model.gravity(q), atol=1e-12)
        self.assertGreater(np.abs(model.gravity(q, g_earth=(9.81, 0, 0))[:, 0]).max(), 1)


class InverseKinematics(unittest.TestCase):
    def test_every_solution_reaches_the_pose_and_the_one_it_came_from_is_there(self):
        q = configurations(200)
        T = model.fk(q)
        solutions = model.ik(T, q[:, 6])
        self.assertEqual(solutions.shape, (200, 8, 7))
        for i in range(200):
            found = solutions[i][~np.isnan(solutions[i, :, 0])]
            np.testing.assert_allclose(model.fk(found), np.broadcast_to(T[i], (len(found), 4, 4)), atol=1e-9)
            self.assertLess(np.abs(found - q[i]).max(axis=1).min(), 1e-6)
            self.assertTrue(np.all((model.Q_MIN <= found) & (found <= model.Q_MAX)))

    def test_one_pose_gives_its_solutions_alone(self):
        q = np.array([0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4])
        within, all_of_them = model.ik(model.fk(q)), model.ik(model.fk(q), within_limits=False)
        self.assertEqual(within.shape[1:], (7,))
        self.assertTrue(1 <= len(within) < len(all_of_them) <= 8)
        flange = model.ik(model.fk(q, "flange"), F_T_EE=np.eye(4))
        np.testing.assert_allclose(flange, within, atol=1e-9)

    def test_one_pose_and_many_angles(self):
        T = model.fk([0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4])
        angles = np.linspace(-2.8, 2.8, 29)
        solutions = model.ik(T, angles)
        self.assertEqual(solutions.shape, (29, 8, 7))
        there = ~np.isnan(solutions[..., 0])
        self.assertTrue(there.any())
        np.testing.assert_array_equal(solutions[..., 6][there], np.broadcast_to(angles[:, None], (29, 8))[there])

    def test_a_pose_out_of_reach_has_none(self):
        T = model.fk(np.zeros(7))
        T[:3, 3] = (2, 0, 0)
        self.assertEqual(model.ik(T).shape, (0, 7))


class Shapes(unittest.TestCase):
    FUNCTIONS = (model.gravity, model.mass, model.jacobian, model.fk, lambda q: model.coriolis(q, 0.1 * np.asarray(q)))

    def test_rows_are_what_each_gives_alone(self):
        q = configurations(7)
        for function in self.FUNCTIONS:
            rows = function(q)
            for i in range(7):
                np.testing.assert_array_equal(rows[i], function(q[i]))
            self.assertEqual(function(q[:0]).shape, (0, *rows.shape[1:]))
            np.testing.assert_array_equal(function(np.asfortranarray(q)), rows)
            np.testing.assert_array_equal(function(q.tolist()), rows)

    def test_wrong_ones_are_refused(self):
        q = np.zeros(7)
        for call, says in ((lambda: model.gravity(q[:6]), r"q has shape \(6,\); it must be \(7,\) or \(n, 7\)"),
                           (lambda: model.mass(np.zeros((2, 2, 7))), "q has shape"),
                           (lambda: model.fk(q, "wrist"), "none of joint1 to joint7, flange and EE"),
                           (lambda: model.jacobian(q, axes="world"), "neither base nor body"),
                           (lambda: model.gravity(q, figures="real"), "neither robot nor plant"),
                           (lambda: model.gravity(q, mass=-1), "at least 0 kg"),
                           (lambda: model.gravity(q, mass=1, centre=(0, 0)), "centre has shape"),
                           (lambda: model.fk(q, F_T_EE=np.eye(3)), "F_T_EE has shape"),
                           (lambda: model.ik(2 * np.eye(4)), "must be a rotation")):
            with self.assertRaisesRegex(ValueError, says):
                call()


class Gil(unittest.TestCase):
    def test_other_threads_run_meanwhile(self):
        q = np.tile(configurations(1000), (300, 1))
        computing = threading.Thread(target=model.mass, args=(q,))
        computing.start()
        turns = 0
        while computing.is_alive():
            time.sleep(1e-4)
            turns += 1
        self.assertGreater(turns, 20, "each takes 0.1 ms; the batch some 100 ms")


if __name__ == "__main__":
    unittest.main()
