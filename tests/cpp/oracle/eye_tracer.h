// SPDX-License-Identifier: GPL-3.0-or-later
// Oracle (b) of design §5: paths from the eye that find lights by chance alone. At the exits of light edits
// they go straight on or backward through the gate at random; when one meets an emitter, the light's way is
// walked forward again, node by node, and the path counts only if every entry on it takes the light, or lets
// it pass, as the path supposed. Knows no C, no next-event estimation, no photons and no rule about planes
// seen backward. Lights must have an extent.
#pragma once
#include "oracle/rules.h"
#include "shading/material.h"

namespace sluice::oracle {

class EyeTracer {
 public:
  EyeTracer(const SceneDescription& description, const Scene& scene, const TransportSettings& settings)
      : scene_(scene),
        settings_(settings),
        rules_(description, scene, description.max_gates),
        far_(10 * scene.bounds().diagonal()),
        edits_(static_cast<int>(description.edits.size())),
        layers_(static_cast<int>(description.layers.size())) {}

  // One batch: the mean over `samples` paths per pixel. Where the description has layers (five at most),
  // those take the parts' places.
  [[nodiscard]] Regions render(int side, int samples, std::uint64_t seed) {
    Regions out(side);
    random_ = Random(seed);
    const FrameDescription& frame = scene_.frame();
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x)
        for (int i = 0; i < samples; ++i) {
          const V2f at = V2f(static_cast<float>(x), static_cast<float>(y)) + random_.pair();
          sum_.fill(V3d(0));
          trace(at);
          for (int p = 0; p < part_count; ++p)
            out.at(at.x, at.y, frame, static_cast<Part>(p)) +=
                sum_[static_cast<std::size_t>(p)] *
                (static_cast<double>(side) * side /
                 (static_cast<double>(samples) * frame.width * frame.height));
        }
    return out;
  }

 private:
  // What happened to the path, from the eye on.
  struct Node {
    enum class Kind { Surface, LightGate, ViewGate } kind;
    V3d eye_side, light_side;  // positions: a gate's exit and entry
    V3d factor;                // of radiance, without H
    double hue = 0;
    V3d tint{1};             // after H
    Event event = Event::F;  // of a surface
    int entity = -1, edit = -1, exit = -1;
    bool delta = false;  // a surface's lobe has one direction only
  };
  struct View {
    V3d origin;
    V3f direction, clearance{0};
    double t_max;
    int skipped_plane = -1;
    // just came out of an entry of this plane, backward: its exits may be here too
    int plane = -1;
    int view_edit = -1, view_exit = -1;  // just left this gate of a view edit
    bool camera = true;                  // no event yet
  };

  void trace(const V2f& at) {
    const Ray ray = scene_.camera().generate(at.x, at.y, V2f(0.5f));
    nodes_.clear();
    eye_factor_ = V3d(1);
    eye_ = ray.origin;
    View view{.origin = ray.origin, .direction = ray.direction, .t_max = ray.t_max};
    while (step(view)) {}
  }

  [[nodiscard]] int scatterings() const {
    return static_cast<int>(std::count_if(nodes_.begin(), nodes_.end(),
                                          [](const Node& n) { return n.kind == Node::Kind::Surface; }));
  }
  [[nodiscard]] int gate_count() const { return static_cast<int>(nodes_.size()) - scatterings(); }

  // One gate or one segment further. False: the path is over.
  bool step(View& view) {
    if (view.plane >= 0) {
      const int plane = view.plane;
      view.plane = -1;
      const auto here = rules_.gates.at(plane, view.origin);
      if (!choose_gate(view, std::span(here.begin(), here.size()), 0)) return false;
      if (view.plane >= 0) return true;
    }
    if (view.view_edit >= 0) {
      const int own = view.view_edit, plane = rules_.gates.gate(own, view.view_exit).plane;
      view.view_edit = -1;
      for (const Meeting& m : rules_.gates.at(plane, view.origin))
        if (is_view_capture(m) && m.gate->edit != own) return enter_view_edit(view, m);
    }
    const auto hit = scene_.intersect({view.origin, view.direction, view.t_max, view.clearance, view.camera});
    const double t_end = hit ? hit->t : view.t_max;
    std::array<LampHit, 16> lamps;
    const auto lamp_count = static_cast<std::size_t>(
        intersect_lamps(scene_, {view.origin, view.direction, t_end, view.clearance, view.camera}, lamps));
    double seen = 0;
    const auto see_lamps = [&](double until) {
      for (std::size_t i = 0; i < lamp_count; ++i)
        if (lamps[i].t > seen && lamps[i].t <= until)
          arrive(scene_.light_entity(lamps[i].light), lamps[i].radiance,
                 view.origin + V3d(view.direction) * lamps[i].t);
      seen = until;
    };
    const auto met = rules_.gates.empty()
                         ? Meetings()
                         : rules_.gates.along(view.origin, V3d(view.direction), t_end, view.skipped_plane);
    for (std::size_t i = 0; i < met.size();) {
      std::size_t end = i;
      while (end < met.size() && met[end].gate->plane == met[i].gate->plane && met[end].t == met[i].t) ++end;
      see_lamps(met[i].t);
      // In one plane, gates of light edits lie on the eye's side of those of view edits (design §2).
      if (!choose_gate(view, std::span(met.begin() + static_cast<std::ptrdiff_t>(i), end - i), met[i].t))
        return false;
      if (view.plane >= 0) return true;
      for (std::size_t k = i; k < end; ++k)
        if (is_view_capture(met[k])) return enter_view_edit(view, met[k]);
      i = end;
    }
    see_lamps(t_end);
    if (!hit) return meet_sky(view), false;
    return meet_surface(view, *hit);
  }

  // At one point of one plane: straight on, or backward through one of the gates of light edits that light
  // may have left here.
  bool choose_gate(View& view, std::span<const Meeting> here, double t) {
    Meetings ways;
    for (const Meeting& m : here)
      if (!m.gate->of_view && (!m.gate->is_entry() || rules_.gates.weight(m.gate->edit, m.uv) < 1))
        ways.push_back(m);
    if (ways.empty()) return true;
    const int choice = random_.below(static_cast<int>(ways.size()) + 1);
    weight() *= static_cast<double>(ways.size()) + 1;
    if (choice == 0) return true;
    if (gate_count() >= scene_.edits().max_gates()) return false;
    const Meeting& m = ways[static_cast<std::size_t>(choice - 1)];
    const V3d point = t > 0 ? view.origin + V3d(view.direction) * t : view.origin;
    const double a = rules_.gates.weight(m.gate->edit, m.uv);
    Node node{.kind = Node::Kind::LightGate,
              .eye_side = point,
              .light_side = point,
              .factor = V3d(1 - a),
              .edit = m.gate->edit,
              .exit = m.gate->exit};
    V3d direction(view.direction);
    if (!m.gate->is_entry()) {
      const auto turned = rules_.gates.backward(m.gate->edit, m.gate->exit, m.uv, direction);
      if (!turned) return false;
      node.eye_side = m.gate->point(m.uv), node.light_side = turned->position;
      direction = turned->direction.normalized();
      node.factor = V3d(turned->gain * a), node.hue = turned->hue, node.tint = turned->tint;
    }
    view = start(node.light_side, direction);
    view.plane = view.skipped_plane = rules_.gates.gate(m.gate->edit, -1).plane;
    nodes_.push_back(node);
    return true;
  }

  [[nodiscard]] static View start(const V3d& origin, const V3d& direction) {
    return {.origin = origin,
            .direction = V3f(direction),
            .t_max = std::numeric_limits<double>::infinity(),
            .camera = false};
  }
  // Weights of random decisions go to the last thing that happened.
  V3d& weight() { return nodes_.empty() ? eye_factor_ : nodes_.back().factor; }

  // View edits act on the view path from E to its first D or G lobe. The word of light: what is next to the
  // eye comes last.
  [[nodiscard]] bool is_view_capture(const Meeting& m) {
    if (!m.gate->of_view || !m.gate->is_entry()) return false;
    Word word;
    bool used = false;
    for (auto n = nodes_.rbegin(); n != nodes_.rend(); ++n) {
      if (n->kind == Node::Kind::Surface && n->event != Event::S) return false;
      word += n->kind == Node::Kind::Surface ? rules_.words.event(n->event, n->entity)
                                             : rules_.words.gate(n->edit);
      used = used || n->edit == m.gate->edit;
    }
    word += rules_.words.event(Event::E, -1);
    return (!used || rules_.gates.edit(m.gate->edit).repeat) && rules_.words.accepts(m.gate->edit, word);
  }

  bool enter_view_edit(View& view, const Meeting& m) {
    if (gate_count() >= scene_.edits().max_gates()) return false;
    const int edit = m.gate->edit, exits = static_cast<int>(rules_.gates.edit(edit).exits.size());
    const double a = rules_.gates.weight(edit, m.uv);
    const int exit = random_.below(exits + 1) - 1;  // -1: straight on
    const V3d point = m.gate->point(m.uv);
    Node node{.kind = Node::Kind::ViewGate,
              .eye_side = point,
              .light_side = point,
              .factor = V3d((1 - a) * (exits + 1)),
              .edit = edit,
              .exit = exit};
    V3d direction(view.direction);
    if (exit >= 0) {
      const auto turned = rules_.gates.forward(edit, exit, m.uv, direction);
      if (!turned) return false;
      node.light_side = turned->position, direction = turned->direction.normalized();
      node.factor = V3d(turned->gain * a * (exits + 1)), node.hue = turned->hue, node.tint = turned->tint;
    }
    if (node.factor == V3d(0)) return false;
    nodes_.push_back(node);
    view = start(node.light_side, direction);
    view.skipped_plane = rules_.gates.gate(edit, exit).plane;
    view.view_edit = edit, view.view_exit = exit;
    return true;
  }

  void meet_sky(const View& view) {
    for (const int light : scene_.infinite_lights())
      arrive(scene_.light_entity(light), eval_infinite(scene_, light, view.direction, view.camera),
             view.origin + V3d(view.direction) * far_);
  }

  bool meet_surface(View& view, const Hit& hit) {
    SurfacePoint point;
    Bsdf bsdf;
    scene_.surface_point(hit, -view.direction, view.camera, point);
    shade(scene_.material(hit), point, bsdf);
    const int entity = scene_.entity(hit);
    if (!is_black(bsdf.emission)) arrive(entity, bsdf.emission, hit.position);
    view.origin = hit.position, view.clearance = hit.clearance, view.t_max -= hit.t;
    if (!is_black(bsdf.transparency)) {
      const float straight = bsdf.count > 0 ? 0.5f : 1.0f;
      const bool passes = random_.unit() < straight;
      weight() *= passes ? V3d(bsdf.transparency) / straight : V3d(1 / (1 - straight));
      if (passes) return true;
    }
    if (scatterings() >= settings_.max_depth) return false;
    const auto sample = sluice::sample(bsdf, point.wo, random_.unit(), random_.pair(), any_lobe);
    if (!sample || is_black(sample->weight)) return false;
    Node node{.kind = Node::Kind::Surface,
              .eye_side = hit.position,
              .light_side = hit.position,
              .factor = V3d(sample->weight) / square(static_cast<double>(sample->eta))};
    node.event = sample->event, node.entity = entity, node.delta = sample->delta;
    nodes_.push_back(node);
    view = start(hit.position, V3d(sample->wi));
    view.clearance = hit.clearance;
    return true;
  }

  // The path has met an emitter at `from`: does light get from there to the eye this way?
  void arrive(int entity, const Color& radiance, const V3d& from) {
    if (is_black(radiance)) return;
    History history{.word = Word(1, rules_.words.event(Event::L, entity))};
    V3d color(radiance), origin = from;
    const Node* last = nullptr;
    for (int i = static_cast<int>(nodes_.size()) - 1; i >= -1; --i) {
      const Node* node = i >= 0 ? &nodes_[static_cast<std::size_t>(i)] : nullptr;
      if (!follows(history, origin, last, node)) return;
      if (!node) break;
      if (node->kind != Node::Kind::Surface) {
        if (rules_.at_cap(history)) return;
        rules_.through(history, node->edit);
      } else {
        history.word += rules_.words.event(node->event, node->entity);
      }
      color = turned_hue(color * node->factor, node->hue) * node->tint;
      origin = node->eye_side;
      last = node;
    }
    if (layers_ == 0) sum_[static_cast<std::size_t>(part())] += color * eye_factor_;
    history.word += rules_.words.event(Event::E, -1);
    for (int layer = 0; layer < layers_; ++layer)
      if (rules_.words.accepts(edits_ + layer, history.word))
        sum_[static_cast<std::size_t>(layer)] += color * eye_factor_;
  }

  // Light goes from `origin`, the eye's side of node `from` (null: an emitter), to `to` (null: the eye). Do
  // just those entries take it that the path supposes?
  [[nodiscard]] bool follows(const History& history, const V3d& origin, const Node* from, const Node* to) {
    if (rules_.gates.empty()) return true;
    const double near = 1e-9 * far_;
    const V3d end = to ? to->light_side : eye_;
    const int expected = to && to->kind == Node::Kind::LightGate ? to->edit : -1;
    const auto is_expected = [&](const Meeting& m) {
      return m.gate->edit == expected && (m.gate->point(m.uv) - end).length() <= near;
    };
    int skipped = -1;
    if (from && from->kind != Node::Kind::Surface) {
      const bool of_light = from->kind == Node::Kind::LightGate;
      const int exit = of_light ? from->exit : -1;  // light leaves a view edit at its entry
      if (const auto taken = rules_.capture_at(history, from->edit, exit, origin)) return is_expected(*taken);
      skipped = rules_.gates.gate(from->edit, exit).plane;
    }
    const V3d way = end - origin;
    const double length = way.length();
    if (length <= near) return expected < 0;
    const double t_end = expected >= 0                            ? length + near
                         : to && to->kind == Node::Kind::ViewGate ? length - near
                                                                  : length;
    const auto taken = rules_.capture_on(history, origin, way / length, t_end, skipped);
    return taken ? is_expected(*taken) : expected < 0;
  }

  // The class of design §5: v is the D or G vertex nearest to the eye.
  [[nodiscard]] Part part() const {
    const auto v = std::find_if(nodes_.begin(), nodes_.end(), [](const Node& n) {
      return n.kind == Node::Kind::Surface && n.event != Event::S;
    });
    if (v == nodes_.end())  // next-event estimation finds light at rough followed lobes too
      return !nodes_.empty() && nodes_.back().kind == Node::Kind::Surface && !nodes_.back().delta
                 ? Part::Direct
                 : Part::Emission;
    return part_of(v + 1 == nodes_.end() ? Event::L : (v + 1)->event);
  }

  const Scene& scene_;
  const TransportSettings& settings_;
  Rules rules_;
  double far_;
  int edits_, layers_;
  Random random_{0};
  std::vector<Node> nodes_;
  V3d eye_{0}, eye_factor_{1};
  Parts sum_;
};

}  // namespace sluice::oracle
