"""What is measured of a soak: samples of the server's process, rows as time passes, and the table of bounds."""

import statistics

from serve_rounds_test import Usage

WARM_UP = 5  # samples until everything has been used once
MB_PER_HOUR = 1.0  # of memory, at most; of less than an hour: in all


class Samples:
    """Usage of a process over time."""

    def __init__(self, process):
        self.process = process
        self.hours, self.usages = [], []

    def take(self, hours):
        self.hours.append(hours)
        self.usages.append(Usage(self.process))
        return self.usages[-1]

    def values(self, what):
        return [getattr(usage, what) for usage in self.usages]

    def growth(self, what):
        """Of the most since the warm-up over the most within it."""
        values = self.values(what)
        return max(values[WARM_UP:], default=values[-1]) - max(values[:WARM_UP])

    def memory_slope(self):
        """MB per hour since the warm-up, by least squares; 0 of less than two samples."""
        x, y = self.hours[WARM_UP:], [kb / 1024 for kb in self.values("memory_kb")[WARM_UP:]]
        if len(x) < 2:
            return 0.0
        return statistics.linear_regression(x, y).slope


class Findings:
    """Figures, and bounds on some of them."""

    def __init__(self):
        self.rows = []

    def figure(self, name, value):
        self.rows.append((name, value, "", None))

    def bound(self, name, value, demand, holds):
        self.rows.append((name, value, demand, holds))

    def usage(self, samples):
        """The bounds on the server's process."""
        hours = samples.hours[-1]
        slope = samples.memory_slope()
        memory = samples.values("memory_kb")
        self.figure("memory, first and last", f"{memory[0] / 1024:.2f} MB, {memory[-1] / 1024:.2f} MB")
        self.bound("memory slope", f"{slope:.3f} MB/h", f"<= {MB_PER_HOUR} MB/h, or in all within the first hour",
                   slope * min(hours, 1.0) <= MB_PER_HOUR)
        for what, most in (("descriptors", 1), ("threads", 1)):  # a connection may be closing while they are counted
            growth = samples.growth(what)
            self.bound(f"growth of {what}", f"{growth} over {max(samples.values(what)[:WARM_UP])}", f"<= {most}", growth <= most)

    def show(self):
        """Prints the table. @returns whether all bounds hold."""
        print(f"\n| {'figure':32} | {'value':40} | {'bound':48} | holds |\n|---|---|---|---|")
        for name, value, demand, holds in self.rows:
            print(f"| {name:32} | {value!s:40} | {demand:48} | {'' if holds is None else 'yes' if holds else '**NO**':5} |")
        return all(holds is not False for *_, holds in self.rows)


class Progress:
    """A row per quarter of an hour, or per minute of a short soak."""

    def __init__(self, hours):
        self.step = 0.25 if hours >= 2 else 1 / 60
        self.next = self.step

    def row(self, hours, usage, rest):
        if hours < self.next:
            return
        self.next = (hours // self.step + 1) * self.step
        print(f"{hours:8.3f} h  {usage.memory_kb / 1024:8.2f} MB  {usage.descriptors} descriptors  {usage.threads} threads  {rest}",
              flush=True)
