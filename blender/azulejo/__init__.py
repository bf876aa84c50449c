# SPDX-License-Identifier: MIT OR Apache-2.0
"""Bakes the light of Blender's scenes into lightmaps with the program azulejo."""

import importlib.util

if importlib.util.find_spec("numpy") is None:
    # Blender's own builds have it; packages of distributions may not.
    message = "Blender's Python has no NumPy. On Debian and Ubuntu: sudo apt install python3-numpy"
    raise ImportError(message, name="numpy")

from . import operators, panel, settings

MODULES = (settings, operators, panel)


def register() -> None:
    """Makes properties, operators and panels known to Blender."""
    for module in MODULES:
        module.register()


def unregister() -> None:
    """Withdraws them in the opposite order."""
    for module in reversed(MODULES):
        module.unregister()
