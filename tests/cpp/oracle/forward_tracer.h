// SPDX-License-Identifier: GPL-3.0-or-later
// Oracle (a) of design §5: light paths from the lights' own distributions, taken by entries as they meet
// them; every vertex with a D or G lobe is connected to the pinhole camera. Knows §4 of the paper and nothing
// of photon maps, C or view paths. For images in which no followed lobe is next to the eye and no light
// reaches the eye straight from an exit (that has measure zero here).
#pragma once
#include "oracle/rules.h"
#include "shading/material.h"

namespace sluice::oracle {

class ForwardTracer {
 public:
  ForwardTracer(const SceneDescription& description, const Scene& scene, const TransportSettings& settings)
      : scene_(scene), settings_(settings), rules_(description, scene, description.max_gates) {}

  // One batch: the mean over `paths` light paths.
  [[nodiscard]] Regions render(int side, int paths, std::uint64_t seed) {
    Regions out(side);
    random_ = Random(seed), out_ = &out;
    per_path_ = static_cast<double>(side) * side /
                (static_cast<double>(paths) * scene_.frame().width * scene_.frame().height);
    for (int i = 0; i < paths; ++i) emit();
    return out;
  }

 private:
  struct Light {
    V3d origin;
    V3f direction, clearance;
    V3d flux;
    History history;
    Event last = Event::L;
    int scatterings = 0;
    int edit = -1, exit = -1;  // the gate just left
  };

  void emit() {
    const auto lights = static_cast<int>(scene_.lights().size());
    const int light = random_.below(lights);
    Light path;
    if (is_infinite(scene_.lights()[static_cast<std::size_t>(light)])) {
      const auto way = sample_infinite(scene_, light, random_.pair());
      if (!way) return;
      const double radius = 0.501 * scene_.bounds().diagonal();
      const V2f d = sample_disk(random_.pair());
      const Frame frame(way->direction);
      path.direction = way->direction, path.clearance = V3f(0);
      path.origin =
          scene_.bounds().middle() + V3d(frame.t * d.x + frame.b * d.y - way->direction * 2.0f) * radius;
      path.flux = V3d(eval_infinite_emission(scene_, light, way->direction)) *
                  (std::numbers::pi * radius * radius / way->pdf);
    } else {
      const auto point = sample_position(scene_, light, random_.unit(), random_.pair());
      if (!point) return;
      const auto way = sample_direction(scene_, light, *point, random_.unit(), random_.pair());
      if (!way) return;
      path.origin = point->position, path.direction = way->direction, path.clearance = point->clearance;
      path.flux = V3d(eval_emission(scene_, light, *point, way->direction)) /
                  (static_cast<double>(point->pdf_area) * way->pdf);
    }
    path.flux *= lights;
    path.history.word = rules_.words.event(Event::L, scene_.light_entity(light));
    walk(std::move(path));
  }

  void walk(Light path) {
    for (;;) {
      const int skipped = path.edit >= 0 ? rules_.gates.gate(path.edit, path.exit).plane : -1;
      if (path.edit >= 0)
        if (const auto taken = rules_.capture_at(path.history, path.edit, path.exit, path.origin))
          return enter(path, *taken);
      path.edit = -1;
      if (!travel(path, skipped)) return;
    }
  }

  // On to the next scattering. False: the path is over or went through a gate.
  bool travel(Light& path, int skipped_plane) {
    for (;;) {
      const auto hit = scene_.intersect(
          {path.origin, path.direction, std::numeric_limits<double>::infinity(), path.clearance, false});
      const double t_end = hit ? hit->t : std::numeric_limits<double>::infinity();
      if (const auto taken =
              rules_.capture_on(path.history, path.origin, V3d(path.direction), t_end, skipped_plane))
        return enter(path, *taken), false;
      if (!hit) return false;
      SurfacePoint point;
      Bsdf bsdf;
      look(*hit, -path.direction, true, point, bsdf);
      path.origin = hit->position, path.clearance = hit->clearance;
      if (!is_black(bsdf.transparency)) {
        const float straight = bsdf.count > 0 ? 0.5f : 1.0f;
        if (random_.unit() < straight) {
          path.flux *= V3d(bsdf.transparency) / straight;
          continue;
        }
        path.flux /= 1 - straight;
      }
      connect(path, *hit);
      return scatter(path, point, bsdf);
    }
  }

  void enter(const Light& path, const Meeting& m) {
    if (rules_.at_cap(path.history)) return;
    const int edit = m.gate->edit;
    const double a = rules_.gates.weight(edit, m.uv);
    Light next = path;
    rules_.through(next.history, edit);
    next.last = Event::F, next.edit = edit, next.clearance = V3f(0);
    for (int x = 0; x < static_cast<int>(rules_.gates.edit(edit).exits.size()); ++x) {
      const auto turned = rules_.gates.forward(edit, x, m.uv, V3d(path.direction));
      if (!turned || !(a > 0)) continue;
      next.exit = x, next.origin = turned->position, next.direction = V3f(turned->direction.normalized());
      next.flux = turned_hue(path.flux * (turned->gain * a), turned->hue) * turned->tint;
      walk(next);
    }
    if (!(a < 1)) return;
    next.exit = -1, next.origin = m.gate->point(m.uv), next.direction = path.direction;
    next.flux = path.flux * (1 - a);
    walk(next);
  }

  void look(const Hit& hit, const V3f& wo, bool photon, SurfacePoint& point, Bsdf& bsdf) const {
    scene_.surface_point(hit, wo, false, point);
    point.photon = photon;
    shade(scene_.material(hit), point, bsdf);
  }

  bool scatter(Light& path, const SurfacePoint& point, const Bsdf& bsdf) {
    if (path.scatterings + 1 >= settings_.max_depth) return false;  // its next vertex would be one too many
    const auto sample = sluice::sample(bsdf, point.wo, random_.unit(), random_.pair(), any_lobe);
    if (!sample) return false;
    path.flux *=
        V3d(sample->weight) * static_cast<double>(adjoint_factor(bsdf, sample->lobe, point.wo, sample->wi));
    path.direction = sample->wi;
    path.history.word += rules_.words.event(sample->event, entity_);
    path.last = sample->event;
    ++path.scatterings;
    return true;
  }

  // Light that the vertex sends to the pinhole: flux · f · (pixels per area of this surface).
  void connect(const Light& path, const Hit& hit) {
    entity_ = scene_.entity(hit);
    const V3d to_eye = scene_.camera().position() - hit.position;
    const double distance = to_eye.length();
    const V3f wo(to_eye / distance);
    const auto pixel = scene_.camera().project(hit.position);
    const FrameDescription& frame = scene_.frame();
    if (!pixel || pixel->x < 0 || pixel->y < 0 || pixel->x >= frame.width || pixel->y >= frame.height) return;
    SurfacePoint point;
    Bsdf bsdf;
    look(hit, wo, false, point, bsdf);
    const V3f wi = -path.direction;
    for (const Event e : {Event::D, Event::G}) {
      const Color f = eval(bsdf, wo, wi, mask_of(e));
      if (is_black(f)) continue;
      History history = path.history;
      history.word += rules_.words.event(e, entity_);
      const V3d arriving = straight(history, hit, V3d(wo), distance);
      const double density = pixels_per_area(hit, *pixel) / std::abs(static_cast<double>(wi.dot(bsdf.ng)));
      out_->at(pixel->x, pixel->y, frame, part_of(path.last)) +=
          path.flux * V3d(f) * arriving * (density * per_path_);
    }
  }

  // What of light that leaves the hit towards the eye gets there: not what entries take, unless they let some
  // of it straight on.
  V3d straight(History history, const Hit& from, const V3d& d, double distance) {
    V3d left(1), origin = from.position;
    V3f clearance = from.clearance;
    for (double gone = 0;;) {
      const auto hit = scene_.intersect({origin, V3f(d), distance - gone, clearance, false});
      if (!hit) break;
      SurfacePoint point;
      Bsdf bsdf;
      look(*hit, V3f(-d), true, point, bsdf);
      left *= V3d(bsdf.transparency);
      if (left == V3d(0)) return left;
      gone += hit->t, origin = hit->position, clearance = hit->clearance;
    }
    origin = from.position;
    for (int skipped = -1;;) {
      const auto taken =
          rules_.capture_on(history, origin, d, (scene_.camera().position() - origin).length(), skipped);
      if (!taken) return left;
      for (auto next = taken; next; next = rules_.capture_at(history, next->gate->edit, -1, origin)) {
        if (rules_.at_cap(history)) return V3d(0);
        left *= 1 - rules_.gates.weight(next->gate->edit, next->uv);
        origin = next->gate->point(next->uv), skipped = next->gate->plane;
        rules_.through(history, next->gate->edit);
      }
    }
  }

  // |∂pixel / ∂area| of the surface at a hit, from the camera's own projection.
  [[nodiscard]] double pixels_per_area(const Hit& hit, const V2d& pixel) const {
    const Frame frame(hit.ng);
    const double h = 1e-5 * (scene_.camera().position() - hit.position).length();
    const V2d a = (*scene_.camera().project(hit.position + V3d(frame.t) * h) - pixel) / h,
              b = (*scene_.camera().project(hit.position + V3d(frame.b) * h) - pixel) / h;
    return std::abs(a.x * b.y - a.y * b.x);
  }

  const Scene& scene_;
  const TransportSettings& settings_;
  Rules rules_;
  Random random_{0};
  Regions* out_ = nullptr;
  double per_path_ = 0;
  int entity_ = -1;
};

}  // namespace sluice::oracle
