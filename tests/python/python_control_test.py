"""A law that is called once a cycle: interfaces, times, refusals, exceptions, and its cost."""

import time
import traceback
import unittest

import numpy as np

import panda_twin as pt

REST = [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]
IDEAL = f"""name: ideal
plant: {{kind: ideal}}
robot: {{q_start: {{unit: rad, values: {REST}}}}}
"""
MUJOCO = f"""name: mujoco
robot: {{q_start: {{unit: rad, values: {REST}}}}}
"""
RAW = {"generator": "none", "limiter": True, "rate_matching": False}


class Interfaces(unittest.TestCase):
    def test_torques_hold_the_arm(self):
        with pt.Session(MUJOCO) as session:
            goal = session.state.q + 0.05
            kp, kd = np.full(7, 100.0), np.full(7, 20.0)
            modes = set()

            def law(state, dt):
                modes.add(state.controller_mode)
                return pt.Torques(kp * (goal - state.q) - kd * state.dq)

            result = session.control(law, until=3.0)
            self.assertEqual(result.end, "success")
            self.assertIn("external", modes)
            np.testing.assert_allclose(session.state.q, goal, atol=0.02)
            self.assertAlmostEqual(result.ended - result.begun, 3.0, delta=0.2)

    def test_positions_follow_a_law_until_it_has_finished(self):
        with pt.Session(IDEAL) as session:
            start, spent = session.state.q, 0.0

            def law(state, dt):
                nonlocal spent
                spent += dt
                q = start.copy()
                q[0] += 0.1 * (1 - np.cos(np.pi * min(spent, 2.0) / 2.0))
                return pt.JointPositions(q, finished=spent >= 2.0)

            session.control(law, tick=RAW)
            self.assertAlmostEqual(session.state.q[0], start[0] + 0.2, places=4)

    def test_velocities(self):
        with pt.Session(IDEAL) as session:
            spent = 0.0

            def law(state, dt):
                nonlocal spent
                spent += dt
                speed = 0.1 * np.sin(np.pi * min(spent, 2.0) / 2.0) ** 2
                return pt.JointVelocities([0, 0, 0, 0, 0, 0, speed], spent >= 2.0)

            session.control(law, tick=RAW)
            self.assertAlmostEqual(session.state.q[6], REST[6] + 0.1, delta=2e-3)

    def test_poses(self):
        with pt.Session(IDEAL) as session:
            start, spent = session.state.O_T_EE_d, 0.0

            def law(state, dt):
                nonlocal spent
                spent += dt
                pose = start.copy()
                pose[2, 3] -= 0.025 * (1 - np.cos(np.pi * min(spent, 2.0) / 2.0))
                return pt.CartesianPose(pose, finished=spent >= 2.0)

            session.control(law, tick=RAW)
            way = session.state.O_T_EE[:3, 3] - start[:3, 3]
            np.testing.assert_allclose(way, [0, 0, -0.05], atol=1e-3)

    def test_twists(self):
        with pt.Session(IDEAL) as session:
            start, spent = session.state.O_T_EE_d, 0.0

            def law(state, dt):
                nonlocal spent
                spent += dt
                speed = 0.05 * np.sin(np.pi * min(spent, 2.0) / 2.0) ** 2
                return pt.CartesianVelocities([0, speed, 0, 0, 0, 0], finished=spent >= 2.0)

            session.control(law, tick=RAW)
            way = session.state.O_T_EE[:3, 3] - start[:3, 3]
            np.testing.assert_allclose(way, [0, 0.05, 0], atol=2e-3)


class Calls(unittest.TestCase):
    def test_come_once_a_cycle_with_the_time_between(self):
        with pt.Session(IDEAL) as session:
            seen = []

            def law(state, dt):
                seen.append((state.message_id, dt))
                return pt.Torques([0.0] * 7)

            session.control(law, until=0.5)
        self.assertEqual(seen[0], (0, 0.0))
        ids = [message_id for message_id, _ in seen[1:]]
        self.assertEqual(ids, list(range(ids[0], ids[0] + 500)))
        self.assertEqual({round(dt, 9) for _, dt in seen[1:]}, {0.001})

    def test_repeat_to_the_bit(self):
        def run():
            with pt.Session(MUJOCO, seed=3) as session:
                session.control(lambda state, dt: pt.Torques(-10 * state.dq), until=0.5)
            return session.states_hash

        self.assertEqual(run(), run())

    def test_a_states_values_stay(self):
        with pt.Session(MUJOCO) as session:
            states = []

            def law(state, dt):
                states.append(state)
                return pt.Torques([0.2] * 7)

            session.control(law, until=0.2)
        self.assertEqual(len({state.message_id for state in states}), len(states))
        self.assertGreater(np.abs(states[-1].q - states[0].q).max(), 0)

    def test_may_not_use_the_session(self):
        with pt.Session(IDEAL) as session:
            with self.assertRaisesRegex(RuntimeError, "in use"):
                session.control(lambda state, dt: session.state, until=1.0)


class Refusals(unittest.TestCase):
    def refused(self, error, text, values):
        """The law is well for 100 calls, then returns what `values` gives."""
        with pt.Session(IDEAL) as session:
            calls = 0

            def law(state, dt):
                nonlocal calls
                calls += 1
                return values() if calls > 100 else pt.Torques(np.zeros(7))

            with self.assertRaisesRegex(error, text):
                session.control(law, until=1.0)
            self.assertEqual(calls, 101)
            self.assertEqual(session.state.robot_mode, "Idle")
            goal = list(REST)
            goal[0] += 0.1
            session.reset()
            self.assertTrue(session.move(pt.Trajectory([REST, goal])).succeeded)

    def test_what_is_no_command(self):
        self.refused(TypeError, "the law returned list", lambda: [0.0] * 7)
        self.refused(TypeError, "the law returned NoneType", lambda: None)
        self.refused(TypeError, "JointPositions after Torques", lambda: pt.JointPositions(REST))

    def test_what_is_no_seven_finite_numbers(self):
        self.refused(ValueError, r"Torques: tau_J, Nm: has shape \(6,\)", lambda: pt.Torques([0] * 6))
        self.refused(ValueError, "must be finite", lambda: pt.Torques([float("nan")] * 7))
        self.refused(TypeError, "expected 7 numbers", lambda: pt.Torques(["a"] * 7))
        self.refused(ValueError, "rigid", lambda: pt.CartesianPose(np.ones((4, 4))))
        self.refused(ValueError, r"\(4, 4\)", lambda: pt.CartesianPose(np.eye(3)))

    def test_an_exception_comes_out_as_it_was_raised(self):
        class Own(Exception):
            pass

        raised = Own("x")

        def values():
            raise raised

        with pt.Session(IDEAL) as session:
            calls = 0

            def law(state, dt):
                nonlocal calls
                calls += 1
                return values() if calls > 100 else pt.Torques(np.zeros(7))

            try:
                session.control(law, until=1.0)
                self.fail("nothing was raised")
            except Own as error:  # assertRaises drops the traceback
                self.assertIs(error, raised)
                frames = [frame.name for frame in traceback.extract_tb(error.__traceback__)]
            self.assertEqual(frames[-2:], ["law", "values"])
            self.assertEqual(session.state.robot_mode, "Idle")
            self.assertEqual(calls, 101)

    def test_before_the_motion(self):
        with pt.Session(IDEAL) as session:
            with self.assertRaises(ZeroDivisionError):
                session.control(lambda state, dt: 1 / dt, until=1.0)
            self.assertEqual(session.time, 0)
            zero = lambda state, dt: pt.Torques([0] * 7)  # noqa: E731
            with self.assertRaisesRegex(ValueError, "until, s, is -1; it must lie in"):
                session.control(zero, until=-1)
            with self.assertRaisesRegex(ValueError, "generatr"):
                session.control(zero, until=1, tick={"generatr": "none"})
            with self.assertRaisesRegex(ValueError, "viability"):
                session.control(zero, until=1, tick={"viability": 3})
            with self.assertRaises(TypeError):
                session.control(None, until=1)

    def test_commands_hold_what_they_were_given(self):
        command = pt.JointPositions(REST)
        self.assertFalse(command.finished)
        np.testing.assert_array_equal(command.q, REST)
        command.q = np.array(REST)[::-1]
        command.finished = True
        np.testing.assert_array_equal(command.q, REST[::-1])
        pose = np.eye(4)
        pose[:3, 3] = [1, 2, 3]
        np.testing.assert_array_equal(pt.CartesianPose(np.asfortranarray(pose)).O_T_EE, pose)


class Cost(unittest.TestCase):
    def test_of_a_call(self):
        """Prints what a call of the law adds to a cycle; no machine's speed is judged."""
        rest = pt.Trajectory([REST, [REST[0] + 1e-5, *REST[1:]]], duration=10.0)
        q = np.array(REST)
        constant = pt.JointPositions(q)
        laws = {
            "that returns a constant": lambda state, dt: constant,
            "that makes a command": lambda state, dt: pt.JointPositions(q),
            "that reads a state": lambda state, dt: pt.JointPositions(q + 0 * (q - state.q)),
        }

        def cycle(call):
            """Least processor time of a cycle, us."""
            least = np.inf
            for _ in range(5):
                with pt.Session(IDEAL + "loop: bare\ntick: {generator: none}\n") as session:
                    begun = time.thread_time()
                    call(session)
                    least = min(least, (time.thread_time() - begun) / session.time * 1e3)
            return least

        bare = cycle(lambda session: session.move(rest))
        print(f"cycle of the bare loop, in C++: {bare:.2f} us")
        for name, law in laws.items():
            with_law = cycle(lambda session, law=law: session.control(law, until=10.0))
            print(f"with a law {name}: {with_law:.2f} us, {with_law - bare:+.2f} us")
            self.assertGreater(with_law, 0)


if __name__ == "__main__":
    unittest.main()
