"""Logs of any robot or program in the twin's own columns, in blocks; see docs/reference/robot-logs.md."""
