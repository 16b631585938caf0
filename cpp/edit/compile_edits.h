// SPDX-License-Identifier: GPL-3.0-or-later
// From edits as the artist describes them to those that act.
#pragma once
#include <Imath/ImathBox.h>

#include <span>

#include "base/cancel.h"
#include "base/error.h"
#include "base/image.h"
#include "edit/description.h"
#include "edit/edits.h"
#include "expr/alphabet.h"

namespace sluice {

using Box = Imath::Box<V3d>;

// The scene that edits are compiled for, world coordinates.
struct EditSpace {
  V3d centre{0};  // origin of re-centring
  Box bounds;     // of the scene without quads (may be empty)
};

// World bounds of the quads that will act (enabled, not refused); empty if there are none.
[[nodiscard]] Box quad_bounds(std::span<const EditDescription> edits, const Box& scene_bounds);

// Layers share the edits' alphabet and are read along with them. Throws ExpressionError; degenerate quads and
// unknown names become warnings.
[[nodiscard]] Edits compile_edits(std::span<const EditDescription> descriptions,
                                  std::span<const Entity> entities, std::span<const Image> images,
                                  const EditSpace& space, int max_gates, Warnings& warnings,
                                  std::span<const LayerDescription> layers = {},
                                  const CancelPoint& cancel = {});

}  // namespace sluice
