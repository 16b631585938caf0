// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/guide/visible.h"

#include <algorithm>

#include "base/sampling.h"
#include "transport/pass.h"
#include "transport/photons/disks.h"

namespace sluice {
namespace {

constexpr double cells_across = 24;  // the picture, about
constexpr int paths_per_view_sample = 8, max_depth_of_look = 12;
// around the picture, in parts of it
constexpr float margin = max_disk_of_picture;
// cosine from which a normal may belong to hits counted for an axis
constexpr float faces_axis = 0.4f;
// of what is seen, by its distance from the camera
constexpr double quantiles[] = {0.25, 0.5, 0.75, 0.9, 1};
// least ratio of radii; outliers left out of a sphere
constexpr double growth_of_sights = 2.5, trimmed = 0.02;

int side_of(const V3f& n) noexcept {
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(n[i]) > std::abs(n[axis])) axis = i;
  return 2 * axis + (n[axis] < 0 ? 1 : 0);
}

// Around all of the points but the outermost: an outlier would make the sphere far too large.
Target sphere_around_most(std::span<const Hit> hits) {
  V3d middle(0);
  std::vector<double> values(hits.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(hits, values.begin(), [axis](const Hit& hit) { return hit.position[axis]; });
    std::ranges::sort(values);
    const std::size_t out = static_cast<std::size_t>(static_cast<double>(values.size()) * trimmed / 2);
    middle[axis] = 0.5 * (values[out] + values[values.size() - 1 - out]);
  }
  std::ranges::transform(hits, values.begin(),
                         [&](const Hit& hit) { return (hit.position - middle).length(); });
  std::ranges::sort(values);
  return {middle, static_cast<float>(
                      values[static_cast<std::size_t>(static_cast<double>(values.size()) * (1 - trimmed))])};
}

}  // namespace

double Visible::edge(const V3d& p) const noexcept { return std::ldexp(1.0, level(p)); }

// A place of no distance from the camera still has some size.
int Visible::level(const V3d& p) const noexcept {
  const FrameDescription& frame = scene_.frame();
  const double across = scene_.camera().footprint(p) * std::max(frame.width, frame.height) / cells_across;
  return std::ilogb(std::max(across, 1e-9 * scene_.extent()));
}

void Visible::add(const Vertex& vertex, const V3f& direction) {
  Hit hit = vertex.hit;
  if (hit.ng.dot(direction) > 0) hit.ng = -hit.ng;
  const int side = side_of(hit.ng);
  auto& sides = sides_of(hit.position);
  ++sides[static_cast<std::size_t>(side)];
  // light comes through from behind
  if (lit_side(vertex.bsdf) == V3f(0)) ++sides[static_cast<std::size_t>(side ^ 1)];
  hits_.push_back(hit);
}

void Visible::add_beside(const V3d& p) { sides_of(p); }

// Of the cell that holds p, made if there is none.
Visible::Sides& Visible::sides_of(const V3d& p) {
  const int at = level(p);
  std::uint32_t& number = levels_.try_emplace(at, std::ldexp(1.0, at)).first->second.at(p);
  if (number == 0) {
    sides_.emplace_back();
    number = static_cast<std::uint32_t>(sides_.size());
  }
  return sides_[number - 1];
}

int Visible::cell(const V3d& p) const noexcept {
  const auto found = levels_.find(level(p));
  const std::uint32_t* number = found == levels_.end() ? nullptr : found->second.find(p);
  return number ? static_cast<int>(*number) - 1 : -1;
}

double Visible::hits_in(int cell, const V3f& normal) const noexcept {
  const auto& sides = sides_[static_cast<std::size_t>(cell)];
  double hits = 0;
  for (int side = 0; side < 6; ++side)
    if ((side % 2 ? -1 : 1) * normal[side / 2] > faces_axis) hits += sides[static_cast<std::size_t>(side)];
  return hits;
}

std::vector<Sight> Visible::sights() const {
  std::vector<Sight> kept;  // the largest first
  std::vector<double> parts;
  if (hits_.empty()) return kept;
  std::vector<Hit> sorted = hits_;
  const V3d& eye = scene_.camera().position();
  std::ranges::stable_sort(sorted, {}, [&](const Hit& hit) { return (hit.position - eye).length2(); });
  for (std::size_t i = std::size(quantiles); i-- > 0;) {
    const auto count = static_cast<std::size_t>(std::ceil(static_cast<double>(sorted.size()) * quantiles[i]));
    Target sphere = sphere_around_most(std::span(sorted).first(count));
    sphere.radius = std::max(sphere.radius, static_cast<float>(edge(sphere.centre)));  // of one hit alone
    if (!kept.empty() && sphere.radius * growth_of_sights > kept.back().sphere.radius) continue;
    kept.push_back({sphere, 0}), parts.push_back(quantiles[i]);
  }
  for (std::size_t i = 0; i < kept.size(); ++i)
    kept[i].share = static_cast<float>(parts[i] - (i + 1 < parts.size() ? parts[i + 1] : 0));
  std::ranges::reverse(kept);
  return kept;
}

namespace {

// A camera ray, followed through mirrors and glass up to the first vertex that gathers light; false: it meets
// none.
bool find_gathering(const Scene& scene, Ray& ray, const Sampler& sampler, Vertex& vertex,
                    std::uint32_t& depth) {
  for (depth = 0; depth < max_depth_of_look; ++depth) {
    const auto hit = scene.intersect(ray);
    if (!hit) return false;
    make_vertex(scene, *hit, -ray.direction, ray.from_camera, Carries::Radiance, vertex);
    if (vertex.bsdf.events() & gathering) return true;
    V3f onward = ray.direction;
    if (const auto sample = sluice::sample(vertex.bsdf, vertex.point.wo, sampler.pair(3 + 2 * depth).x,
                                           sampler.pair(2 + 2 * depth), followed))
      onward = sample->wi;
    else if (is_black(vertex.bsdf.transparency))
      return false;
    ray = ray_from(*hit, onward);
  }
  return false;
}

// Photons just outside of the picture reach into it, so their kernels must be known there as well. As densely
// as in the picture.
void look_beside(const Scene& scene, const TransportSettings& settings, int paths,
                 const std::atomic<bool>& cancel, Visible& seen) {
  const FrameDescription& frame = scene.frame();
  const auto is_inside = [](float x) { return x > 0 && x < 1; };
  Vertex vertex;
  std::uint32_t depth = 0;
  paths = static_cast<int>(std::lround(paths * square(1.0 + 2 * margin)));
  for (int i = 0; i < paths && !cancel; ++i) {
    const Sampler sampler(key_of(settings.seed, PilotPurpose::Margin), static_cast<std::uint32_t>(i));
    const V2f at = sampler.pair(0) * (1 + 2 * margin) - V2f(margin);
    if (is_inside(at.x) && is_inside(at.y)) continue;
    Ray ray = scene.camera().generate(at.x * static_cast<float>(frame.width),
                                      at.y * static_cast<float>(frame.height), sampler.pair(1));
    if (find_gathering(scene, ray, sampler, vertex, depth)) seen.add_beside(vertex.hit.position);
  }
}

}  // namespace

Visible look_around(const Scene& scene, const TransportSettings& settings, const std::atomic<bool>& cancel) {
  Visible seen(scene);
  const FrameDescription& frame = scene.frame();
  const int paths = settings.pilot_paths / paths_per_view_sample;
  std::vector<double> footprints;
  int far_count = 0;
  std::uint32_t depth = 0;
  Vertex vertex, far;
  for (int i = 0; i < paths && !cancel; ++i) {
    const Sampler sampler(key_of(settings.seed, PilotPurpose::View), static_cast<std::uint32_t>(i));
    const V2f pixel = sampler.pair(0);
    Ray ray = scene.camera().generate(pixel.x * static_cast<float>(frame.width),
                                      pixel.y * static_cast<float>(frame.height), sampler.pair(1));
    if (!find_gathering(scene, ray, sampler, vertex, depth)) continue;
    seen.add(vertex, ray.direction);
    footprints.push_back(scene.camera().footprint(vertex.hit.position));
    const V3f onward = Frame(vertex.bsdf.ng).to_world(sample_cosine(sampler.pair(2 + 2 * depth)));
    if (const auto next = scene.intersect(ray_from(vertex.hit, onward))) {
      make_vertex(scene, *next, -onward, false, Carries::Radiance, far);
      seen.add(far, onward);
      seen.mean_length += next->t;
      ++far_count;
    }
  }
  look_beside(scene, settings, paths, cancel, seen);
  seen.mean_length /= std::max(far_count, 1);
  if (footprints.empty()) return seen;
  const auto middle = footprints.begin() + static_cast<std::ptrdiff_t>(footprints.size() / 2);
  std::ranges::nth_element(footprints, middle);
  seen.footprint = *middle;
  return seen;
}

}  // namespace sluice
