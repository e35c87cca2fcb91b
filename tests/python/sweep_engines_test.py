"""Sweeps on Ray and in an object store, both real: a cluster of two nodes on this machine, and moto, a server of S3's protocol. Both come from
PyPI, into a Python environment in the build folder.

    sweep_engines_test.py PROGRAM SOURCE_TREE
"""

import hashlib
import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request
import venv

PROGRAM, SOURCE = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(2))
BIN = PROGRAM.parent / "engines/bin"
SWEEP = """name: losses
scenario: {scenario}
axes:
  - {{key: link.command_loss, values: [0 %, 1 %, 2 %]}}
  - {{key: link.d_INT, values: [100 us, 200 us]}}
seeds: {seeds}
"""
# A cluster of two nodes on this machine. It lasts as long as standard input; a line there kills the second node.
CLUSTER = """
import ray.cluster_utils, sys
cluster = ray.cluster_utils.Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
second = cluster.add_node(num_cpus=1)
cluster.wait_for_nodes()
print(cluster.address, flush=True)
for line in sys.stdin:
    cluster.remove_node(second, allow_graceful=False)
    print("killed", flush=True)
cluster.shutdown()
"""


def setUpModule():
    wanted = SOURCE / "tests/python/requirements-engines.txt"
    stamp, digest = BIN.parent / "stamp", hashlib.sha256(wanted.read_bytes()).hexdigest()
    if not stamp.exists() or stamp.read_text() != digest:
        shutil.rmtree(BIN.parent, ignore_errors=True)
        venv.create(BIN.parent, with_pip=True)
        subprocess.run([BIN / "python", "-m", "pip", "install", "-q", "--no-deps", "--only-binary=:all:", "--require-hashes", "-r", wanted], check=True)
        stamp.write_text(digest)


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class EnginesTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_engines_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.environment = {**os.environ, "PANDA_TWIN_PYTHON": str(BIN / "python"), "PYTHONPATH": str(PROGRAM.parent / "python")}
        self.environment["RAY_ADDRESS"] = "local"  # a cluster of its own, whatever runs here

    def write(self, seeds, scenario="smoke.yaml"):
        (self.folder / "s.yaml").write_text(SWEEP.format(seeds=seeds, scenario=scenario))
        self.sweep("run", "here", "-q")
        self.digest = self.digest_of("here")

    def begin(self, command, out, *more):
        out = out if "://" in out else self.folder / out
        words = [PROGRAM, "sweep", command, self.folder / "s.yaml", "--data", SOURCE / "models", "--out", out, *more]
        return subprocess.Popen(list(map(str, words)), env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def end(self, process, code=0):
        printed, said = process.communicate(timeout=900)
        self.assertEqual(process.returncode, code, printed + said)
        return printed + said

    def sweep(self, command, out, *more, code=0):
        return self.end(self.begin(command, out, *more), code)

    def digest_of(self, out):
        return re.search(r"^digest  ([0-9a-f]{16})$", self.sweep("merge", out), re.MULTILINE)[1]

    def wait_until(self, holds, seconds=120):
        last = time.monotonic() + seconds
        while not holds():
            if time.monotonic() > last:
                self.fail("".join(log.read_text() for log in self.folder.glob("*.log")))
            time.sleep(0.2)

    def results(self, out="out"):
        return len(list((self.folder / out / "runs").rglob("*.json")))


class RayTest(EnginesTest):
    def begin_cluster(self):
        """Returns what kills its second node."""
        log = open(self.folder / "cluster.log", "w")
        self.addCleanup(log.close)
        cluster = subprocess.Popen([BIN / "python", "-c", CLUSTER], env=self.environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log,
                                   text=True)  # fmt: skip
        self.addCleanup(cluster.communicate)
        self.environment["RAY_ADDRESS"] = cluster.stdout.readline().strip()

        def kill():
            cluster.stdin.write("kill\n")
            cluster.stdin.flush()
            self.assertEqual(cluster.stdout.readline(), "killed\n")

        return kill

    def test_a_node_that_is_killed_costs_its_own_shard(self):
        self.write(seeds=50, scenario="canonical.yaml")
        kill_second_node = self.begin_cluster()
        running = self.begin("run", "out", "--on", "ray", "--shards", "30")
        self.wait_until(lambda: self.results() >= 20)
        kill_second_node()
        at = self.results()
        self.end(running)
        self.assertLess(at, 300)
        self.assertEqual(self.digest_of("out"), self.digest)
        print(f"ray: node killed after {at} of 300 runs; digest {self.digest}", flush=True)

    def test_a_driver_that_is_killed_goes_on(self):
        self.write(seeds=40)
        running = self.begin("run", "out", "--on", "ray")  # a cluster of its own
        self.wait_until(lambda: self.results() > 0)
        running.kill()
        running.communicate()
        self.sweep("run", "out", "--on", "ray", "--shards", "7")
        self.assertEqual(self.digest_of("out"), self.digest)

    def test_a_result_that_is_not_whole_is_done_again(self):
        self.write(seeds=4)
        self.sweep("run", "out", "--on", "ray")
        file = next((self.folder / "out/runs").rglob("*.json"))
        file.write_text(file.read_text()[:40])
        self.sweep("run", "out", "--on", "ray")
        self.assertEqual(self.digest_of("out"), self.digest)

    def test_what_is_refused(self):
        self.write(seeds=1)
        self.assertIn("must be ray, or ray://HOST:PORT", self.sweep("run", "out", "--on", "dask", code=3))
        self.assertIn("leave --shard and --jobs out", self.sweep("run", "out", "--on", "ray", "--jobs", "2", code=3))
        self.assertIn("--shards is for --on", self.sweep("run", "out", "--shards", "2", code=3))
        told = self.sweep("run", "out", "--on", f"ray://127.0.0.1:{free_port()}", code=4)
        self.assertIn("Ray's cluster cannot be reached", told)
        text = (self.folder / "s.yaml").read_text()
        (self.folder / "s.yaml").write_text("name: s\nscenario: smoke.yaml\naxes: [{key: scene, values: [scenes/floor.xml, none.xml]}]\n")
        self.assertRegex(self.sweep("run", "out", "--on", "ray", code=3), r"point 2 \(scene: none.xml\): .*there is no file")
        (self.folder / "s.yaml").write_text(text)
        self.environment["PANDA_TWIN_PYTHON"] = str(SOURCE / ".venv/bin/python")  # it has no Ray
        self.assertIn("pip install 'panda-twin[ray]'", self.sweep("run", "out", "--on", "ray", code=4))


class StoreTest(EnginesTest):
    def setUp(self):
        super().setUp()
        self.port = free_port()
        self.environment |= {"AWS_ENDPOINT_URL": f"http://127.0.0.1:{self.port}", "AWS_ACCESS_KEY_ID": "key", "AWS_SECRET_ACCESS_KEY": "secret",
                             "AWS_DEFAULT_REGION": "us-east-1", "AWS_EC2_METADATA_DISABLED": "true"}  # fmt: skip
        self.begin_server()

    def begin_server(self):
        with open(self.folder / "server.log", "a") as log:
            server = subprocess.Popen([BIN / "moto_server", "-p", str(self.port)], stdout=log, stderr=log)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        self.wait_until(self.has_bucket)

    def has_bucket(self):
        """Makes it, once the server answers."""
        try:
            return urllib.request.urlopen(urllib.request.Request(f"http://127.0.0.1:{self.port}/bucket", method="PUT"), timeout=5)
        except OSError:
            return None

    def objects(self):
        page = urllib.request.urlopen(f"http://127.0.0.1:{self.port}/bucket?list-type=2", timeout=5).read().decode()
        return re.findall(r"<Key>(.*?)</Key>", page)

    def test_shards_of_machines_that_share_nothing_but_the_store(self):
        self.write(seeds=6)
        for shard in ("2/3", "0/3", "1/3"):
            self.sweep("run", "s3://bucket/losses", "--shard", shard, "--jobs", "1")
        self.assertEqual(self.digest_of("s3://bucket/losses"), self.digest)
        names = self.objects()
        self.assertEqual(len([name for name in names if re.fullmatch(r"losses/runs/../[0-9a-f]{32}\.json", name)]), 36)
        for name in ("report.html", "runs.csv", "runs.parquet", "points.csv", "summary.json"):
            self.assertIn(f"losses/{name}", names)
        page = urllib.request.urlopen(f"http://127.0.0.1:{self.port}/bucket/losses/report.html", timeout=5).read().decode()
        self.assertNotIn("panda_twin_sweep_", page)

    def test_what_is_there_is_not_done_again(self):
        self.write(seeds=6)
        self.sweep("run", "s3://bucket/losses", "--shard", "0/2")
        told = self.sweep("merge", "s3://bucket/losses", code=1)
        self.assertRegex(told, r"18 of 36 runs are missing in s3://bucket/losses, the first")
        self.assertEqual(told.count("error"), 1)
        puts = (self.folder / "server.log").read_text().count("PUT /bucket/losses/runs/")
        self.sweep("run", "s3://bucket/losses", "--on", "ray")
        self.assertEqual((self.folder / "server.log").read_text().count("PUT /bucket/losses/runs/"), 2 * puts)
        self.assertEqual(self.digest_of("s3://bucket/losses"), self.digest)

    def test_logs_of_failures_are_kept_there_too(self):
        (self.folder / "s.yaml").write_text("name: s\nscenario: smoke.yaml\naxes: [{key: link.command_loss, values: [0 %, 90 %]}]\nseeds: 2\nkeep: failures\n")
        self.sweep("run", "s3://bucket/one")
        self.sweep("run", "s3://bucket/two", "--on", "ray")
        names = [sorted(name.partition("/")[2] for name in self.objects() if name.startswith(where)) for where in ("one", "two")]
        self.assertEqual(sum(name.endswith("/run.mcap") for name in names[0]), 2)
        self.assertEqual(names[0], names[1])
        server = self.folder / "server.log"
        puts = server.read_text().count("PUT /")
        self.sweep("run", "s3://bucket/one")
        self.assertEqual(server.read_text().count("PUT /"), puts)

    def test_a_run_that_is_killed_leaves_whole_objects_and_goes_on(self):
        self.write(seeds=4, scenario="canonical.yaml")
        running = self.begin("run", "s3://bucket/losses", "--jobs", "1")
        self.wait_until(self.objects)
        running.kill()
        running.communicate()
        before = len(self.objects())
        self.assertLess(before, 24)
        self.sweep("run", "s3://bucket/losses")
        self.assertEqual(self.digest_of("s3://bucket/losses"), self.digest)

    def test_what_a_store_refuses(self):
        self.write(seeds=1)
        self.assertRegex(self.sweep("run", "s3://nobucket/losses", code=4), "s3://nobucket/losses: .*bucket does not exist")
        self.assertIn("s4://bucket/losses: ", self.sweep("run", "s4://bucket/losses", code=3))
        self.environment["AWS_ENDPOINT_URL"] = f"http://127.0.0.1:{free_port()}"
        self.assertRegex(self.sweep("run", "s3://bucket/losses", code=4), "s3://bucket/losses: .*run the same command to go on")
        self.assertRegex(self.sweep("merge", "s3://bucket/losses", code=4), "s3://bucket/losses: ")


if __name__ == "__main__":
    unittest.main()
