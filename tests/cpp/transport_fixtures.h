// SPDX-License-Identifier: GPL-3.0-or-later
// What several tests of transport share.
#pragma once
#include "transport/vertex.h"

namespace sluice::test {

// A white diffuse floor, seen from above; no scene is needed.
inline Vertex white_floor(const V3d& position = V3d(0)) {
  const V3f up(0, 0, 1);
  Vertex v;
  v.hit.position = position;
  v.point.ns = v.point.wo = v.bsdf.ng = up;
  v.bsdf.count = 1;
  v.bsdf.lobes[0] = {Event::D, false, false, 0, 1, Color(1), Color(1), up, Lambert{}};
  return v;
}

}  // namespace sluice::test
