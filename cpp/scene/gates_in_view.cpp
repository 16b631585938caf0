// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/gates_in_view.h"

#include <algorithm>
#include <optional>

namespace sluice {
namespace {

constexpr double margin = 1;  // pixels: for what is rounded away, and the slack of a quad's edges
constexpr double min_cosine_in_view = 1e-3;  // beside the camera a projection is not to be relied on

// Pixels, both ends included.
struct Rectangle {
  double x0, y0, x1, y1;
};

// All pixels whose rays may meet the quad, the camera's blur included; empty: none can. Projections keep
// lines straight and blur is largest at a corner, so the corners tell.
std::optional<Rectangle> seen(const Quad& quad, const Camera& camera, const Rectangle& frame, double beside) {
  if (!camera.is_invertible()) return frame;
  std::optional<Rectangle> all;
  int behind = 0;
  for (const V2d& uv : {V2d(0, 0), V2d(1, 0), V2d(0, 1), V2d(1, 1)}) {
    const V3d corner = quad.point(uv);
    const double depth = camera.depth(corner);
    behind += depth < 0;
    const auto pixel = camera.project(corner);
    if (!pixel || !(std::abs(depth) > min_cosine_in_view * (corner - camera.position()).length())) {
      all = frame;
      continue;
    }
    const double around = camera.blur(depth) + beside;
    const Rectangle box{pixel->x - around, pixel->y - around, pixel->x + around, pixel->y + around};
    all = all ? Rectangle{std::min(all->x0, box.x0), std::min(all->y0, box.y0), std::max(all->x1, box.x1),
                          std::max(all->y1, box.y1)}
              : box;
  }
  return behind == 4 ? std::nullopt : all;
}

}  // namespace

GatesInView::GatesInView(const Edits& edits, const Camera& camera, const PixelFilter& filter,
                         const FrameDescription& frame) {
  const auto blocks = [&](int pixels) { return static_cast<std::size_t>((pixels - 1) >> shift_) + 1; };
  while (blocks(frame.width) * blocks(frame.height) > max_blocks) ++shift_;
  columns_ = blocks(frame.width);
  const std::size_t size = columns_ * blocks(frame.height);
  const Rectangle whole{0, 0, static_cast<double>(frame.width - 1), static_cast<double>(frame.height - 1)};
  struct Shown {
    QuadId gate;
    std::size_t from, to;  // blocks: corners of a rectangle
  };
  const auto show = [&](const QuadId& gate, std::vector<Shown>& shown) {
    const auto box = seen(edits.quad(gate.edit, gate.exit), camera, whole, filter.reach() + margin);
    if (!box || !(box->x0 <= whole.x1 && box->y0 <= whole.y1 && box->x1 >= 0 && box->y1 >= 0)) return;
    const auto pixel = [](double p, double most) { return static_cast<int>(std::clamp(p, 0.0, most)); };
    shown.push_back({gate, block(pixel(box->x0, whole.x1), pixel(box->y0, whole.y1)),
                     block(pixel(box->x1, whole.x1), pixel(box->y1, whole.y1))});
  };
  const auto for_blocks = [&](const Shown& gate, const auto& act) {
    for (std::size_t row = gate.from; row <= gate.to; row += columns_)
      for (std::size_t at = row; at <= row + (gate.to - gate.from) % columns_; ++at) act(at);
  };
  for (const Side side : {Side::Light, Side::View}) {
    Blocks& of_side = blocks_[index(side)];
    std::vector<Shown> gates;
    for (int e = 0; e < edits.size(); ++e) {
      if (edits[e].side != side || !contains(edits.could_take(side), e)) continue;
      if (side == Side::View) show({e, QuadId::entry}, gates);
      for (std::size_t x = 0; side == Side::Light && x < edits[e].exits.size(); ++x)
        show({e, static_cast<int>(x)}, gates);
    }
    if (gates.empty()) continue;
    of_side.counts.resize(size);
    for (const Shown& gate : gates)
      for_blocks(gate, [&](std::size_t at) { of_side.counts[at] += of_side.counts[at] <= max_listed; });
    std::uint32_t listed = 0;
    for (const std::uint8_t count : of_side.counts)
      of_side.first.push_back(listed), listed += count <= max_listed ? count : 0;
    of_side.gates.resize(listed);
    std::vector<std::uint32_t> next = of_side.first;
    for (const Shown& shown : gates)
      for_blocks(shown, [&](std::size_t at) {
        if (of_side.counts[at] <= max_listed) of_side.gates[next[at]++] = shown.gate;
      });
  }
}

}  // namespace sluice
