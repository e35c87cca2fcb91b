#!/usr/bin/env python3
"""Runs the real program on good and bad input: cli_test.py PROGRAM SOURCE_TREE [unittest options].

For every bad input: the exact exit code, exactly one error line, and nothing half-written.
"""

import fcntl
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = "", pathlib.Path()

READY = "[0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]"
MOVED = "[0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]"

SHORT = f"""name: short
plant:
  kind: ideal
link:
  command_loss: 0 %
tick:
  lambda: 0.001
motion:
  trajectory:
    unit: rad
    duration: 1 s
    waypoints:
      - {{q: {READY}}}
      - {{q: {MOVED}}}
render:
  enabled: false
"""


class CliTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_cli_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.out = self.folder / "out"
        self.environment = dict(os.environ, XDG_CACHE_HOME=str(self.folder / "cache"))

    def call(self, *arguments, **options):
        return subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, env=self.environment, capture_output=True, text=True,
                              timeout=120, **options)

    def shell(self, redirected, *arguments):
        """Calls the program with what sh makes of `redirected`, say ">&-"."""
        return subprocess.run(["sh", "-c", f'exec "$0" "$@" {redirected}', PROGRAM, *map(str, arguments)], cwd=self.folder,
                              env=self.environment, capture_output=True, text=True, timeout=120)

    def run_arguments(self, text=SHORT):
        return ["run", self.scenario(text), "--out", self.out, "--data", SOURCE / "models"]

    def scenario(self, text=SHORT):
        path = self.folder / "scenario.yaml"
        path.write_text(text)
        return path

    def run_scenario(self, text=SHORT, *more, models=None):
        return self.call("run", self.scenario(text), "--out", self.out, "--data", models or SOURCE / "models", *more)

    def files(self):
        """What the run left, relative to its folder of results."""
        if not self.out.is_dir():
            return set()
        return {str(p.relative_to(self.out)) for p in self.out.rglob("*") if p.is_file()}

    def assert_error(self, done, code, says):
        """Exactly one error line, which says `says`, and the code."""
        lines = [line for line in done.stderr.splitlines() if "error:" in line]
        self.assertEqual(len(lines), 1, done.stderr)
        self.assertTrue(lines[0].startswith("panda-twin: error: "), lines)
        self.assertIn(says, lines[0])
        self.assertEqual(done.returncode, code, done.stderr)

    def assert_refused(self, done, code, says):
        """An error before the run: nothing was written at all."""
        self.assert_error(done, code, says)
        self.assertEqual(self.files(), set())

    def spoil(self, old, new):
        self.assertIn(old, SHORT)
        return SHORT.replace(old, new, 1)

    def models_copy(self):
        copy = self.folder / "models"
        shutil.copytree(SOURCE / "models", copy)
        return copy


class BadScenario(CliTest):
    def test_unknown_key(self):
        done = self.run_scenario(self.spoil("lambda", "lamda"))
        self.assert_refused(done, 3, 'scenario.yaml:7: tick: unknown key "lamda"; did you mean')

    def test_wrong_unit(self):
        done = self.run_scenario(self.spoil("1 s", "1 Hz"))
        self.assert_refused(done, 3, 'scenario.yaml:11: motion.trajectory.duration: unit "Hz"')

    def test_waypoint_not_a_number(self):
        done = self.run_scenario(self.spoil("[0.1,", "[.nan,"))
        self.assert_refused(done, 3, "scenario.yaml:14: motion.trajectory.waypoints[2].q[1]: ")

    def test_waypoint_outside_the_limits(self):
        done = self.run_scenario(self.spoil("[0.1,", "[2.9,"))
        self.assert_refused(done, 3, "scenario.yaml:14")
        self.assertIn("joint 1", done.stderr)
        self.assertIn("2.8973", done.stderr)

    def test_inadmissible_trajectory(self):
        done = self.run_scenario(self.spoil("1 s", "10 ms"))
        self.assert_refused(done, 3, "trajectory: ")
        self.assertIn("limit", done.stderr)

    def test_unknown_backend(self):
        done = self.run_scenario(SHORT, "--backend", "gazebo")
        self.assert_refused(done, 3, 'backend "gazebo"')
        self.assertIn("mujoco", done.stderr)

    def test_drive_that_does_not_go_with_the_backend(self):
        done = self.run_scenario(SHORT, "--drive", "remote", "--robot", "127.0.0.1")
        self.assert_refused(done, 3, 'drive "remote" repeats backend fci: write backend: fci and no drive')
        for drive in ("lockstep", "realtime"):
            done = self.run_scenario(SHORT, "--backend", "fci", "--robot", "127.0.0.1:9", "--drive", drive)
            self.assert_refused(done, 3, f"--drive {drive} contradicts backend fci, whose robot keeps its own time")

    def test_remote_robot_without_address(self):
        done = self.run_scenario(SHORT, "--backend", "fci")
        self.assert_refused(done, 3, "--robot HOST")

    def test_a_capture_that_is_a_directory_is_refused_at_the_start(self):
        capture = self.folder / "captures"
        capture.mkdir()
        there = self.run_scenario(SHORT, "--backend", "fci", "--robot", "127.0.0.1:9", "--capture", capture)
        served = self.call("serve", "--port", "0", "--hand-port", "0", "--for", "0.1", "--capture", capture,
                           "--data", SOURCE / "models")
        for done in (there, served):
            self.assertEqual(done.returncode, 4, done.stderr)
            self.assertIn(f"error: cannot write {capture}: it is a directory", done.stderr)
            self.assertNotIn("serves", done.stdout)
            self.assertNotIn("reach", done.stdout)
        self.assertFalse(capture.with_name("captures.partial").exists())

    def test_decode_names_a_classic_capture_and_what_converts_it(self):
        capture = self.folder / "session.pcap"
        capture.write_bytes(bytes.fromhex("d4c3b2a1") + bytes(20))
        self.assert_refused(self.call("decode", capture), 3, f"editcap -F pcapng {capture} {capture}ng")

    def test_address_of_a_robot_that_is_in_this_process(self):
        done = self.run_scenario(SHORT, "--robot", "127.0.0.1")
        self.assert_refused(done, 3, "--backend fci")

    def test_addresses_and_times_of_a_robot_that_are_none(self):
        for flags, what in ((("--robot", "host:0"), "port"), (("--robot", ":1337"), "names no host"),
                            (("--robot", "127.0.0.1", "--robot-time", "moon"), "wall")):
            with self.subTest(flags=flags):
                done = self.run_scenario(SHORT, "--backend", "fci", *flags)
                self.assert_refused(done, 3, what)

    def test_speed_out_of_range(self):
        for speed in ("0", "1.5", "nan"):
            with self.subTest(speed=speed):
                done = self.run_scenario(SHORT, "--max-speed", speed)
                self.assert_refused(done, 3, "--max-speed")

    def test_processors_in_lockstep(self):
        done = self.run_scenario(SHORT, "--ext-cpu", "0")
        self.assert_refused(done, 3, "--drive realtime")

    def test_processor_that_is_not_there(self):
        done = self.run_scenario(SHORT, "--drive", "realtime", "--ext-cpu", "4000")
        self.assert_error(done, 3, "4000")

    def test_clock_that_drifts_too_much(self):
        done = self.run_scenario(SHORT, "--clock-ppm", "2000")
        self.assert_refused(done, 3, "robot.clock_drift")

    def test_missing_file(self):
        done = self.call("run", "nowhere.yaml", "--out", self.out)
        self.assert_refused(done, 3, "nowhere.yaml")

    def test_folder_instead_of_a_file(self):
        done = self.call("run", self.folder, "--out", self.out)
        self.assert_refused(done, 3, str(self.folder))

    def test_leaves_earlier_results_alone(self):
        self.assertEqual(self.run_scenario().returncode, 0)
        before = {name: (self.out / name).read_bytes() for name in self.files()}
        self.assert_error(self.run_scenario(self.spoil("1 s", "10 ms")), 3, "trajectory: ")
        self.assertEqual({name: (self.out / name).read_bytes() for name in self.files()}, before)


class BadData(CliTest):
    MUJOCO = SHORT.replace("kind: ideal", "kind: mujoco")

    def test_truncated_urdf(self):
        models = self.models_copy()
        urdf = models / "robots" / "panda" / "panda.urdf"
        urdf.write_bytes(urdf.read_bytes()[: urdf.stat().st_size // 2])
        self.assert_refused(self.run_scenario(self.MUJOCO, models=models), 3, "panda.urdf")

    def test_missing_mesh(self):
        (self.folder / "package" / "meshes").mkdir(parents=True)
        done = self.run_scenario(self.MUJOCO, "--meshes", self.folder / "package")
        self.assert_refused(done, 3, "mesh")

    def test_missing_mesh_package(self):
        done = self.run_scenario(self.MUJOCO, "--meshes", self.folder / "nowhere")
        self.assert_refused(done, 3, "--meshes")
        self.environment["PANDA_TWIN_MESHES"] = str(self.folder / "elsewhere")
        self.assert_refused(self.run_scenario(self.MUJOCO), 3, "elsewhere")
        self.assert_refused(self.run_scenario(self.MUJOCO, "--meshes", self.folder / "nowhere"), 3, "nowhere")

    def test_missing_scene(self):
        done = self.run_scenario("scene: scenes/nowhere.xml\n" + self.MUJOCO)
        self.assert_refused(done, 3, "nowhere.xml")

    def test_body_to_follow_that_the_model_lacks(self):
        text = self.MUJOCO.replace("enabled: false", "camera: {track: no_body}")
        self.assertNotEqual(text, self.MUJOCO)
        for done in (self.run_scenario(text), self.call("validate", self.scenario(text), "--data", SOURCE / "models")):
            self.assert_refused(done, 3, 'scenario.yaml: render: the model has no body named "no_body"')

    def test_missing_models(self):
        done = self.run_scenario(SHORT, models=self.folder)
        self.assert_refused(done, 3, "--data")


class BadEnvironment(CliTest):
    def test_output_folder_below_a_file(self):
        (self.folder / "file").write_text("")
        self.out = self.folder / "file" / "out"
        self.assert_refused(self.run_scenario(), 4, "cannot be written")

    def test_output_folder_that_is_a_file(self):
        self.out.write_text("")
        self.assert_refused(self.run_scenario(), 4, "cannot be written")

    def test_output_folder_without_permission(self):
        self.out.mkdir()
        self.out.chmod(0o500)
        self.folder.chmod(0o755)
        nobody = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}  # root may write anywhere
        try:
            self.assert_refused(self.call(*self.run_arguments(), **nobody), 4, "cannot be written")
        except PermissionError:
            self.skipTest("another user cannot run the program here")

    def test_plots_that_are_a_file(self):
        self.out.mkdir()
        (self.out / "plots").write_text("mine")
        self.assert_error(self.run_scenario(), 4, "plots: cannot be written (not a folder)")
        self.assertEqual(self.files(), {"plots"})
        self.assertEqual((self.out / "plots").read_text(), "mine")

    def test_folder_another_run_writes_into(self):
        self.out.mkdir()
        descriptor = os.open(self.out, os.O_RDONLY)
        self.addCleanup(os.close, descriptor)
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        done = self.run_scenario()
        self.assert_refused(done, 4, f"another run writes into {self.out}; wait for it")
        fcntl.flock(descriptor, fcntl.LOCK_UN)
        self.assertEqual(self.run_scenario().returncode, 0)

    def test_run_locks_its_folder_while_it_moves(self):
        process = subprocess.Popen([PROGRAM, *map(str, self.run_arguments(SHORT.replace("1 s", "60 s")))], cwd=self.folder,
                                   env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        process.stdout.readline()  # the first tenth is done
        process.send_signal(signal.SIGSTOP)  # so that the motion lasts as long as this needs
        try:
            self.assert_error(self.run_scenario(), 4, "another run writes into")
            self.assertIn("run.mcap.partial", self.files())
        finally:
            process.send_signal(signal.SIGINT)
            process.send_signal(signal.SIGCONT)
            process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)

    def test_missing_gnuplot(self):
        self.environment["PATH"] = str(self.folder)
        self.assert_refused(self.run_scenario(), 4, "apt-get install gnuplot-nox")


class BadUsage(CliTest):
    def test_usage(self):
        for arguments in [[], ["fly"], ["run"], ["run", "a.yaml", "--sead", "3"],
                          ["run", "a.yaml", "--seed", "-1"], ["run", "a.yaml", "--seed", "x"],
                          ["run", "a.yaml", "--seed", "0x10"], ["run", "a.yaml", "--seed", ""],
                          ["run", "a.yaml", "--seed", "18446744073709551616"]]:
            with self.subTest(arguments=arguments):
                self.assert_refused(self.call(*arguments), 2, "see panda-twin --help")

    def test_command_that_is_none_is_named(self):
        for arguments, says in [(["rnu", "x"], 'there is no command "rnu"; did you mean "run"?'), (["fly"], 'there is no command "fly"; see'),
                                (["video", "aprove", "a"], 'there is no command "aprove"; did you mean "approve"?'),
                                (["video"], "A subcommand is required")]:
            with self.subTest(arguments=arguments):
                self.assert_refused(self.call(*arguments), 2, says)

    def test_flag_that_is_none_is_named(self):
        for arguments, says in [(["run", "--sead", "3", "a.yaml"], "there is no flag --sead; did you mean --seed?; see"),
                                (["run", "a.yaml", "--no-vido"], "there is no flag --no-vido; did you mean --no-video?"),
                                (["run", "a.yaml", "--xyzzy=1"], "there is no flag --xyzzy; see")]:
            with self.subTest(arguments=arguments):
                self.assert_refused(self.call(*arguments), 2, says)

    def test_export_of_what_is_no_log(self):
        (self.folder / "run.mcap").write_bytes(b"not a log")
        done = self.call("export", self.folder / "run.mcap", "--out", self.out)
        self.assert_refused(done, 3, "run.mcap")

    def test_export_of_what_is_no_file(self):
        os.mkfifo(self.folder / "pipe")
        for name in ["nope.mcap", ".", "pipe"]:
            with self.subTest(name=name):
                done = self.call("export", name, "--out", self.out)
                self.assert_refused(done, 3, f"cannot read {name}: ")

    def test_explain_of_what_is_no_log(self):
        (self.folder / "run.mcap").write_bytes(b"not a log")
        (self.folder / "empty").mkdir()
        for name, says in [("run.mcap", "run.mcap"), ("nope.mcap", "cannot read nope.mcap: "),
                           ("empty", "empty holds no run.mcap")]:
            with self.subTest(name=name):
                self.assert_refused(self.call("explain", name, "--out", self.out), 3, says)

    def test_explain_wants_a_log_or_the_errors(self):
        for arguments in [[], ["a.mcap", "--errors"], ["a.mcap", "b.mcap"], ["--errors", "--modes"]]:
            with self.subTest(arguments=arguments):
                self.assert_refused(self.call("explain", *arguments), 2, "see panda-twin --help")

    def test_explain_prints_every_error(self):
        done = self.call("explain", "--errors")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        titles = [line for line in done.stdout.splitlines() if line.startswith("## ")]
        self.assertEqual([title.split()[1] for title in titles], [str(i) for i in range(41)])

    def test_explain_prints_what_every_mode_grants(self):
        done = self.call("explain", "--modes")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in done.stdout.splitlines()]
        self.assertEqual(rows[0][1:], ["Other", "Idle", "Move", "Guiding", "Reflex", "User stopped",
                                       "Automatic error recovery"])
        self.assertEqual(len(rows), 2 + 12)
        move = next(row for row in rows if row[0] == "Move")
        self.assertEqual([cell for cell in move[1:] if cell != "refused"], ["granted at rest"])

    def test_help_of_a_command_is_about_it(self):
        self.assertIn("Start here:", self.call("--help").stdout)
        for command in ["run", "validate", "check", "export", "explain"]:
            self.assertNotIn("Start here:", self.call(command, "--help").stdout, command)

    def test_help_and_version(self):
        for arguments in [["--help"], ["run", "--help"], ["--version"]]:
            done = self.call(*arguments)
            self.assertEqual(done.returncode, 0)
            self.assertEqual(done.stderr, "")
        self.assertIn("MuJoCo 2.2.2", self.call("--version").stdout)


class GoodRun(CliTest):
    RESULTS = {"run.mcap", "scenario.yaml", "summary.json", "timing.json", "plots/joints.svg",
               "plots/tracking.svg", "plots/velocities.svg", "plots/jerk.svg", "plots/served.svg", "plots/viability.svg"}

    def test_writes_its_results_whole(self):
        done = self.run_scenario()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, "")
        self.assertEqual(self.files(), self.RESULTS)
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual(summary["outcome"], "success")
        self.assertLess(summary["final_error_rad"], 1e-3)
        json.loads((self.out / "timing.json").read_text())
        self.assertIn("final error", done.stdout)
        # The arm follows its plan, behind by the chain's delay and what the reference generator has yet to make up for.
        self.assertLess(summary["deviation_rad"], 0.1)
        self.assertGreater(summary["deviation_rad"], 0)
        self.assertIn("deviation", done.stdout)
        self.assertIn("100 %", done.stdout)

    def test_says_what_the_hand_did(self):
        self.assertEqual(self.run_scenario().returncode, 0)
        self.assertIsNone(json.loads((self.out / "summary.json").read_text())["hand"])
        hand = """hand:
  - {at: 0 s, move: {width: 70 mm, speed: 0.1 m/s}}
  - {at: 0.5 s, grasp: {width: 50 mm, speed: 0.1 m/s, force: 40 N}}
  - {at: 1.9 s, move: {width: 70 mm, speed: 0.001 m/s}}
"""
        done = self.run_scenario(SHORT.replace("duration: 1 s", "duration: 2 s") + hand)
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads((self.out / "summary.json").read_text())["hand"]
        self.assertEqual([(c["command"], c["result"]) for c in told["commands"]],
                         [("Move", "success"), ("Grasp", "unsuccessful"), ("Move", "running")])
        self.assertEqual([c["is_grasped"] for c in told["commands"]], [False, False, None])
        self.assertAlmostEqual(told["commands"][0]["width_m"], 0.07, delta=1e-3)
        self.assertFalse(told["is_grasped"])
        self.assertIn("Grasp unsuccessful", done.stdout)
        self.assertEqual(self.call("export", self.out / "run.mcap", "--out", self.folder / "csv").returncode, 0)
        events = (self.folder / "csv" / "events.csv").read_text()
        for line in ["Move started", "Move: success", "Grasp: unsuccessful"]:
            self.assertIn(line, events)

    def test_quiet_prints_nothing(self):
        done = self.run_scenario(SHORT, "--quiet")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    def test_resolved_scenario_gives_the_same_run(self):
        self.assertEqual(self.run_scenario().returncode, 0)
        first = (self.out / "run.mcap").read_bytes()
        again = self.folder / "again"
        done = self.call("run", self.out / "scenario.yaml", "--out", again, "--data",
                         SOURCE / "models")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((again / "run.mcap").read_bytes(), first)

    def test_removes_results_of_an_earlier_run(self):
        self.out.mkdir()
        for name in ["video.mp4", "run.mcap.partial", "contact_sheet.png.partial"]:
            (self.out / name).write_text("old")
        self.assertEqual(self.run_scenario().returncode, 0)
        self.assertEqual(self.files(), self.RESULTS)
        (self.out / "plots" / "jerk.svg.partial").write_text("old")
        self.assertEqual(self.run_scenario("record: false\n" + SHORT).returncode, 0)
        self.assertEqual(self.files(), {"scenario.yaml", "summary.json", "timing.json"})

    def test_leaves_files_alone_that_are_not_its_own(self):
        (self.out / "plots").mkdir(parents=True)
        victim = self.folder / "victim"
        victim.write_text("mine")
        mine = {"notes.txt", "download.partial", "plots/mine.svg", "plots/mine.partial"}
        for name in mine:
            (self.out / name).write_text("mine")
        (self.out / "probe.partial").symlink_to(victim)
        (self.out / "run.mcap.partial").symlink_to(victim)
        self.assertEqual(self.run_scenario().returncode, 0)
        self.assertEqual(victim.read_text(), "mine")
        self.assertEqual(self.files(), self.RESULTS | mine | {"probe.partial"})
        for name in mine:
            self.assertEqual((self.out / name).read_text(), "mine")

    def test_seed_is_taken_as_it_is_written(self):
        for text, seed in [("18446744073709551615", 2**64 - 1), ("010", 10)]:
            self.assertEqual(self.run_scenario(SHORT, "--seed", text).returncode, 0)
            self.assertIn(f"seed: {seed}\n", (self.out / "scenario.yaml").read_text())

    def test_exports_its_log(self):
        self.assertEqual(self.run_scenario().returncode, 0)
        done = self.call("export", self.out / "run.mcap")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((self.out / "csv" / "cycles.csv").is_file())

    def test_explains_a_success(self):
        self.assertEqual(self.run_scenario().returncode, 0)
        for named in [self.out, self.out / "run.mcap"]:
            done = self.call("explain", named)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn("short: no error", done.stdout)
            self.assertIn("of 2.175 rad/s, joint 1", done.stdout)
        self.assertEqual(self.files(), self.RESULTS)

    def test_low_pass_shows_as_deviation(self):
        figures = []
        for text in [SHORT, self.spoil("lambda: 0.001", "generator: none\n  low_pass: 1 Hz")]:
            done = self.run_scenario(text)
            figures.append(json.loads((self.out / "summary.json").read_text())["deviation_rad"])
        self.assertGreater(figures[1], 5 * figures[0])
        # The arm comes to rest later than its plan, and the summary says so.
        self.assertRegex(done.stdout, r"\d+ s simulated \(\d+\.\d+ s of it settling\)")


class StandardFiles(CliTest):
    """Output that nobody takes costs neither a run nor a file of its results."""

    def test_run_does_not_need_them(self):
        self.assertEqual(self.run_scenario().returncode, 0)
        log = (self.out / "run.mcap").read_bytes()
        for redirected in [">&-", "2>&-", "<&- >&- 2>&-", ">/dev/full", ">/dev/full 2>/dev/full"]:
            with self.subTest(redirected=redirected):
                shutil.rmtree(self.out)
                done = self.shell(redirected, *self.run_arguments())
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertEqual(self.files(), GoodRun.RESULTS)
                self.assertEqual((self.out / "run.mcap").read_bytes(), log)

    def test_run_outlives_the_reader_of_its_output(self):
        reading, writing = os.pipe()
        os.close(reading)
        done = subprocess.run([PROGRAM, *map(str, self.run_arguments())], stdout=writing,
                              stderr=subprocess.PIPE, env=self.environment, timeout=120)
        os.close(writing)
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        self.assertEqual(self.files(), GoodRun.RESULTS)

    def test_error_that_cannot_be_shown_keeps_its_code(self):
        for redirected in ["2>&-", "2>/dev/full", ">&- 2>&-"]:
            with self.subTest(redirected=redirected):
                self.assertEqual(self.shell(redirected, "run", "nowhere.yaml").returncode, 3)
                self.assertEqual(self.shell(redirected, "fly").returncode, 2)

    def test_lost_output_is_an_error_where_it_is_the_result(self):
        self.assertEqual(self.run_scenario().returncode, 0)
        data = ["--data", SOURCE / "models"]
        for arguments in [["validate", self.out / "scenario.yaml", *data], ["check", *data],
                          ["export", self.out / "run.mcap"], ["explain", self.out],
                          ["explain", "--errors"], ["--help"], ["--version"]]:
            for redirected in [">/dev/full", ">&-"]:
                with self.subTest(arguments=arguments, redirected=redirected):
                    self.assert_error(self.shell(redirected, *arguments), 4, "standard output")


class EndedEarly(CliTest):
    def test_aborted_motion_keeps_a_whole_log(self):
        # Commands that need 800 us beside a d_INT of 100 us and a state delay of 200 us are all late.
        text = self.spoil("command_loss: 0 %", "command_delay: 800 us\n  state_delay: 200 us")
        done = self.run_scenario(text)
        self.assert_error(done, 1, "")
        self.assertEqual(self.files(), GoodRun.RESULTS)
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual(summary["outcome"], "aborted")
        self.assertIn(f"panda-twin explain {self.out / 'run.mcap'}", done.stderr)

    def test_explain_says_why_it_aborted(self):
        text = self.spoil("command_loss: 0 %", "command_loss: {scripted: [{at: 0.5 s, count: 20}]}")
        self.assert_error(self.run_scenario(text), 1, "communication_constraints_violation")
        done = self.call("explain", self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for says in ["communication_constraints_violation", "20 cycles in a row", "30 cycles served, 20 held",
                     "20 because the link lost the command", "what to do", str(self.out / "explain.html")]:
            self.assertIn(says, done.stdout)
        self.assertEqual(self.files(), GoodRun.RESULTS | {"explain.html"})
        page = (self.out / "explain.html").read_bytes()
        elsewhere = self.folder / "new" / "folder"
        done = self.call("explain", self.out / "run.mcap", "--out", elsewhere)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((elsewhere / "explain.html").read_bytes(), page, "the same bytes again")
        (self.out / "run.mcap").rename(self.out / "run.mcap.partial")
        self.assertEqual(self.call("explain", self.out).returncode, 0)
        # A page goes with its run.
        self.assertEqual(self.run_scenario().returncode, 0)
        self.assertEqual(self.files(), GoodRun.RESULTS)

    def test_page_that_cannot_be_written(self):
        text = self.spoil("command_loss: 0 %", "command_loss: {scripted: [{at: 0.5 s, count: 20}]}")
        self.run_scenario(text)
        blocked = self.folder / "blocked"
        blocked.write_text("a file")
        self.assert_error(self.call("explain", self.out, "--out", blocked), 4, "blocked")

    def test_jerky_commands_name_joint_and_limit(self):
        # No generator, and a clock that is sampled late at random: jerk beyond the limits.
        text = self.spoil("lambda: 0.001", "generator: none")
        text = text.replace("motion:", "controller:\n  wake_delay: {log_normal: {median: 50 us, "
                            "sigma: 1}}\nmotion:")
        done = self.run_scenario(text)
        self.assert_error(done, 1, "joint_motion_generator_")
        self.assertIn("limit", done.stderr)
        self.assertIn("what to do", done.stdout)

    def interrupt(self, sig):
        # A minute of motion, so that there is time to interrupt it.
        path = self.scenario(SHORT.replace("1 s", "60 s"))
        process = subprocess.Popen(
            [PROGRAM, "run", path, "--out", self.out, "--data", SOURCE / "models"], cwd=self.folder,
            env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        process.stdout.readline()  # the first tenth is done
        process.send_signal(sig)
        stdout, stderr = process.communicate(timeout=60)
        return subprocess.CompletedProcess([], process.returncode, stdout, stderr)

    def test_interrupt_stops_the_motion_and_completes_the_log(self):
        for sig in [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]:
            with self.subTest(signal=sig):
                self.assert_error(self.interrupt(sig), 130, "interrupted")
                self.assertEqual(self.files(),
                                 {"run.mcap", "scenario.yaml", "summary.json", "timing.json"})
                summary = json.loads((self.out / "summary.json").read_text())
                self.assertEqual(summary["outcome"], "interrupted")
                done = self.call("export", self.out / "run.mcap")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertNotIn("killed", done.stdout)
                shutil.rmtree(self.out)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
