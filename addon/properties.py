# SPDX-License-Identifier: GPL-3.0-or-later
"""The properties artists see and scripts use: scene.sluice, object.sluice, view_layer.sluice. Their names are public (design §8).

An edit lives on its Empty: keyframes, copies, parents and library overrides of the object are the edit's own."""
import math
from typing import Any, Literal

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import model, passes, render_progress, renaming

OVERRIDABLE: set[Literal['LIBRARY_OVERRIDABLE']] = {'LIBRARY_OVERRIDABLE'}


def _tag_owner(self: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """A property of an add-on does not wake the viewport by itself; tagging its owner does."""
    self.id_data.update_tag()


def _tag_object(self: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    # An edit sits on an Empty, so this tag makes Blender update no geometry.
    self.id_data.update_tag(refresh={'OBJECT'})


def _expression_changed(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    renaming.expression_changed()
    if isinstance(self.id_data, bpy.types.Object):
        _tag_object(self, context)
    else:
        _tag_owner(self, context)


def _role_changed(self: Any, context: bpy.types.Context) -> None:
    """An Empty that becomes part of an edit gets an order, one above all others, so that it is unique."""
    owner = self.id_data
    others = {item.sluice.order for item in bpy.data.objects if item != owner and item.sluice.role != 'NONE'}
    if self.role != 'NONE' and (self.order == 0 or self.order in others):
        self.order = max(others, default=0) + 1
    renaming.expression_changed()
    _tag_object(self, context)


def _is_entry(_self: object, candidate: bpy.types.Object) -> bool:
    return model.is_entry(candidate)


class _EntrySettings:
    """What an entry does. Blender registers these properties as SluiceObject's own."""

    expression: StringProperty(
        name="Expression", description="Which light is captured, by what happened to it since its source. LS+: caustics; "
        "L: direct light; L.*D: light that bounced off something diffuse; names in quotes: LS'Glass egg'+",
        default="LS+", maxlen=1024, override=OVERRIDABLE, update=_expression_changed)
    enabled: BoolProperty(
        name="Enabled", description="Let this edit act", default=True, override=OVERRIDABLE, update=_tag_object)
    repeat: BoolProperty(
        name="Repeat", description="May act more than once on one path of light", default=False, override=OVERRIDABLE,
        update=_tag_object)
    amount: FloatProperty(
        name="Amount", description="How much of the matching light the entry takes; the rest goes on as if there were no edit",
        subtype='FACTOR', default=1.0, min=0.0, max=1.0, override=OVERRIDABLE, update=_tag_object)
    feather: FloatProperty(
        name="Feather", description="Width of the entry's soft border, as a fraction of half its side", subtype='FACTOR',
        default=0.0, min=0.0, max=1.0, override=OVERRIDABLE, update=_tag_object)


class _ExitSettings:
    """What becomes of the light that leaves by an exit. Blender registers these properties as SluiceObject's own."""

    intensity: FloatProperty(
        name="Intensity", description="Factor on the energy that leaves here", default=1.0, min=0.0, soft_max=10.0, max=1e4,
        override=OVERRIDABLE, update=_tag_object)
    hue_shift: FloatProperty(
        name="Hue Shift", description="Turns the colour of the light on the hue circle, at the same brightness; white light stays white: "
        "Tint colours that", subtype='ANGLE', default=0.0, soft_min=-math.pi, soft_max=math.pi, override=OVERRIDABLE, update=_tag_object)
    tint: FloatVectorProperty(
        name="Tint", description="Colours the light that leaves here, after the hue shift; white light stays as bright as it was. White, and "
        "any grey, leaves colours as they are", subtype='COLOR', size=3, default=(1.0, 1.0, 1.0), min=0.0, soft_max=1.0, override=OVERRIDABLE,
        update=_tag_object)
    keep_brightness: BoolProperty(
        name="Keep Brightness", description="Scale the energy by the area of the exit over that of the entry, so that a larger "
        "exit is as bright as the entry was; off: the energy is kept, and a larger exit is darker", default=True,
        override=OVERRIDABLE, update=_tag_object)
    intensity_texture: PointerProperty(
        name="Intensity Texture", description="Its linear luminance times the intensity, across the exit", type=bpy.types.Image,
        override=OVERRIDABLE, update=_tag_object)
    hue_shift_texture: PointerProperty(
        name="Hue Shift Texture", description="Its linear luminance times the hue shift, across the exit", type=bpy.types.Image,
        override=OVERRIDABLE, update=_tag_object)
    normal_map: PointerProperty(
        name="Normal Map", description="Turns the light that leaves, by a tangent space normal map across the exit",
        type=bpy.types.Image, override=OVERRIDABLE, update=_tag_object)


class SluiceObject(_EntrySettings, _ExitSettings, bpy.types.PropertyGroup):
    """The entry or the exit of an edit, on an Empty."""

    role: EnumProperty(
        name="Role", description="What this Empty is to the light", default='NONE', override=OVERRIDABLE, update=_role_changed,
        items=(('NONE', "None", "An Empty like any other"),
               ('ENTRY', "Entry", "Captures the light whose path so far matches the expression"),
               ('EXIT', "Exit", "Sends out again what its entry captured")))
    order: IntProperty(
        name="Order", description="Quads that lie in one plane act in this order, lower ones first; a copy has that of its original",
        default=0, min=0, soft_max=1000, override=OVERRIDABLE, update=_tag_object)
    offset: FloatProperty(
        name="Offset", description="Distance at which the quad floats in front of its plane, for bumpy surfaces; a hair's breadth "
        "is always added", subtype='DISTANCE', default=0.0, soft_min=0.0, soft_max=1.0, precision=4, override=OVERRIDABLE,
        update=_tag_object)
    entry: PointerProperty(
        name="Entry", description="The entry whose light leaves here", type=bpy.types.Object, poll=_is_entry,
        override=OVERRIDABLE, update=_tag_object)


EXIT_PROPERTIES = ("offset", *_ExitSettings.__annotations__)  # A new exit takes these over from the one that it is made of.


class SluiceScene(bpy.types.PropertyGroup):
    """Settings of the render."""

    passes: IntProperty(
        name="Passes", description="Passes of the final render; the image is their mean", default=64, min=1, soft_max=4096,
        max=1 << 24, override=OVERRIDABLE, update=_tag_owner)
    photons: IntProperty(
        name="Photons", description="Photons that the lights send out in each pass", default=200000, min=1, soft_min=1000,
        soft_max=5000000, max=1 << 28, override=OVERRIDABLE, update=_tag_owner)
    seed: IntProperty(
        name="Seed", description="Another seed gives other noise; the same one the same image, bit by bit", default=0, min=0,
        override=OVERRIDABLE, update=_tag_owner)
    use_animated_seed: BoolProperty(
        name="Animated Seed", description="Another seed in each frame, so that noise moves instead of sticking to the screen",
        default=False, override=OVERRIDABLE, update=_tag_owner)
    use_adaptive_sampling: BoolProperty(
        name="Adaptive Sampling", description="More samples and lights asked where a pilot finds noise. The viewport goes without",
        default=True, override=OVERRIDABLE, update=_tag_owner)
    use_preview_denoise: BoolProperty(
        name="Denoise Viewport", description="Remove the noise of rendered mode from the fourth pass on, beside Blender, with the Python "
        "package pyoidn (Open Image Denoise)", default=False, override=OVERRIDABLE, update=_tag_owner)
    max_depth: IntProperty(
        name="Max Depth", description="Longest path from light to eye, in interactions", default=12, min=1, soft_max=64, max=250,
        override=OVERRIDABLE, update=_tag_owner)
    max_gates: IntProperty(
        name="Max Edits per Path", description="How many times edits may act on one path of light", default=8, min=1,
        soft_max=32, max=63, override=OVERRIDABLE, update=_tag_owner)
    specular_threshold: FloatProperty(
        name="Specular Threshold", description="Roughness up to which a reflection or refraction counts as specular (S) in "
        "expressions and is followed like a mirror", subtype='FACTOR', default=0.1, min=0.0, max=1.0, override=OVERRIDABLE,
        update=_tag_owner)
    time_limit: FloatProperty(
        name="Time Limit", description="Stop after this time, 0 for none", unit='TIME_ABSOLUTE', default=0.0, min=0.0,
        soft_max=3600.0, step=100, precision=1, override=OVERRIDABLE, update=_tag_owner)
    error_target: FloatProperty(
        name="Error Target", description=f"Stop when the error falls below this, 0 for none. {render_progress.ERROR}",
        subtype='PERCENTAGE', default=0.0, min=0.0, max=100.0, precision=2, override=OVERRIDABLE, update=_tag_owner)
    use_direct: BoolProperty(
        name="Direct", description="Light that arrives straight from its source", default=True, override=OVERRIDABLE,
        update=_tag_owner)
    use_caustics: BoolProperty(
        name="Caustics", description="Light that arrives from a mirror or through glass", default=True, override=OVERRIDABLE,
        update=_tag_owner)
    use_edited: BoolProperty(
        name="Edited Light", description="Light that arrives through the exit of an edit", default=True, override=OVERRIDABLE,
        update=_tag_owner)
    use_indirect: BoolProperty(
        name="Indirect", description="Light that arrives from another lit surface", default=True, override=OVERRIDABLE,
        update=_tag_owner)
    use_edits: BoolProperty(
        name="Light Edits", description="All edits at once: off shows the scene as it is", default=True, override=OVERRIDABLE,
        update=_tag_owner)
    solo: PointerProperty(
        name="Solo", description="The entry of the edit that acts alone, none for all", type=bpy.types.Object, poll=_is_entry,
        override=OVERRIDABLE, update=_tag_owner)


def _layer_renamed(self: Any, _context: bpy.types.Context) -> None:
    """Each pass needs a name of its own: a new name makes way for the others. Then the compositor learns of it."""
    for view_layer in self.id_data.view_layers:
        layers = list(view_layer.sluice.layers)
        if self not in layers:
            continue
        name = passes.clean_name(self.name, [item.name for item in layers if item != self])
        if name != self.name:
            renaming.notice(f"Light layer '{self.name}' is called '{name}' now: a pass needs a name of its own")
            self.name = name  # This calls the function again, which then tells the compositor.
        else:
            view_layer.update_render_passes()


class SluiceLayer(bpy.types.PropertyGroup):
    """A render pass that holds the light whose whole path matches an expression."""

    name: StringProperty(name="Name", description="Name of the render pass", override=OVERRIDABLE, update=_layer_renamed)
    expression: StringProperty(
        name="Expression", description="Which light this pass shows, by its whole path from L to E. LDE: direct light on matte "
        "things; L.*F'Edit'.*E: what an edit moved; L'Key'.*E: all light of one lamp", default="L.*E", maxlen=1024,
        override=OVERRIDABLE, update=_expression_changed)


def _pass_switched(self: Any, _context: bpy.types.Context) -> None:
    """The compositor learns which passes there are now."""
    for view_layer in self.id_data.view_layers:
        if view_layer.sluice == self:
            view_layer.update_render_passes()


class _PassSwitches:
    """Which render passes a picture has beside Combined. Blender registers these properties as SluiceViewLayer's own."""

    __annotations__ = {
        f"use_pass_{name.lower()}": BoolProperty(
            name=name, description=shows, default=name == "Noise", override=OVERRIDABLE, update=_pass_switched)
        for name, shows in passes.SHOWS.items()
    }


class SluiceViewLayer(_PassSwitches, bpy.types.PropertyGroup):
    """Settings of a view layer."""

    layers: CollectionProperty(
        name="Light Layers", description="Render passes chosen by an expression", type=SluiceLayer,
        override={'LIBRARY_OVERRIDABLE', 'USE_INSERTION'})
    use_denoise: BoolProperty(
        name="Denoise", description="Remove the noise of a final render at its end, with the Python package pyoidn (Open Image Denoise); the pass "
        "Noisy Image keeps the picture as it was rendered. Set Up Denoising uses the compositor instead where it can",
        default=False, override=OVERRIDABLE, update=_pass_switched)
    active_layer: IntProperty(
        name="Active Light Layer", description="The light layer that the panel shows", default=0, min=0, max=62, override=OVERRIDABLE)


_classes = (SluiceObject, SluiceScene, SluiceLayer, SluiceViewLayer)
_owners = ((bpy.types.Object, SluiceObject), (bpy.types.Scene, SluiceScene), (bpy.types.ViewLayer, SluiceViewLayer))


def register() -> None:
    for cls in _classes:
        bpy.utils.register_class(cls)
    for owner, cls in _owners:
        owner.sluice = PointerProperty(type=cls, override=OVERRIDABLE)


def unregister() -> None:
    for owner, _cls in _owners:
        del owner.sluice
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
