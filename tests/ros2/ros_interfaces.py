"""Makes Python packages of ROS interfaces that no wheel has: ros_interfaces.py PREFIX FILE..., in the environment PREFIX, by its rosidl.

FILE is .../<package>/{msg,srv,action}/<Name>.{msg,srv,action}. rosidl's own CMake is not used: it wants forty packages more, and each generator is
a function. Of each package comes one library, PREFIX/lib/lib<package>.so, with type support in C for Fast DDS.
"""

import collections
import concurrent.futures
import graphlib
import json
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile

import numpy
import rosidl_generator_c
import rosidl_generator_py
import rosidl_generator_type_description
import rosidl_typesupport_c
import rosidl_typesupport_fastrtps_c
import rosidl_typesupport_introspection_c
from rosidl_adapter.action import convert_action_to_idl
from rosidl_adapter.msg import convert_msg_to_idl
from rosidl_adapter.srv import convert_srv_to_idl

PREFIX = pathlib.Path(sys.argv[1])
SITE = pathlib.Path(sysconfig.get_paths()["purelib"])
TO_IDL = {"msg": convert_msg_to_idl, "srv": convert_srv_to_idl, "action": convert_action_to_idl}
# rmw_fastrtps_cpp describes what it publishes by the second. rosidl looks each up in a library of its name.
TYPE_SUPPORTS = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")
SOURCES = ("c", "introspection", "py")
FLAGS = ["-O0", "-w", "-fPIC"]
JOBS = 2
FILES_AS_ONE = 8  # sources that are compiled as one: most of the time goes into what they include


def packages():
    """{name: its files}, each after those it uses."""
    files = collections.defaultdict(list)
    for file in map(pathlib.Path, sys.argv[2:]):
        files[file.parent.parent.name].append(file)
    texts = {package: "".join(file.read_text() for file in files[package]) for package in files}
    uses = {package: {other for other in files if other != package and re.search(rf"\b{other}/", texts[package])} for package in files}
    return {package: files[package] for package in graphlib.TopologicalSorter(uses).static_order()}


def generate(package, files, out):
    """Sources into OUT/{c,introspection,py}/<package>; descriptions, which others of these packages want, into PREFIX/share."""
    share, idl = PREFIX / "share" / package, []
    for file in files:
        kind = file.parent.name
        (share / kind).mkdir(parents=True, exist_ok=True)
        shutil.copy(file, share / kind)
        TO_IDL[kind](share, package, pathlib.Path(kind, file.name), share / kind)
        idl.append(f"{kind}/{file.stem}.idl")
    idl_tuples = [f"{share}:{name}" for name in idl]

    def arguments(generator, output, **more):
        file = out / f"{package}.{generator}.json"
        file.write_text(json.dumps({
            "package_name": package,
            "output_dir": str(output),
            "template_dir": str(PREFIX / "share" / generator / "resource"),
            "idl_tuples": idl_tuples,
            "ros_interface_dependencies": [],
            "target_dependencies": [],
            **more,
        }))  # fmt: skip
        return str(file)

    others = [f"{other.name}:{other}" for other in (PREFIX / "share").iterdir() if other.name != package]
    rosidl_generator_type_description.generate_type_hash(arguments("rosidl_generator_type_description", share, include_paths=others))
    c, introspection, py = (out / name / package for name in SOURCES)
    described = {
        "type_description_tuples": [f"{name}:{(share / name).with_suffix('.json')}" for name in idl],
        "ros_interface_files": [str(share / file.parent.name / file.name) for file in files],
    }
    rosidl_generator_c.generate_c(arguments("rosidl_generator_c", c, **described))
    rosidl_typesupport_c.generate_c(arguments("rosidl_typesupport_c", c), TYPE_SUPPORTS)
    rosidl_typesupport_fastrtps_c.generate_typesupport_fastrtps_c(arguments("rosidl_typesupport_fastrtps_c", c))
    rosidl_typesupport_introspection_c.generate_c(arguments("rosidl_typesupport_introspection_c", introspection))
    for generator in ("rosidl_generator_c", *TYPE_SUPPORTS):
        name = f"{generator}__visibility_control.h"
        text = (PREFIX / "share" / generator / "resource" / f"{name}.in").read_text()
        (c / "msg").mkdir(exist_ok=True)
        (c / "msg" / name).write_text(text.replace("@PROJECT_NAME@", package).replace("@PROJECT_NAME_UPPER@", package.upper()))
    rosidl_generator_py.generate_py(arguments("rosidl_generator_py", py), ["rosidl_typesupport_c"])
    shutil.copytree(py, SITE / package, ignore=shutil.ignore_patterns("*.c"), dirs_exist_ok=True)
    (SITE / package / "__init__.py").touch()


def compile_all(names, out):
    """Into PREFIX/lib and the packages in SITE; NAMES each after those it uses."""
    ours, theirs = (out / name for name in SOURCES), PREFIX / "include"
    folders = [*ours, theirs, *sorted(theirs.iterdir()), sysconfig.get_paths()["include"], numpy.get_include()]
    includes = [f"-I{folder}" for folder in folders]
    objects = {package: [] for package in names}
    units = []  # (language, object, sources)
    for package in names:
        groups = collections.defaultdict(list)
        for name in SOURCES:
            for source in sorted((out / name / package).rglob("*.c*")):
                if ending := re.search(r"(__description|__functions|__type_support|__type_support_c|_s)\.(c|cpp)$", source.name):
                    groups[name, ending[0]].append(source)
        for (_, ending), group in groups.items():
            step = 1 if ending == "__description.c" else FILES_AS_ONE  # names of its statics are not unique
            for at in range(0, len(group), step):
                objects[package].append(out / f"{package}.{len(units)}.o")
                units.append((objects[package][-1], "c++" if ending.endswith("cpp") else "c", group[at : at + step]))

    def compile_one(unit):
        file, language, sources = unit
        standard = "-std=c++17" if language == "c++" else "-std=gnu11"
        text = "".join(f'#include "{source}"\n' for source in sources)
        subprocess.run(["cc", "-x", language, standard, *FLAGS, *includes, "-c", "-o", file, "-"], input=text, text=True, check=True)

    with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
        list(pool.map(compile_one, units))
    link = ["c++", "-shared", f"-L{PREFIX / 'lib'}", "-Wl,--as-needed", "-Wl,-z,now"]
    used = r"lib(.*(_msgs|_interfaces)__)?(rosidl_.*|rcutils|rmw|fastcdr)\.so"
    wheels = [f"-l{file.stem[3:]}" for file in (PREFIX / "lib").glob("*.so") if re.fullmatch(used, file.name)]
    before = []
    for package in names:
        library = PREFIX / f"lib/lib{package}.so"
        subprocess.run([*link, "-Wl,-rpath,$ORIGIN", "-o", library, *objects[package], *before, *wheels], check=True)
        for name in TYPE_SUPPORTS:
            (PREFIX / f"lib/lib{package}__{name}.so").symlink_to(f"lib{package}.so")
        before.append(f"-l{package}")
        # The module that Python imports; it takes what it says from the library.
        entry = out / "py" / package / f"_{package}_s.ep.rosidl_typesupport_c.c"
        module = SITE / package / f"{package}_s__rosidl_typesupport_c{sysconfig.get_config_var('EXT_SUFFIX')}"
        rpath = "-Wl,-rpath,$ORIGIN/../../.."
        subprocess.run([*link, *FLAGS, *includes, rpath, "-o", module, "-x", "c", entry, "-x", "none", f"-l{package}", *wheels], check=True)


def main():
    with tempfile.TemporaryDirectory(prefix="panda_twin_rosidl_") as out:
        all_packages = packages()
        for package, files in all_packages.items():
            generate(package, files, pathlib.Path(out))
        compile_all(all_packages, pathlib.Path(out))


if __name__ == "__main__":
    main()
