// SPDX-License-Identifier: GPL-3.0-or-later
// Area lamps. Cycles: P watts on area A have radiance P / (4 A) on the front side, so flux pi P / 4. A spread
// s < 180° keeps the flux: factor (1 - tan(x) / tan(s/2)) / (1 - (s/2) / tan(s/2)) at angle x from the
// normal, the shadow of a grid of slats. Seen from a point, only the part of the lamp within the spread
// lights it: that part is sampled, a rectangle by solid angle when it is large.
#include "scene/light_kinds.h"
#include "scene/spherical_rectangle.h"

namespace sluice::kinds {
namespace {

float spread_factor(const AreaLamp& lamp, float cosine) noexcept {
  if (lamp.spread_cot == 0) return 1;
  const float tangent = std::sqrt(std::max(0.0f, 1 - cosine * cosine)) / cosine;
  return std::max(0.0f, 1 - lamp.spread_cot * tangent) * lamp.spread_scale;
}

float clearance_of(const AreaLamp& lamp) noexcept {
  return 0x1p-20f * static_cast<float>(
                        std::max({std::abs(lamp.centre.x), std::abs(lamp.centre.y), std::abs(lamp.centre.z),
                                  static_cast<double>(lamp.half_u), static_cast<double>(lamp.half_v)}));
}

bool contains(const AreaLamp& lamp, double x, double y) noexcept {
  const double a = x / lamp.half_u, b = y / lamp.half_v;
  return lamp.round ? a * a + b * b <= 1 : std::abs(a) <= 1 && std::abs(b) <= 1;
}

// How the lamp is sampled from one point: the rectangle of it that can light the point, in the lamp's axes
// around its centre.
struct View {
  V3d at;  // the point, lamp coordinates; z in front
  double x0, x1, y0, y1;
  enum class Way { Ellipse, Rectangle, SolidAngle } way;
};

std::optional<View> view_from(const AreaLamp& lamp, const V3d& from) noexcept {
  const V3d to = from - lamp.centre;
  View view{{to.dot(V3d(lamp.axis_u)), to.dot(V3d(lamp.axis_v)), to.dot(V3d(lamp.normal))},
            -lamp.half_u,
            lamp.half_u,
            -lamp.half_v,
            lamp.half_v,
            View::Way::Rectangle};
  if (!(view.at.z > 0)) return {};
  if (lamp.spread_cot > 0) {
    const double reach = view.at.z / lamp.spread_cot;
    view.x0 = std::max(view.x0, view.at.x - reach), view.x1 = std::min(view.x1, view.at.x + reach);
    view.y0 = std::max(view.y0, view.at.y - reach), view.y1 = std::min(view.y1, view.at.y + reach);
    if (!(view.x0 < view.x1 && view.y0 < view.y1)) return {};
  }
  const double area = (view.x1 - view.x0) * (view.y1 - view.y0);
  if (lamp.round) {
    // a small part is drawn as a rectangle, of which what lies outside of the ellipse is thrown away
    if (area > 0.5 * lamp.area) view.way = View::Way::Ellipse;
  } else if (area > 0.02 * view.at.length2()) {
    view.way = View::Way::SolidAngle;
  }
  return view;
}

SphericalRectangle spherical(const View& view) noexcept {
  return {view.x0 - view.at.x, view.x1 - view.at.x, view.y0 - view.at.y, view.y1 - view.at.y, view.at.z};
}

float area_density(const AreaLamp& lamp, const View& view) noexcept {
  return view.way == View::Way::Ellipse ? 1 / lamp.area
                                        : static_cast<float>(1 / ((view.x1 - view.x0) * (view.y1 - view.y0)));
}

}  // namespace

std::optional<Light> make_area_lamp(const LightDescription& d, const V3d& centre) {
  const bool one_size = d.shape == AreaShape::Square || d.shape == AreaShape::Disk;
  V3d u = row_of(d, 0) * static_cast<double>(d.size_x),
      v = row_of(d, 1) * static_cast<double>(one_size ? d.size_x : d.size_y);
  V3d n = u.cross(v);
  const double area = n.length();
  if (!(area > 0) || !std::isfinite(static_cast<float>(1 / area))) return {};
  n /= n.dot(row_of(d, 2)) > 0 ? -area : area;  // it shines along local -Z
  AreaLamp lamp;
  lamp.centre = row_of(d, 3) - centre;
  lamp.normal = V3f(n);
  lamp.half_u = static_cast<float>(u.length() / 2), lamp.half_v = static_cast<float>(area / u.length() / 2);
  u.normalize();
  lamp.axis_u = V3f(u), lamp.axis_v = V3f(n.cross(u));
  lamp.round = d.shape == AreaShape::Disk || d.shape == AreaShape::Ellipse;
  lamp.area = static_cast<float>(area) * (lamp.round ? pi / 4 : 1);
  const Color watts = d.color * d.power;
  lamp.radiance = watts / (4 * lamp.area);
  if (d.spread < pi - 1e-3f) {
    const double half = std::max(static_cast<double>(d.spread), 2e-3) / 2, cot = 1 / std::tan(half);
    lamp.spread_half = static_cast<float>(half), lamp.spread_cot = static_cast<float>(cot);
    lamp.spread_scale = static_cast<float>(1 / (1 - half * cot));
  }
  Light light;
  light.power = mean(watts) * pi / 4;
  light.middle = lamp.centre, light.reach = std::hypot(lamp.half_u, lamp.half_v);
  light.strength = mean(watts) / 4 * lamp.spread_scale;
  light.kind = lamp;
  return light;
}

std::optional<LampCrossing> crossing(const AreaLamp& lamp, const V3d& origin, const V3f& direction) noexcept {
  const float cosine = -direction.dot(lamp.normal);
  if (!(cosine > 0)) return {};
  const V3d to = origin - lamp.centre, d(direction), n(lamp.normal);
  const double t = -to.dot(n) / d.dot(n);
  if (!(t > 0)) return {};
  const V3d p = to + d * t;
  if (!contains(lamp, p.dot(V3d(lamp.axis_u)), p.dot(V3d(lamp.axis_v)))) return {};
  return LampCrossing{t, lamp.radiance * spread_factor(lamp, cosine)};
}

std::optional<DirectSample> sample_direct(const Parts&, const AreaLamp& lamp, const V3d& from, float,
                                          const V2f& u) noexcept {
  const auto view = view_from(lamp, from);
  if (!view) return {};
  V2d p;
  float solid_angle = 0;
  if (view->way == View::Way::SolidAngle) {
    const SphericalRectangle rectangle = spherical(*view);
    p = rectangle.sample(u) + V2d(view->at.x, view->at.y);
    solid_angle = static_cast<float>(rectangle.solid_angle());
  } else if (view->way == View::Way::Rectangle) {
    p = {view->x0 + (view->x1 - view->x0) * u.x, view->y0 + (view->y1 - view->y0) * u.y};
    if (!contains(lamp, p.x, p.y)) return {};
  } else {
    const V2f disk = sample_disk(u);
    p = {static_cast<double>(disk.x) * lamp.half_u, static_cast<double>(disk.y) * lamp.half_v};
  }
  const V3d to = lamp.centre + V3d(lamp.axis_u) * p.x + V3d(lamp.axis_v) * p.y - from;
  const double distance2 = to.length2(), distance = std::sqrt(distance2);
  const V3f wi(to / distance);
  const float cosine = -wi.dot(lamp.normal);
  if (!(cosine > 0)) return {};
  const Color radiance = lamp.radiance * spread_factor(lamp, cosine);
  if (is_black(radiance)) return {};
  const float pdf =
      solid_angle > 0 ? 1 / solid_angle : area_density(lamp, *view) * static_cast<float>(distance2) / cosine;
  // a lamp in the plane of a ceiling must not be shadowed by it
  return DirectSample{wi, short_of(distance, clearance_of(lamp), cosine), radiance, pdf, false, distance};
}

float pdf_direct(const Parts&, const AreaLamp& lamp, const V3d& from, const V3f& wi, const Hit*) noexcept {
  const auto found = crossing(lamp, from, wi);
  const auto view = view_from(lamp, from);
  if (!found || !view) return 0;
  if (is_black(found->radiance)) return 0;
  if (view->way == View::Way::SolidAngle) return static_cast<float>(1 / spherical(*view).solid_angle());
  return area_density(lamp, *view) * static_cast<float>(found->t * found->t) / -wi.dot(lamp.normal);
}

std::optional<EmissionPoint> sample_position(const Parts&, const AreaLamp& lamp, float,
                                             const V2f& u) noexcept {
  const V2f p = lamp.round ? sample_disk(u) : V2f(2 * u.x - 1, 2 * u.y - 1);
  const V3d position =
      lamp.centre + V3d(lamp.axis_u * (p.x * lamp.half_u)) + V3d(lamp.axis_v * (p.y * lamp.half_v));
  return EmissionPoint{.position = position,
                       .normal = lamp.normal,
                       .clearance = lamp.normal * clearance_of(lamp),
                       .pdf_area = 1 / lamp.area};
}

// Cosine-weighted within the spread's cone.
std::optional<EmissionDirection> sample_direction(const Parts& parts, const AreaLamp& lamp,
                                                  const EmissionPoint& point, float, const V2f& u) noexcept {
  const float sine = std::sin(lamp.spread_half);
  const V2f p = sample_disk(u) * sine;
  const V3f local(p.x, p.y, std::sqrt(std::max(0.0f, 1 - p.x * p.x - p.y * p.y)));
  const V3f direction = Frame(lamp.normal).to_world(local).normalized();
  const float pdf = pdf_direction(parts, lamp, point, direction);
  if (!(pdf > 0)) return {};
  return EmissionDirection{direction, pdf};
}

float pdf_direction(const Parts&, const AreaLamp& lamp, const EmissionPoint&, const V3f& direction) noexcept {
  const float cosine = direction.dot(lamp.normal);
  const float edge = std::cos(lamp.spread_half);
  if (!(cosine > 0 && cosine >= edge)) return 0;
  return cosine / (pi * (1 - edge * edge));
}

Color eval_emission(const Parts&, const AreaLamp& lamp, const EmissionPoint&, const V3f& direction) noexcept {
  const float cosine = direction.dot(lamp.normal);
  if (!(cosine > 0)) return Color(0);
  return lamp.radiance * (cosine * spread_factor(lamp, cosine));
}

bool is_dark(const AreaLamp& lamp, const V3d& from_middle) noexcept {
  const double height = from_middle.dot(V3d(lamp.normal));
  if (!(height > 0)) return true;
  if (lamp.spread_cot == 0) return false;
  const double aside = (from_middle - V3d(lamp.normal) * height).length();
  const double reach =
      std::sqrt(square(static_cast<double>(lamp.half_u)) + square(static_cast<double>(lamp.half_v)));
  return aside > (reach + height / lamp.spread_cot) * 1.001;
}

DirectionCone emission_cone(const AreaLamp& lamp) noexcept {
  const double half = std::min(static_cast<double>(lamp.spread_half), std::numbers::pi / 2);
  return {V3d(lamp.normal), half + 2 * bound_slack};
}

}  // namespace sluice::kinds
