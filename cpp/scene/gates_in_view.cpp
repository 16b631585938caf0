// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/gates_in_view.h"

#include <algorithm>
#include <optional>

namespace sluice {
namespace {

constexpr double margin = 1;           // pixels: for what is rounded away, and the slack of a quad's edges
constexpr double least_cosine_in_view = 1e-3;  // beside the camera a projection is not to be relied on

// Pixels, both ends included.
struct Rectangle {
  double x0, y0, x1, y1;
};

// All pixels whose rays may meet the quad, the camera's blur included; empty: none can. Projections keep lines straight and blur is
// largest at a corner, so the corners tell.
std::optional<Rectangle> seen(const Quad& quad, const Camera& camera, const Rectangle& frame, double beside) {
  if (!camera.is_invertible()) return frame;
  std::optional<Rectangle> all;
  int behind = 0;
  for (const V2d& uv : {V2d(0, 0), V2d(1, 0), V2d(0, 1), V2d(1, 1)}) {
    const V3d corner = quad.point(uv);
    const double depth = camera.depth(corner);
    behind += depth < 0;
    const auto pixel = camera.project(corner);
    if (!pixel || !(std::abs(depth) > least_cosine_in_view * (corner - camera.position()).length())) {
      all = frame;
      continue;
    }
    const double around = camera.blur(depth) + beside;
    const Rectangle box{pixel->x - around, pixel->y - around, pixel->x + around, pixel->y + around};
    all = all ? Rectangle{std::min(all->x0, box.x0), std::min(all->y0, box.y0), std::max(all->x1, box.x1), std::max(all->y1, box.y1)} : box;
  }
  return behind == 4 ? std::nullopt : all;
}

}  // namespace

GatesInView::GatesInView(const Edits& edits, const Camera& camera, const PixelFilter& filter, const FrameDescription& frame) {
  const auto blocks = [](int pixels) { return static_cast<std::size_t>((pixels + block_side - 1) / block_side); };
  const std::size_t rows = blocks(frame.height);
  columns_ = blocks(frame.width);
  const Rectangle whole{0, 0, static_cast<double>(frame.width - 1), static_cast<double>(frame.height - 1)};
  const auto mark = [&](const Quad& quad, Side side) {
    auto box = seen(quad, camera, whole, filter.reach() + margin);
    if (!box || !(box->x0 <= whole.x1 && box->y0 <= whole.y1 && box->x1 >= 0 && box->y1 >= 0)) return;
    blocks_[index(side)].resize(rows * columns_);
    const auto block = [](double pixel, double most) { return static_cast<std::size_t>(std::clamp(pixel, 0.0, most)) / block_side; };
    for (std::size_t y = block(box->y0, whole.y1); y <= block(box->y1, whole.y1); ++y)
      for (std::size_t x = block(box->x0, whole.x1); x <= block(box->x1, whole.x1); ++x) blocks_[index(side)][y * columns_ + x] = 1;
  };
  for (int e = 0; e < edits.size(); ++e) {
    const Edit& edit = edits[e];
    if (!contains(edits.takers(edit.side), e)) continue;
    if (edit.side == Side::View) {
      mark(edit.entry, Side::View);
    } else {
      for (const Exit& exit : edit.exits) mark(exit.quad, Side::Light);
    }
  }
}

}  // namespace sluice
