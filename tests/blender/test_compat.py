# SPDX-License-Identifier: GPL-3.0-or-later
"""Both branches of each difference between Blenders, with fakes where this Blender has only one."""
import numpy as np
import pytest
from sluice import compat
from stand_ins import Pass


@pytest.mark.parametrize("flat", [True, False])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_pass_rects(flat, channels):
    pixels = np.random.default_rng(0).random((2, 3, channels))
    for given in (pixels, np.asfortranarray(pixels), pixels[::-1][::-1].astype(np.float32)):
        target = Pass(flat, channels)
        compat.set_pass_rect(target, given)
        np.testing.assert_array_equal(target.rect.stored, pixels.astype(np.float32).ravel())


def test_wrong_channel_counts_are_refused():
    with pytest.raises(ValueError, match="4 channels, not 3"):
        compat.set_pass_rect(Pass(False, 4), np.zeros((2, 3, 3)))


class _Values:
    def __init__(self, **columns):
        self.columns = columns

    def __len__(self):
        return len(next(iter(self.columns.values())))

    def foreach_get(self, name, array):
        array[:] = np.asarray(self.columns[name]).ravel()


class _Old:
    """Mesh of 3.4."""

    has_custom_normals, made = False, False

    def __init__(self, smooth, auto):
        self.polygons = _Values(use_smooth=smooth)
        self.loops = _Values(normal=np.arange(9))
        self.use_auto_smooth = auto

    def calc_normals_split(self):
        self.made = True

    def free_normals_split(self):
        self.made = False


class _New:
    """Mesh of 4.1."""

    def __init__(self, domain):
        self.normals_domain, self.corner_normals = domain, _Values(vector=np.arange(9))


def test_normals():
    assert compat.split_normals(_Old([False, False], True), 3) is None
    assert compat.split_normals(_New('FACE'), 3) is None
    for mesh in (_Old([False, True], True), _New('CORNER')):
        np.testing.assert_array_equal(compat.split_normals(mesh, 3), np.arange(9).reshape(3, 3))
    custom = _Old([False], True)
    custom.has_custom_normals = True
    assert compat.split_normals(custom, 3) is not None and not custom.made
    custom.use_auto_smooth = False  # Blender 3 heeds them with Auto Smooth alone
    assert compat.split_normals(custom, 3) is None


def test_where_normals_race():
    old, auto, new = _Old([True], auto=False), _Old([True], auto=True), _New('POINT')
    assert [compat.shades_by_racing_normals(mesh) for mesh in (old, auto, new)] == [True, False, False]
    assert [compat.builds_on_racing_normals(mesh) for mesh in (old, auto, new)] == [True, True, False]


def test_matrices_have_their_rows_together():
    columns = np.asfortranarray(np.arange(16.0).reshape(4, 4))
    found = compat.matrix(columns)
    assert found.flags.c_contiguous and found.dtype == np.float64 and (found == columns).all()


def test_positions_and_uvs():
    class Mesh:
        vertices = _Values(co=np.arange(6.0).reshape(2, 3))
        attributes = {}
    np.testing.assert_array_equal(compat.vertex_positions(Mesh), np.arange(6).reshape(2, 3))

    class Attribute:
        data = _Values(vector=np.arange(6.0).reshape(2, 3))
    Mesh.attributes = {"position": Attribute}
    np.testing.assert_array_equal(compat.vertex_positions(Mesh), np.arange(6).reshape(2, 3))

    class Old:
        data = _Values(uv=np.arange(4.0).reshape(2, 2))

    class New:
        uv = _Values(vector=np.arange(4.0).reshape(2, 2))
    for layer in (Old, New):
        np.testing.assert_array_equal(compat.uv_corners(layer, 2), np.arange(4).reshape(2, 2))


def test_shader_names():
    class Shaders:
        def __init__(self, known):
            self.known = known
            self.shader = self

        def from_builtin(self, name):
            if name not in self.known:
                raise ValueError(name)
            return name

    assert compat.builtin_shader(Shaders({"FLAT_COLOR"}), "FLAT_COLOR") == "FLAT_COLOR"
    assert compat.builtin_shader(Shaders({"3D_FLAT_COLOR"}), "FLAT_COLOR") == "3D_FLAT_COLOR"
    with pytest.raises(ValueError):
        compat.builtin_shader(Shaders(set()), "FLAT_COLOR")


def test_active_first():
    assert compat.active_first([1, 2, 3], 1) == [2, 1, 3]
    assert compat.active_first([1, 2], 5) == [1, 2] and compat.active_first([], 0) == []
