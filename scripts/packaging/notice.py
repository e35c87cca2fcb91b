"""Names in a wheel what it has of others, with licences.

    notice.py WHEEL NOTICE

Writes into the wheel's licence folder NOTICE and below it a list of the libraries that auditwheel has put into the wheel and of those of
which our programs contain headers, each with the Debian package, its version and its source; and for each package its file of copyrights
and licences, with the common licences that these refer to. Run by scripts/wheel with the Python that has auditwheel and nanobind. A library
of no Debian package is an error: its licence would not be known.
"""

import importlib.metadata
import pathlib
import re
import subprocess
import sys

from auditwheel.wheeltools import InWheelCtx

from compiled_headers import HEADERS

RENAMED = re.compile(r"^(?P<stem>.+)-[0-9a-f]{8}(?P<rest>\.so[.0-9]*)$")
COMMON = pathlib.Path("/usr/share/common-licenses")
DOCUMENTS = pathlib.Path("/usr/share/doc")
TEXT = """
What this wheel contains of others
----------------------------------
Libraries as Debian packages them, renamed and linked anew by auditwheel, and headers, compiled into program and module. For each package,
licences/PACKAGE beside this file has the copyrights and licences; the sources are at https://sources.debian.org.

{packages}

Compiled into the module: nanobind {nanobind} (https://github.com/wjakob/nanobind; licences/nanobind, and licences/robin_map for what it has
of https://github.com/Tessil/robin-map).
"""


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def original_name(bundled):
    match = RENAMED.match(bundled)
    return match["stem"] + match["rest"] if match else bundled


def files_by_name():
    """Where the dynamic linker finds each library."""
    found = {}
    for line in output_of("/sbin/ldconfig", "-p").splitlines():
        if " => " in line and "x86-64" in line:
            path = pathlib.Path(line.split(" => ")[1]).resolve()
            found.setdefault(line.split()[0], path)
            found.setdefault(path.name, path)
    return found


def package_of(path):
    """The package that has the file, whether it says /usr/lib or /lib."""
    for candidate in (path, pathlib.Path(str(path).removeprefix("/usr"))):
        result = subprocess.run(["dpkg-query", "-S", candidate], capture_output=True, text=True)
        if result.returncode == 0:
            return result.stdout.split(":")[0]
    sys.exit(f"notice: {path} belongs to no Debian package, so its licence is not known")


def packages_of(libraries):
    """@returns {package: what the wheel has of it}"""
    files, packages = files_by_name(), {name: ["headers"] for name in HEADERS}
    for library in libraries:
        name = original_name(library)
        if name not in files:
            sys.exit(f"notice: {library} is in the wheel, but the dynamic linker knows no {name}")
        packages.setdefault(package_of(files[name]), []).append(library)
    return packages


def write_licences(folder, packages):
    folder.mkdir(parents=True, exist_ok=True)
    common = set()
    for package in packages:
        text = (DOCUMENTS / package / "copyright").read_text(errors="replace")
        (folder / package).write_text(text)
        common |= set(re.findall(rf"{COMMON}/([A-Za-z0-9.-]*[A-Za-z0-9])", text))
    for name in common:
        if (COMMON / name).is_file():
            (folder / f"common-{name}").write_text((COMMON / name).read_text())
    nanobind = importlib.metadata.distribution("nanobind")
    (folder / "nanobind").write_text(nanobind.read_text("licenses/LICENSE"))
    robin_map = pathlib.Path(nanobind.locate_file("nanobind/ext/robin_map/include/tsl/robin_map.h")).read_text()
    (folder / "robin_map").write_text(robin_map[:robin_map.index("*/")])  # the comment at its head


def main():
    wheel, notice = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).read_text()
    with InWheelCtx(wheel, wheel) as context:
        root = pathlib.Path(context.path)
        packages = packages_of(sorted(path.name for path in (root / "panda_twin.libs").iterdir()))
        lines = []
        for package, parts in sorted(packages.items()):
            version, source = output_of("dpkg-query", "-W", "-f", "${Version}|${source:Package}\n", package).splitlines()[0].split("|")
            lines.append(f"{package} {version} (source {source}): {', '.join(parts)}")
        licences = next(root.glob("*.dist-info")) / "licenses"
        write_licences(licences / "licences", packages)
        (licences / "NOTICE").write_text(notice + TEXT.format(packages="\n".join(lines), nanobind=importlib.metadata.version("nanobind")))


if __name__ == "__main__":
    main()
