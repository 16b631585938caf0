// SPDX-License-Identifier: GPL-3.0-or-later
// Smooth shading normals, made from polygons one after the other: the same bits each time. Blender 3 adds
// them up on threads that race, so that its own differ in their last bits from one reading of a file to the
// next, and glass makes much of a last bit.
//
// The rule is Blender's: the normal at a vertex is the mean of the normals of all polygons there, each
// weighed by its angle. Flat polygons count too, but keep their own.
#pragma once
#include "base/cancel.h"
#include "scene/description.h"

namespace sluice {

void check_mesh(const MeshDescription& mesh);  // compile_check.cpp. Throws SceneError

// Gives a checked mesh that has polygons and no normals its normals, and lets the polygons go: they have
// served.
void make_normals(MeshDescription& mesh, const CancelPoint& cancel = {});

}  // namespace sluice
