"""Motions whose log tells of friction, a load or the links: their design, what to expect of them, `panda-twin excite`."""
