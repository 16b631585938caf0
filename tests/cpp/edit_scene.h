// SPDX-License-Identifier: GPL-3.0-or-later
// Edits for tests, described as an exporter would.
#pragma once
#include <cmath>
#include <random>
#include <string>

#include "edit/compile_edits.h"

namespace sluice {

// Rows are the images of local X, Y, Z and the place.
inline M44d placed(const V3d& x, const V3d& y, const V3d& z, const V3d& at) {
  return M44d(x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, at.x, at.y, at.z, 1);
}
inline M44d at(const V3d& place) { return placed({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, place); }

inline std::string numbered(const char* name, int number) {
  return std::string(name).append(std::to_string(number));
}

inline V3d random_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const V3d v(normal(random), normal(random), normal(random));
  return v.normalized();
}

// A rotated square of half side `half`; sheared, stretched and mirrored as well if `affine`.
inline M44d random_placement(std::mt19937_64& random, const V3d& place, bool affine = false) {
  std::uniform_real_distribution<double> unit(0, 1);
  const V3d x = random_direction(random), z = x.cross(random_direction(random)).normalized(), y = z.cross(x);
  if (!affine) return placed(x, y, z, place);
  return placed(x * (0.2 + unit(random)), y * (0.2 + unit(random)) + x * (unit(random) - 0.5),
                (unit(random) < 0.5 ? z : -z) + x * 0.3, place);
}

inline QuadDescription quad(const std::string& name, const M44d& matrix, int order, double half = 1) {
  QuadDescription q;
  q.name = name;
  q.matrix = matrix;
  q.half_size = half;
  q.order = order;
  return q;
}

inline ExitDescription exit_at(const std::string& name, const M44d& matrix, int order = 1000,
                               double half = 1) {
  ExitDescription x;
  x.quad = quad(name, matrix, order, half);
  return x;
}

inline EditDescription edit_at(const std::string& name, const M44d& matrix, const std::string& expression,
                               int order, double half = 1) {
  EditDescription e;
  e.entry = quad(name, matrix, order, half);
  e.expression = expression;
  return e;
}

struct TestEdits {
  Warnings warnings;
  Edits edits;

  explicit TestEdits(const std::vector<EditDescription>& descriptions,
                     const std::vector<Entity>& entities = {Entity{}}, const V3d& centre = V3d(0),
                     const Box& bounds = {}, int max_gates = 8, const std::vector<Image>& images = {})
      : edits(compile_edits(descriptions, entities, images, {centre, bounds}, max_gates, warnings)) {}
};

inline double uniform(std::mt19937_64& random, double low = 0, double high = 1) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline V3f to_float(const V3d& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
inline V3d to_double(const V3f& v) { return {v.x, v.y, v.z}; }

struct Setting : TestEdits {
  StateTable table{edits};
  StateId lit = table.next(StateTable::light_start, edits.event_class(Event::L, -1));
  StateId diffuse = table.next(lit, edits.event_class(Event::D, -1));
  using TestEdits::TestEdits;

  std::optional<Crossing> taken(const V3d& o, const V3d& d, double t_max = 1e9, int excluded = -1) {
    return edits.first_taken(table, lit, {o, d, 0, t_max, excluded});
  }
};

inline const M44d flat = at(V3d(0));

}  // namespace sluice
