#!/usr/bin/env python3
"""Installs a build folder, moves what was installed elsewhere, and uses it from there.

    check_install.py BUILD SOURCE

Checked: no installed file names the build, the source or the first install folder; no header includes one of MuJoCo; a consumer's
project and README's example are configured, compiled and run; the programs find their models, and panda-twin says its version; uninstall leaves nothing.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

CONSUMER = pathlib.Path(__file__).resolve().parent / "consumer"
EXAMPLE = pathlib.Path(__file__).resolve().parent / "example"
MUJOCO = re.compile(rb"#\s*include\s*[<\"]mujoco")


def run(*command, **options):
    """Runs a command; ends the check with its output when it fails."""
    result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options)
    if result.returncode != 0:
        sys.exit(f"failed ({result.returncode}): {' '.join(map(str, command))}\n{result.stdout.decode(errors='replace')}")
    return result.stdout.decode()


def files_in(folder):
    return sorted(path for path in folder.rglob("*") if path.is_file())


def check_contents(prefix, foreign_paths):
    """@returns what is wrong with the installed files. Programs and libraries may name sources in their messages."""
    wrong = []
    for path in files_in(prefix):
        data = path.read_bytes()
        name = path.relative_to(prefix)
        if path.suffix in {".cmake", ".h", ".yaml", ".xml", ".urdf"}:
            wrong += [f"{name} names {foreign}" for foreign in foreign_paths if foreign.encode() in data]
        if path.suffix == ".h" and MUJOCO.search(data):
            wrong.append(f"{name} includes a header of MuJoCo")
    return wrong


def check_uninstall(build, work):
    """@returns what uninstall leaves behind of an install of its own."""
    prefix = work / "third"
    run("cmake", "--install", build, "--prefix", prefix)
    count = len(files_in(prefix))
    run("cmake", "--build", build, "--target", "uninstall")
    left = [str(path.relative_to(prefix)) for path in files_in(prefix)]
    ours = [str(path.relative_to(prefix)) for path in prefix.rglob("*") if re.search(r"twin", path.name)]
    print(f"uninstall: {count - len(left)} of {count} files")
    return [f"uninstall leaves {name}" for name in left + ours]


def main():
    build, source = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
    with tempfile.TemporaryDirectory(prefix="panda-twin-install-") as folder:
        work = pathlib.Path(folder)
        first, prefix = work / "first", work / "moved" / "second"
        run("cmake", "--install", build, "--prefix", first)
        prefix.parent.mkdir()
        shutil.move(first, prefix)

        wrong = check_contents(prefix, [str(build), str(source), str(first)])
        for project in (CONSUMER, EXAMPLE):
            build_there = work / f"build_{project.name}"
            run("cmake", "-S", project, "-B", build_there, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}",
                "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS_DEBUG=-O0")  # hundreds of headers; nobody debugs them
            run("cmake", "--build", build_there)
            printed = run(build_there / project.name).strip()
            print(f"{project.name}:", printed)
        if not printed.startswith("joint_motion_generator_velocity"):
            wrong.append(f"the example prints {printed}")

        program = prefix / "bin" / "panda-twin"
        print("program:", run(program, "--version").splitlines()[0])
        scenario = prefix / "share" / "panda_twin" / "models" / "scenarios" / "canonical.yaml"
        print("validate:", run(program, "validate", scenario, cwd=work).strip().splitlines()[-1])
        print("campaign:", run(prefix / "bin" / "panda-twin-campaign", "--worlds", "2", "--around", scenario, cwd=work).splitlines()[0])
        wrong += check_uninstall(build, work)
    print("\n".join(wrong) if wrong else "install: sound")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
