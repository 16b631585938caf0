// SPDX-License-Identifier: GPL-3.0-or-later
// Quads of edits for the oracles, written down a second time from design §2 and §4 and looped over by brute
// force: floating planes, crossings, the transform T of paper §4.2 with its gains, H. Shares nothing with
// cpp/edit but plain descriptions and image lookup.
#pragma once
#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "scene/scene.h"

namespace sluice::oracle {

struct Gate {
  int edit, exit;  // exit -1: the entry
  bool of_view;    // of a view edit
  V3d corner, u, v;
  V3d t, b, n;
  double area;
  int order;
  int plane = -1;

  [[nodiscard]] V3d point(const V2d& uv) const { return corner + u * uv.x + v * uv.y; }
  [[nodiscard]] V3d middle() const { return point({0.5, 0.5}); }
  [[nodiscard]] bool is_entry() const { return exit < 0; }
};

struct Meeting {  // a ray meets a quad
  double t;
  V2d uv;
  const Gate* gate;
};

// The few that a segment or a point meets.
class Meetings {
 public:
  void push_back(const Meeting& m) { met_.at(count_++) = m; }
  [[nodiscard]] auto begin() const { return met_.begin(); }
  [[nodiscard]] auto end() const { return met_.begin() + static_cast<std::ptrdiff_t>(count_); }
  [[nodiscard]] auto begin() { return met_.begin(); }
  [[nodiscard]] auto end() { return met_.begin() + static_cast<std::ptrdiff_t>(count_); }
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  const Meeting& operator[](std::size_t i) const { return met_[i]; }

 private:
  std::array<Meeting, 48> met_;
  std::size_t count_ = 0;
};

// What T does to a path, besides H: where and in which direction it goes on, times what.
struct Turned {
  V3d position, direction;
  double gain;
  double hue;
  V3d tint;  // after H
};

inline double luma(const V3d& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

// H of design §4 by way of HSV: turn, back, same luminance.
inline V3d turned_hue(const V3d& c, double angle) {
  const double high = std::max({c.x, c.y, c.z}), low = std::min({c.x, c.y, c.z}), range = high - low;
  if (angle == 0 || range <= 0) return c;
  double h = c.x == high   ? (c.y - c.z) / range
             : c.y == high ? 2 + (c.z - c.x) / range
                           : 4 + (c.x - c.y) / range;
  h = std::fmod(h + angle * 3 / std::numbers::pi, 6.0);
  if (h < 0) h += 6;
  const double x = 1 - std::abs(std::fmod(h, 2.0) - 1);
  static constexpr int highest[] = {0, 1, 1, 2, 2, 0}, between[] = {1, 0, 2, 1, 0, 2};
  const int sector = std::min(static_cast<int>(h), 5);
  V3d out(low);
  out[highest[sector]] += range, out[between[sector]] += range * x;
  return out * (luma(c) / luma(out));
}

class Gates {
 public:
  Gates(const SceneDescription& description, const Scene& scene)
      : edits_(description.edits), images_(description.images) {
    for (int e = 0; e < static_cast<int>(edits_.size()); ++e) {
      const EditDescription& edit = edits_[static_cast<std::size_t>(e)];
      if (!edit.enabled) continue;
      const bool of_view = edit.expression.find_last_of("EC") == edit.expression.size() - 1;
      gates_.push_back(make(edit.entry, e, -1, of_view, scene.centre()));
      for (std::size_t x = 0; x < edit.exits.size(); ++x)
        gates_.push_back(make(edit.exits[x].quad, e, static_cast<int>(x), of_view, scene.centre()));
    }
    // design §2: m about the centre of all quads, w of everything
    V3d low(1e300), high(-1e300), world_low(0), world_high(0);
    const auto extend = [](V3d& a, V3d& b, const V3d& p) {
      for (int i = 0; i < 3; ++i) a[i] = std::min(a[i], p[i]), b[i] = std::max(b[i], p[i]);
    };
    for (const Gate& g : gates_)
      for (const V2d& uv : {V2d(0, 0), V2d(1, 0), V2d(0, 1), V2d(1, 1)})
        extend(low, high, g.point(uv)), extend(world_low, world_high, g.point(uv) + scene.centre());
    if (!scene.geometry_bounds().empty())
      for (const V3d& p : {scene.geometry_bounds().low, scene.geometry_bounds().high})
        extend(world_low, world_high, p + scene.centre());
    double m = 0, w = 0;
    for (int i = 0; i < 3; ++i)
      m = std::max(m, (high[i] - low[i]) / 2), w = std::max({w, -world_low[i], world_high[i]});
    delta_ = std::max(std::ldexp(m, -17), std::ldexp(w, -22));
    for (Gate& g : gates_) g.corner += g.n * (delta_ + quad(g).offset);
    find_planes();
  }

  [[nodiscard]] double delta() const { return delta_; }
  [[nodiscard]] bool empty() const { return gates_.empty(); }
  [[nodiscard]] const EditDescription& edit(int e) const { return edits_[static_cast<std::size_t>(e)]; }
  [[nodiscard]] const Gate& gate(int edit, int exit) const {
    return *std::find_if(gates_.begin(), gates_.end(),
                         [&](const Gate& g) { return g.edit == edit && g.exit == exit; });
  }
  [[nodiscard]] bool has_view_edits() const {
    return std::any_of(gates_.begin(), gates_.end(), [](const Gate& g) { return g.of_view; });
  }

  // All quads on the segment, 0 < t <= t_end, by t, then order.
  [[nodiscard]] Meetings along(const V3d& origin, const V3d& direction, double t_end,
                               int skipped_plane) const {
    Meetings met;
    for (const Gate& g : gates_) {
      if (g.plane == skipped_plane) continue;
      const Plane& plane = planes_[static_cast<std::size_t>(g.plane)];
      const double cosine = plane.n.dot(direction);
      if (std::abs(cosine) < 1e-6) continue;
      const double t = (plane.c - plane.n.dot(origin)) / cosine;
      if (!(t > 0 && t <= t_end)) continue;
      if (const auto uv = locate(g, origin + direction * t)) met.push_back({t, *uv, &g});
    }
    std::sort(met.begin(), met.end(), [](const Meeting& a, const Meeting& b) {
      return std::tuple(a.t, a.gate->order) < std::tuple(b.t, b.gate->order);
    });
    return met;
  }
  // All quads of a plane at one of its points, by order.
  [[nodiscard]] Meetings at(int plane, const V3d& point) const {
    Meetings met;
    for (const Gate& g : gates_)
      if (g.plane == plane)
        if (const auto uv = locate(g, point)) met.push_back({0, *uv, &g});
    std::sort(met.begin(), met.end(),
              [](const Meeting& a, const Meeting& b) { return a.gate->order < b.gate->order; });
    return met;
  }

  // a(u, v): amount times the soft border.
  [[nodiscard]] double weight(int edit, const V2d& uv) const {
    const EditDescription& e = this->edit(edit);
    double a = e.amount;
    for (const double x : {uv.x, uv.y}) {
      if (!(e.feather > 0)) continue;
      const double s = std::min(1.0, 2 * std::min(x, 1 - x) / static_cast<double>(e.feather));
      a *= s * s * (3 - 2 * s);
    }
    return a;
  }

  // Light of a light edit, or a view ray of a view edit, from the entry out of an exit. Flux gain (view
  // edits: of radiance).
  [[nodiscard]] std::optional<Turned> forward(int edit, int exit, const V2d& uv, const V3d& d) const {
    const Gate &in = gate(edit, -1), &out = gate(edit, exit);
    const ExitDescription& x = this->edit(edit).exits[static_cast<std::size_t>(exit)];
    V3d local(d.dot(in.t), d.dot(in.b), d.dot(in.n));
    if (const auto n = normal(x, uv)) local = rotated(local, {0, 0, 1}, *n);
    if (x.normal_map >= 0 && std::abs(local.z) < 1e-3 && !in.of_view) return {};
    const double area_ratio = x.keep_brightness && !in.of_view ? out.area / in.area : 1;
    return Turned{out.point(uv), out.t * local.x + out.b * local.y + out.n * local.z,
                  intensity(x, uv) * area_ratio, hue(x, uv), tint(x)};
  }
  // A view ray meets an exit of a light edit; on from the entry. Radiance gain.
  [[nodiscard]] std::optional<Turned> backward(int edit, int exit, const V2d& uv, const V3d& d) const {
    const Gate &in = gate(edit, -1), &out = gate(edit, exit);
    const ExitDescription& x = this->edit(edit).exits[static_cast<std::size_t>(exit)];
    V3d local(d.dot(out.t), d.dot(out.b), d.dot(out.n));
    const double cos_out = std::abs(local.z);
    if (const auto n = normal(x, uv)) local = rotated(local, *n, {0, 0, 1});
    if (x.normal_map >= 0 && cos_out < 1e-3) return {};
    const double gain =
        intensity(x, uv) * (x.keep_brightness ? 1 : in.area / out.area) * std::abs(local.z) / cos_out;
    return Turned{in.point(uv), in.t * local.x + in.b * local.y + in.n * local.z, gain, hue(x, uv), tint(x)};
  }

 private:
  struct Plane {
    V3d n;
    double c;
    int order;
  };

  [[nodiscard]] const QuadDescription& quad(const Gate& g) const {
    return g.is_entry() ? edit(g.edit).entry : edit(g.edit).exits[static_cast<std::size_t>(g.exit)].quad;
  }

  static Gate make(const QuadDescription& q, int edit, int exit, bool of_view, const V3d& centre) {
    const auto row = [&](int i) { return V3d(q.matrix[i][0], q.matrix[i][1], q.matrix[i][2]); };
    Gate g{};
    g.edit = edit, g.exit = exit, g.of_view = of_view, g.order = q.order;
    g.u = row(0) * (2 * q.half_size), g.v = row(1) * (2 * q.half_size);
    g.corner = row(3) - centre - (g.u + g.v) * 0.5;
    const V3d across = g.u.cross(g.v);
    g.area = across.length();
    g.n = across / g.area;
    if (g.n.dot(row(2)) < 0) g.n = -g.n;
    g.t = g.u.normalized();
    g.b = g.n.cross(g.t);
    if (g.b.dot(g.v) < 0) g.b = -g.b;
    return g;
  }

  // Normals equal up to sign, planes within δ/2 (design §2): one plane, that of the lowest order.
  void find_planes() {
    for (std::size_t i = 0; i < gates_.size(); ++i) gates_[i].plane = static_cast<int>(i);
    for (const Gate& a : gates_)
      for (Gate& b : gates_) {
        if (a.plane == b.plane || std::abs(a.n.dot(b.n)) < 1 - 1e-8 ||
            std::abs((b.middle() - a.middle()).dot(a.n)) > delta_ / 2)
          continue;
        const int from = b.plane, to = a.plane;
        for (Gate& g : gates_)
          if (g.plane == from) g.plane = to;
      }
    planes_.resize(gates_.size(), {V3d(0), 0, std::numeric_limits<int>::max()});
    for (const Gate& g : gates_)
      if (Plane& p = planes_[static_cast<std::size_t>(g.plane)]; g.order < p.order)
        p = {g.n, g.n.dot(g.middle()), g.order};
    for (Gate& g : gates_) {  // onto the common plane
      const Plane& p = planes_[static_cast<std::size_t>(g.plane)];
      g.corner -= p.n * (p.n.dot(g.corner) - p.c);
    }
  }

  [[nodiscard]] static std::optional<V2d> locate(const Gate& g, const V3d& p) {
    const V3d r = p - g.corner;
    const double uu = g.u.dot(g.u), uv = g.u.dot(g.v), vv = g.v.dot(g.v), ru = r.dot(g.u), rv = r.dot(g.v),
                 det = uu * vv - uv * uv;
    const double a = (ru * vv - rv * uv) / det, b = (rv * uu - ru * uv) / det, slack = 1e-12;
    if (!(a >= -slack && a <= 1 + slack && b >= -slack && b <= 1 + slack)) return {};
    return V2d(std::clamp(a, 0.0, 1.0), std::clamp(b, 0.0, 1.0));
  }

  [[nodiscard]] double texture(int image, const V2d& uv) const {
    return luminance(sample_clamped(images_[static_cast<std::size_t>(image)], static_cast<float>(uv.x),
                                    static_cast<float>(uv.y)));
  }
  [[nodiscard]] double intensity(const ExitDescription& x, const V2d& uv) const {
    return x.intensity * (x.intensity_texture >= 0 ? texture(x.intensity_texture, uv) : 1);
  }
  [[nodiscard]] double hue(const ExitDescription& x, const V2d& uv) const {
    return x.hue_shift * (x.hue_shift_texture >= 0 ? texture(x.hue_shift_texture, uv) : 1);
  }
  // What white light becomes: no brighter, no darker.
  [[nodiscard]] static V3d tint(const ExitDescription& x) {
    return luma(V3d(x.tint)) > 0 ? V3d(x.tint) / luma(V3d(x.tint)) : V3d(1);
  }
  [[nodiscard]] std::optional<V3d> normal(const ExitDescription& x, const V2d& uv) const {
    if (x.normal_map < 0) return {};
    const Color c = sample_clamped(images_[static_cast<std::size_t>(x.normal_map)], static_cast<float>(uv.x),
                                   static_cast<float>(uv.y));
    return V3d(2.0 * c.x - 1, 2.0 * c.y - 1, 2.0 * c.z - 1).normalized();
  }
  // The shortest turn that takes unit `from` to unit `to` (Rodrigues): M_d of the paper for a normal map.
  [[nodiscard]] static V3d rotated(const V3d& d, const V3d& from, const V3d& to) {
    const V3d axis = from.cross(to);
    return d * from.dot(to) + axis.cross(d) + axis * (axis.dot(d) / (1 + from.dot(to)));
  }

  std::vector<EditDescription> edits_;
  std::vector<Image> images_;
  std::vector<Gate> gates_;
  std::vector<Plane> planes_;
  double delta_ = 0;
};

}  // namespace sluice::oracle
