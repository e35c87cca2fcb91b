"""What the programs of a user of panda-python share."""

import numpy as np

PROGRAMS = {}
HIGH = [100.0] * 7, [100.0] * 7, [100.0] * 6, [100.0] * 6  # thresholds that the moves here do not reach
SENSITIVE = [20.0] * 7, [20.0] * 7, [20.0] * 6, [20.0] * 6
TOUCH = 0.3088  # m, height of the end effector where its fingertips, 8.8 mm below, touch the table


def program(function):
    """For panda_programs.py to run by name."""
    PROGRAMS[function.__name__] = function
    return function


def pose_of(state):
    return np.array(state.O_T_EE).reshape(4, 4).T


def distance(q, goal):
    """The largest of the seven."""
    return float(np.max(np.abs(np.asarray(q) - np.asarray(goal))))
