#!/usr/bin/env python3
"""A sweep on a real Slurm of one node, begun here in namespaces of its own: sweep_slurm_test.py PROGRAM SOURCE_TREE. As root."""

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

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
NODE, ADDRESS = "twin-node", "10.213.7.1"
SWEEP = """name: on_slurm
scenario: canonical.yaml
axes:
  - {key: link.command_loss, values: [0 %, 1 %, 2 %]}
seeds: 4
"""
CONFIGURATION = """ClusterName=twin
SlurmctldHost={node}
SlurmUser=root
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
NodeName={node} CPUs={cpus} RealMemory=4000 State=UNKNOWN
PartitionName=all Nodes={node} Default=YES State=UP
"""


def in_namespaces():
    """This program again, where the host's name and address are its own."""
    os.execvp("unshare", ["unshare", "--net", "--uts", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc",
                          sys.executable, *sys.argv, "--inside"])


def call(*words, **options):
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=300, **options)
    if done.returncode != 0:
        raise AssertionError(f"{words}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


class SlurmTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_slurm_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        socket.sethostname(NODE)
        (cls.folder / "hosts").write_text(f"127.0.0.1 localhost\n{ADDRESS} {NODE}\n")
        call("mount", "--bind", cls.folder / "hosts", "/etc/hosts")
        call("ip", "link", "set", "lo", "up")
        call("ip", "link", "add", "node0", "type", "veth", "peer", "name", "node1")
        call("ip", "addr", "add", f"{ADDRESS}/24", "dev", "node0")
        for end in ("node0", "node1"):
            call("ip", "link", "set", end, "up")
        (cls.folder / "slurm.conf").write_text(CONFIGURATION.format(node=NODE, folder=cls.folder, cpus=os.cpu_count()))
        (cls.folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")
        os.environ["SLURM_CONF"] = str(cls.folder / "slurm.conf")
        cls.begin_daemons()

    @classmethod
    def begin_daemons(cls):
        folder = cls.folder
        for name in ("state", "spool"):
            (folder / name).mkdir()
        key = folder / "munge.key"
        key.touch(0o600)
        key.write_bytes(os.urandom(128))
        call("munged", "--force", "--socket", folder / "munge.socket", "--key-file", key, "--pid-file", folder / "munged.pid",
             "--log-file", folder / "munged.log", "--seed-file", folder / "munged.seed")
        call("slurmctld", "-c")
        call("slurmd", "-c")
        limit = time.monotonic() + 60
        while "idle" not in subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True).stdout:
            if time.monotonic() > limit:
                raise AssertionError((folder / "slurmctld.log").read_text() + (folder / "slurmd.log").read_text())
            time.sleep(0.2)

    def setUp(self):
        (self.folder / "s.yaml").write_text(SWEEP)

    def sweep(self, what, out, *more):
        return call(PROGRAM, "sweep", what, self.folder / "s.yaml", "--out", self.folder / out, "--data", SOURCE / "models", *more)

    def test_its_digest_is_that_of_this_machine_also_after_a_task_was_requeued(self):
        self.sweep("run", "here")
        here = re.search(r"digest  (\w{16})", self.sweep("merge", "here")).group(1)
        script = self.folder / "submit.sh"
        script.write_text(self.sweep("slurm", "there", "--shards", 3))
        array, merge = re.search(r"shards (\d+), merge (\d+)", call("bash", script)).groups()
        while not list(self.folder.glob("there/runs/*/*.json")):  # a task is at work
            time.sleep(0.05)
        call("scontrol", "requeue", f"{array}_0")
        merged = self.folder / "there/slurm/merge.txt"
        limit = time.monotonic() + 400  # Slurm lets two minutes pass before a requeued task begins
        while not (merged.exists() and "digest" in merged.read_text()):
            self.assertLess(time.monotonic(), limit, call("scontrol", "show", "job", merge))
            time.sleep(0.5)
        self.assertIn(f"digest  {here}\n", merged.read_text())
        told = call("scontrol", "show", "job", array)
        self.assertRegex(told, "Restarts=1")


if __name__ == "__main__":
    if sys.argv[-1] != "--inside":
        if os.geteuid() != 0 or not shutil.which("slurmctld"):
            print("SKIPPED: takes root, and slurmctld slurmd munge (apt-get install)")
            sys.exit(77)
        in_namespaces()
    unittest.main(argv=sys.argv[:1])
