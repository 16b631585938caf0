# SPDX-License-Identifier: GPL-3.0-or-later
"""The types that exporters share. A Description is a dict with the members of the struct of that name in cpp/scene/description.h or
cpp/edit/description.h."""
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

Description: TypeAlias = dict[str, Any]
Warn: TypeAlias = Callable[[str, str], None]  # warn(name of the thing, message)
Rows: TypeAlias = Sequence[Sequence[float]]  # a matrix, Blender's or NumPy's
