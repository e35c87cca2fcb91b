"""A command under an LTTng session of its own: its daemon, in folders no other process sees, is gone when the command is."""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

TOOLS = ("lttng", "lttng-sessiond", "babeltrace2")
PROVIDER = "libpanda_twin_tracepoints.so"
CHANNEL = "points"
SUB_BUFFERS = 4
READ_EVERY_US = 100_000
START_TIMEOUT_S = 30

SHARED_MEMORY = "/dev/shm"

# Where a daemon of root's listens, whatever its settings say.
ROOTS_FOLDER = pathlib.Path("/var/run/lttng")
IS_PRIVATE = "TWIN_TRACE_IS_PRIVATE"
HIDE = 'mkdir -p "$0" && mount -t tmpfs -o mode=0755 lttng "$0" && exec "$@"'


class TraceError(Exception):
    """Tracing is not possible here; the text says what, where and what to do."""


def require_tools():
    missing = [tool for tool in TOOLS if not shutil.which(tool)]
    if missing:
        raise TraceError(f"{', '.join(missing)} not found; scripts/setup installs lttng-tools and babeltrace2")


def require_memory(buffer_bytes):
    """LTTng does without a word what it finds no memory for. @param buffer_bytes  per processor."""
    try:
        with tempfile.TemporaryFile(dir=SHARED_MEMORY):
            pass
        free = shutil.disk_usage(SHARED_MEMORY).free
    except OSError as error:
        raise TraceError(f"LTTng keeps its buffers in {SHARED_MEMORY}, which is not writable: {error.strerror}") from error
    wanted = buffer_bytes * os.cpu_count() * 5 // 4  # and its tables
    if free < wanted:
        raise TraceError(f"{SHARED_MEMORY} has {free // 1024} KiB free; {wanted // 1024} KiB are needed for "
                         f"{os.cpu_count()} processors: make it larger, or say a smaller --buffer")


def find_provider(program, build):
    """The library that records the events.

    @param program  first word of the command: the library is looked for above it.
    @param build  build folder to look in when it is not there.
    """
    path = shutil.which(program)
    if not path:
        raise TraceError(f"{program}: no such program")
    program = pathlib.Path(path).resolve()
    advice = "configure with cmake --preset release -DTWIN_LTTNG=ON and build again"
    # Tracepoints are in a section of that name.
    if program.name == "panda-twin" and b"lttng_ust_tracepoints" not in program.read_bytes():
        raise TraceError(f"{program} was built without tracepoints; {advice}")
    for folder in (*program.parents, build):
        if (folder / PROVIDER).exists():
            return folder / PROVIDER
    raise TraceError(f"{PROVIDER} is neither above {program} nor in {build}; {advice}, or say --build DIR")


def hide_roots_daemon(arguments):
    """For root alone: runs `arguments` in place of this process, where ROOTS_FOLDER is an empty one of its own.

    Returns when there is nothing to hide, or when hiding is not permitted (a container) and no process uses the folder.
    """
    if os.geteuid() != 0 or os.environ.get(IS_PRIVATE):
        return
    private = ["unshare", "--mount", "--propagation", "private", "sh", "-c", HIDE, str(ROOTS_FOLDER)]
    if subprocess.run([*private, "true"], capture_output=True).returncode == 0:
        os.execvpe(private[0], [*private, *arguments], {**os.environ, IS_PRIVATE: "1"})
    if runs(ROOTS_FOLDER / "lttng-sessiond.pid"):
        raise TraceError("a session daemon of root's runs, and this container permits none beside it (no mount "
                         "namespaces); run this as an ordinary user, or stop that daemon")


def runs(pid_file):
    """Whether the daemon that wrote this file still runs."""
    try:
        return pathlib.Path("/proc", pid_file.read_text().strip(), "comm").read_text().startswith("lttng-sessiond")
    except OSError:
        return False


class Session:
    """`with Session(folder, bytes) as session: code = session.run(command, provider)`, then session.lost.

    @param folder  where the trace goes. @param buffer_bytes  per processor, for what a reader has not fetched yet.
    """

    def __init__(self, folder, buffer_bytes):
        self.folder = folder
        self.lost = None  # events that found no room, once the command has ended
        self._buffer_bytes = buffer_bytes
        self._daemon = None

    def __enter__(self):
        self._home = tempfile.mkdtemp(prefix="twin-trace-")  # short: it holds sockets
        self._environment = {**os.environ, "LTTNG_HOME": self._home, "LTTNG_UST_REGISTER_TIMEOUT": "30000"}
        self._environment.pop(IS_PRIVATE, None)
        self._free = signal.pthread_sigmask(
            signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1, signal.SIGCHLD})
        try:
            self._start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        if self._daemon is not None:
            self._daemon.terminate()
            self._daemon.wait()
        shutil.rmtree(self._home, ignore_errors=True)
        signal.pthread_sigmask(signal.SIG_SETMASK, self._free)

    def run(self, command, provider):
        """Runs it with our standard streams, and records. Signals to us are passed on; a terminal's reach it anyway.

        @returns its exit code, 128 + n when signal n ended it.
        """
        preload = " ".join(filter(None, (str(provider), os.environ.get("LD_PRELOAD"))))
        process = subprocess.Popen(command, env={**self._environment, "LD_PRELOAD": preload}, preexec_fn=self._unblock)
        while process.poll() is None:
            told = signal.sigwaitinfo({signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD})
            if told.si_signo != signal.SIGCHLD and told.si_code <= 0:  # a process sent it, not the terminal
                process.send_signal(told.si_signo)
        self._stop()
        return process.returncode if process.returncode >= 0 else 128 - process.returncode

    def _unblock(self):
        signal.pthread_sigmask(signal.SIG_SETMASK, self._free)

    def _start(self):
        log = open(pathlib.Path(self._home, "daemon.log"), "w+")
        # In a session of its own no Ctrl-C reaches it; it ends when we do, however that is. SIGUSR1: it is ready.
        self._daemon = subprocess.Popen(
            ["setpriv", "--pdeathsig", "TERM", "lttng-sessiond", "--no-kernel", "--sig-parent"], env=self._environment,
            stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True, preexec_fn=self._unblock)
        told = signal.sigtimedwait({signal.SIGUSR1, signal.SIGCHLD, signal.SIGINT, signal.SIGTERM}, START_TIMEOUT_S)
        if told and told.si_signo in (signal.SIGINT, signal.SIGTERM):
            raise KeyboardInterrupt
        if told is None or told.si_signo == signal.SIGCHLD:
            log.seek(0)
            raise TraceError(f"lttng-sessiond does not start: {log.read().strip()[-500:]}")
        size = max(self._buffer_bytes // SUB_BUFFERS, 4096)
        self._lttng("create", "twin", f"--output={self.folder}")
        # Read by a timer: otherwise a thread that fills a sub-buffer wakes the reader by a system call. No monitor of how
        # full they are: its timer interrupts.
        self._lttng("enable-channel", "-u", "--buffers-uid", "--discard", f"--subbuf-size={size}",
                    f"--num-subbuf={SUB_BUFFERS}", f"--read-timer={READ_EVERY_US}", "--monitor-timer=0", CHANNEL)
        self._lttng("enable-event", "-u", "-c", CHANNEL, "panda_twin:*")
        self._lttng("add-context", "-u", "-c", CHANNEL, "-t", "vpid", "-t", "vtid")
        self._lttng("start")

    def _stop(self):
        self._lttng("stop")
        self.lost = lost_events(self._lttng("--mi", "xml", "list", "twin"))
        self._lttng("destroy", "--no-wait", "twin")  # what was recorded is on the disk since the stop

    def _lttng(self, *arguments):
        # A group without members: members of "tracing" would be sent to a daemon of root's.
        done = subprocess.run(["lttng", "--group=root", "--no-sessiond", *arguments], env=self._environment,
                              capture_output=True, text=True)
        if done.returncode != 0:
            raise TraceError(f"lttng {' '.join(arguments)}: {(done.stderr + done.stdout).strip()[-500:]}")
        return done.stdout


def lost_events(listing):
    """Events that found no room in the buffers. @param listing  what `lttng --mi xml list SESSION` says."""
    namespace = "{https://lttng.org/xml/ns/lttng-mi}"
    counts = [int(element.text) for name in ("discarded_events", "lost_packets")
              for element in xml.etree.ElementTree.fromstring(listing).iter(namespace + name)]
    if not counts:
        raise TraceError("lttng does not tell how many events were lost")
    return sum(counts)
