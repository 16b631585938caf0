// SPDX-License-Identifier: GPL-3.0-or-later
#include "transport/view/shared_gather.h"

#include <algorithm>

namespace sluice {
namespace {

// Photon light that leaves y is evaluated once, for the vertex that found y. Others reuse it if their
// direction differs by no more than min(photon_cone, photon_cone_widths lobe widths) (rad): a bias that
// shrinks with the radii, and blurs nothing beyond the bundle's pixels.
constexpr float photon_cone = 0.3f, photon_cone_widths = 1.5f;
// The same for the weights and colours of y's lobes, where nodes make them of the direction.
constexpr float lobe_cone = 0.1f;

// A bound on the angle (rad) over which what the lobes of y send out changes little; infinite where all
// directions see the same. Nodes may make weights and colours of the direction, too.
float min_width(const Material& material, const Vertex& y) noexcept {
  float width = material.sees_direction() ? 1.0f : infinity;
  for (int i = 0; i < y.bsdf.count; ++i) {
    const Lobe& lobe = y.bsdf.lobes[static_cast<std::size_t>(i)];
    if (!(mask_of(lobe.event) & gathering)) continue;
    width = std::min(width, std::visit([](const auto& shape) { return angular_width(shape); }, lobe.shape));
  }
  return width;
}

}  // namespace

bool SharedGather::accept_candidate(const Sample& sample, const ViewPath& path) noexcept {
  SharingVertex& vertex = vertices_[count_];
  const EventMask kinds = vertex.v.bsdf.events() & gathering;
  if (bundle_.size() == 1 || path.gates > 0 || !context_.effects.indirect || !kinds || count_ == max_sharing)
    return false;
  ++count_;
  vertex.sample = sample.index, vertex.path = path;
  vertex.signature =
      mix(path.signature, (static_cast<std::uint64_t>(scene_.entity(vertex.v.hit)) + 1) << 8 | kinds);
  return true;
}

void SharedGather::gather() {
  for (std::size_t i = 0; i < count_; ++i) {
    const SharingVertex& finder = vertices_[i];
    const ViewSample& asked = bundle_[finder.sample];
    Sample sample(asked, finder.sample, mix(asked.key, i + 1));
    for (std::uint32_t s = 0; s < asked.segments.count; ++s) {
      const Sampler numbers = asked.segments.numbers(s);
      if (!gather_.send_segment(sample, finder.path, finder.v, numbers, asked.segments.mean, point_.segment))
        continue;
      start_point();
      gather_.collect_light_at_y(finder.path, point_.segment, numbers,
                                 ToGatherPoint{sums_, point_, occlusion_});
      share(finder);
    }
  }
}

// From here on, light that leaves y is kept for the bundle.
void SharedGather::start_point() {
  const Vertex& y = point_.segment.y;
  point_.width = min_width(scene_.material(y.hit), y);
  point_.unscattered.count = 0;
  for (const LobeThroughput& lobe : point_.segment.lobes)
    point_.light[point_.index_of(lobe)].clear(scene_.edits().layers().size());
  occlusion_.start(y);
}

// The light of the y that `finder` found, to all that see it.
void SharedGather::share(const SharingVertex& finder) {
  // Of light at hand in point_.light: photons', and direct light where y looks the same to all. Layers are
  // parts of the picture, so its black tells of theirs.
  const bool has_photons = !std::ranges::all_of(point_.segment.lobes, [&](const LobeThroughput& lobe) {
    return is_black(point_.light_of(lobe).picture);
  });
  const bool has_unscattered = point_.unscattered.count > 0;
  if (!has_photons && !has_unscattered) return;
  std::array<Connection, max_sharing> room;
  Connection& own = room[0];
  const bool stays = !point_.segment.may_share || !connect(finder, point_.segment.y, own) ||
                     occlusion_.occludes(own, point_.segment.y, finder, vertices());
  const bool shares_photons = has_photons && !stays && see_same_photons(finder);
  keep(finder, has_photons && !shares_photons, stays);
  if (stays || (!shares_photons && !has_unscattered)) return;
  own.pdf = point_.segment.pdf, own.is_open = true;
  const std::span all = find_connections(finder, room);
  const float density =
      density_of(all, [&](const SharingVertex& vertex) { return bundle_[vertex.sample].segments.mean; });
  for (const Connection& connection : all) {
    if (!connection.is_open) continue;
    const SharingVertex& to = *connection.to;
    const Bsdf& bsdf = bsdf_towards(-connection.wi);
    for (const LobeThroughput& lobe : point_.segment.lobes) {
      const Color factor =
          eval(to.v.bsdf, to.v.point.wo, connection.wi, lobe.lobes) * (connection.geometry / density);
      if (shares_photons) receive(to, point_.light_of(lobe), factor);
      receive_unscattered(to, lobe, bsdf, -connection.wi, factor);
    }
  }
}

// The light of y that its finder alone sees.
void SharedGather::keep(const SharingVertex& finder, bool keeps_photons, bool keeps_unscattered) {
  for (const LobeThroughput& lobe : point_.segment.lobes) {
    if (keeps_photons) receive(finder, point_.light_of(lobe), lobe.weight);
    if (keeps_unscattered)
      receive_unscattered(finder, lobe, point_.segment.y.bsdf, point_.segment.y.point.wo, lobe.weight);
  }
}

// Connections of all that could have found y, behind the finder's own, which comes first.
std::span<Connection> SharedGather::find_connections(const SharingVertex& finder, std::span<Connection> all) {
  std::size_t count = 1;
  for (const SharingVertex& other : vertices()) {
    if (other.signature != finder.signature || &other == &finder) continue;
    Connection& connection = all[count];
    if (!connect(other, point_.segment.y, connection)) continue;
    connection.pdf = pdf(other.v.bsdf, other.v.point.wo, connection.wi, gathering);
    if (connection.pdf > 0) ++count;
  }
  const std::span others = all.subspan(1, count - 1);
  find_unoccluded(others);
  for (Connection& connection : others)
    connection.is_open =
        connection.is_open && !occlusion_.occludes(connection, point_.segment.y, finder, vertices());
  return all.first(count);
}

void SharedGather::find_unoccluded(std::span<Connection> connections) noexcept {
  std::array<Ray, max_sharing> rays;
  std::array<bool, max_sharing> is_clear;
  const Vertex& y = point_.segment.y;
  const double clearance = y.hit.clearance.length();
  for (std::size_t i = 0; i < connections.size(); ++i) {
    const Connection& c = connections[i];
    rays[i] = ray_from(c.to->v.hit, c.wi, short_of(c.distance, clearance, -c.wi.dot(y.point.ng)));
  }
  scene_.find_clear(std::span(rays).first(connections.size()), is_clear);
  sums_.counts.shadow_rays += connections.size();
  for (std::size_t i = 0; i < connections.size(); ++i) connections[i].is_open = is_clear[i];
}

// Do all that could share y see the same light of its photons? Asked of all, lit or not, so that it does not
// matter who found y. (Where roughness depends on the direction it may, near the limit: a bias of the same
// kind.)
bool SharedGather::see_same_photons(const SharingVertex& finder) const noexcept {
  if (!point_.depends_on_direction()) return true;
  const float cone = std::min(photon_cone, photon_cone_widths * point_.width);
  const float min_cosine = std::cos(context_.radius_scale * cone);
  std::optional<V3f> axis;
  return std::ranges::all_of(vertices(), [&](const SharingVertex& other) {
    if (other.signature != finder.signature) return true;
    const V3f direction = V3f(point_.segment.y.hit.position - other.v.hit.position).normalized();
    if (!axis) axis = direction;
    return axis->dot(direction) >= min_cosine;
  });
}

// Of y, seen from wo: as its finder sees it, unless it depends on the direction and that is too far from the
// finder's.
const Bsdf& SharedGather::bsdf_towards(const V3f& wo) noexcept {
  const Vertex& y = point_.segment.y;
  const bool differs = point_.unscattered.count > 0 && scene_.material(y.hit).sees_direction() &&
                       wo.dot(y.point.wo) < std::cos(lobe_cone * context_.radius_scale);
  if (!differs) return y.bsdf;
  make_vertex(scene_, y.hit, wo, false, Carries::Radiance, seen_from_elsewhere_);
  return seen_from_elsewhere_.bsdf;
}

// Light that leaves y reaches the eye by the vertex's path. `factor`: of v.
void SharedGather::receive(const SharingVertex& vertex, const OutgoingRadiance& light,
                           const Color& factor) noexcept {
  sums_.add(Part::Indirect, vertex.sample, light, factor * vertex.path.weight);
}

// The same for the light that y's BSDF, as it is seen from wo, scatters now, for one lobe of v.
void SharedGather::receive_unscattered(const SharingVertex& vertex, const LobeThroughput& lobe,
                                       const Bsdf& bsdf, const V3f& wo, const Color& factor) {
  const UnscatteredLight& light = point_.unscattered;
  if (light.count == 0) return;
  scattered_.clear(scene_.edits().layers().size());
  for (const UnscatteredLight::Share& share : std::span(light.shares).first(light.count))
    if (share.lobe == point_.index_of(lobe))
      sums_.add(scattered_, eval(bsdf, wo, light.wi, mask_of(share.event)) * light.arriving, share.joined);
  receive(vertex, scattered_, factor);
}

}  // namespace sluice
