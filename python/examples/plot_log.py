"""Reads a log and draws it: measured against desired positions of a joint, and a picture of the scene.

    plot_log.py LOG [--joint J] [--out DIR]

LOG is a file or a folder of results. DIR gets joint.csv and scene.png, and with gnuplot installed joint.png.
"""

import argparse
import pathlib
import shutil
import struct
import subprocess
import zlib

import numpy as np
import numpy.typing as npt

import panda_twin as pt


def write_png(file: pathlib.Path, picture: npt.NDArray[np.uint8]) -> None:
    """Writes a picture (height, width, 3)."""
    height, width, _ = picture.shape
    rows = zlib.compress(b"".join(b"\0" + row.tobytes() for row in picture))
    chunks = (b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0), b"IDAT" + rows, b"IEND")
    parts = [struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk)) for chunk in chunks]
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(parts))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log", type=pathlib.Path)
    parser.add_argument("--joint", type=int, default=1, choices=range(1, 8), metavar="1..7")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/plot_log"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)

    log = pt.Log(arguments.log)
    cycles, column = log.cycles, arguments.joint - 1
    seconds, q, q_d = cycles.time, cycles["q"][:, column], cycles["q_d"][:, column]
    held = np.count_nonzero(cycles["fate"] == "held")
    print(f"{len(cycles)} cycles in {len(log.motions)} motions, {held} held; joint {arguments.joint} is at most "
          f"{1e3 * np.abs(q - q_d).max():.3f} mrad from its desired position")

    table = arguments.out / "joint.csv"
    np.savetxt(table, np.column_stack([seconds, q, q_d]), delimiter=",", header="time_s,q,q_d", comments="")
    if shutil.which("gnuplot"):
        plot = (f'set terminal pngcairo size 800,400; set output "{arguments.out / "joint.png"}"; set datafile separator ","; '
                f'set xlabel "time, s"; set ylabel "joint {arguments.joint}, rad"; '
                f'plot "{table}" every ::1 using 1:2 with lines title "q", "" every ::1 using 1:3 with lines title "q_d"')
        subprocess.run(["gnuplot", "-e", plot], check=True)

    write_png(arguments.out / "scene.png", log.picture(float(seconds[len(seconds) // 2]), size=(640, 480)))
    print("written to", arguments.out)


if __name__ == "__main__":
    main()
