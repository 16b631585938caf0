// SPDX-License-Identifier: GPL-3.0-or-later
#include "edit/compile_edits.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "expr/unknown_names.h"

namespace sluice {

namespace {

constexpr std::size_t max_edits = 65'000;  // rules, of layers too, are numbered with 16 bits

double largest_coordinate(const Box& box, const V3d& from) noexcept {
  if (box.isEmpty()) return 0;
  const V3d low = box.min - from, high = box.max - from;
  return std::max({std::abs(low.x), std::abs(low.y), std::abs(low.z), std::abs(high.x), std::abs(high.y),
                   std::abs(high.z)});
}

void extend(Box& box, const QuadDescription& quad) {
  if (const auto corners = quad_corners(quad))
    for (const V3d& p : *corners) box.extendBy(p);
}

template <class F>
void for_each_quad(const EditDescription& edit, const F& f) {
  f(edit.entry);
  for (const ExitDescription& exit : edit.exits) f(exit.quad);
}

// Diagonal of everything, against which quads are judged degenerate.
double extent_of(std::span<const EditDescription> edits, Box box) {
  for (const EditDescription& edit : edits)
    if (edit.enabled) for_each_quad(edit, [&](const QuadDescription& q) { extend(box, q); });
  return box.isEmpty() ? 0 : (box.max - box.min).length();
}

// Names of the edit's quads that are refused. An exit may have no area: it sends nothing, as its light goes
// to 0 with its area.
std::vector<std::string> refused_quads(const EditDescription& edit, double extent) {
  std::vector<std::string> names;
  if (!make_quad(edit.entry, V3d(0), extent)) names.push_back(edit.entry.name);
  for (const ExitDescription& exit : edit.exits)
    if (!is_finite(exit.quad)) names.push_back(exit.quad.name);
  return names;
}

float checked(float value, float low, float high, float instead, const std::string& item, const char* what,
              Warnings& warnings) {
  if (!std::isfinite(value)) {
    warnings.push_back(
        {item, std::string(what) + " is not a number; " + (instead == 0 ? "0" : "1") + " is used"});
    return instead;
  }
  if (value < low || value > high) {
    warnings.push_back({item, std::string(what) + " lies outside of its range and is clamped"});
    return std::clamp(value, low, high);
  }
  return value;
}

// Of images that are no colours the loader leaves them, but there is no negative light.
std::size_t negative_texels(const Image& image) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < image.rgba.size(); k += 4)
    count += luminance(Color(image.rgba[k], image.rgba[k + 1], image.rgba[k + 2])) < 0;
  return count;
}

// The artist's colour at luminance 1, so that it colours white light and leaves it as bright; greys and black
// are white, bit by bit.
Color checked_tint(const Color& tint, const std::string& item, Warnings& warnings) {
  if (!is_finite(tint)) {
    warnings.push_back({item, "tint is not a colour; white is used"});
    return Color(1);
  }
  const V3d c(std::max(tint.x, 0.0f), std::max(tint.y, 0.0f), std::max(tint.z, 0.0f));
  if (c != V3d(tint.x, tint.y, tint.z))
    warnings.push_back({item, "tint lies outside of its range and is clamped"});
  if (c.x == c.y && c.y == c.z) return Color(1);
  // in double: it may be as dark or bright as floats are
  return Color(c / (0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z));
}

}  // namespace

Box quad_bounds(std::span<const EditDescription> edits, const Box& scene_bounds) {
  const double extent = extent_of(edits, scene_bounds);
  Box box;
  for (const EditDescription& edit : edits)
    if (edit.enabled && refused_quads(edit, extent).empty())
      for_each_quad(edit, [&](const QuadDescription& q) { extend(box, q); });
  return box;
}

class EditsBuilder {
 public:
  EditsBuilder(std::span<const EditDescription> descriptions, std::span<const Image> images,
               const EditSpace& space, Warnings& warnings, const CancelPoint& cancel)
      : descriptions_(descriptions), images_(images), space_(space), warnings_(warnings), cancel_(cancel) {}

  Edits build(std::span<const Entity> entities, int max_gates, std::span<const LayerDescription> layers) {
    edits_.max_gates_ = max_gates;
    edits_.layers_.assign(layers.begin(), layers.end());
    read_edits();
    read_layers();
    place();
    compile_expressions(entities);
    index_quads();
    return std::move(edits_);
  }

 private:
  // Which edits act; disabled and refused ones leave no trace.
  void read_edits() {
    const double extent = extent_of(descriptions_, space_.bounds);
    for (std::size_t i = 0; i < descriptions_.size(); ++i) {
      cancel_();
      const EditDescription& d = descriptions_[i];
      if (!d.enabled) continue;
      Expression expression = parse_expression(d.expression, d.entry.name);
      const Side side = side_of(expression, d.entry.name);
      if (const auto refused = refused_quads(d, extent); !refused.empty()) {
        for (const std::string& name : refused)
          warnings_.push_back({name, "this quad has no area or its transform is not finite; its edit '" +
                                         d.entry.name + "' is off"});
        continue;
      }
      if (edits_.edits_.size() == max_edits)
        throw SceneError(d.entry.name, "a scene has at most 65,000 edits; remove some");
      expressions_.push_back(std::move(expression));
      edits_.edits_.push_back(read_edit(i, side, extent));
    }
  }

  void read_layers() {
    if (edits_.layers_.size() > max_light_layers)
      throw SceneError(
          said(edits_.layers_[max_light_layers]),
          "a view layer has at most " + std::to_string(max_light_layers) + " light layers; remove some");
    for (const LayerDescription& layer : edits_.layers_)
      layer_expressions_.push_back(parse_layer_expression(layer.expression, said(layer)));
  }
  static std::string said(const LayerDescription& layer) { return "layer '" + layer.name + "'"; }

  Edit read_edit(std::size_t i, Side side, double extent) {
    const EditDescription& d = descriptions_[i];
    Edit e;
    e.name = d.entry.name;
    e.description = i;
    e.side = side;
    e.order = d.entry.order;
    e.repeat = d.repeat;
    e.amount = checked(d.amount, 0, 1, 1, e.name, "amount", warnings_);
    e.feather = checked(d.feather, 0, 1, 0, e.name, "feather", warnings_);
    e.is_partial = e.amount < 1 || e.feather > 0;
    e.entry = *make_quad(d.entry, space_.centre, extent);
    for (const ExitDescription& exit : d.exits)
      if (const auto quad = make_quad(exit.quad, space_.centre, extent))
        e.exits.push_back(read_exit(exit, *quad, e.entry.area));
      else
        warnings_.push_back({exit.quad.name, "this quad has no area: it sends out nothing"});
    if (d.exits.empty())
      warnings_.push_back({e.name, "this entry has no exit: the light it takes is absorbed"});
    return e;
  }

  Exit read_exit(const ExitDescription& d, const Quad& quad, double entry_area) {
    Exit x;
    static_cast<ExitProperties&>(x) = d;
    x.quad = quad;
    x.name = d.quad.name;
    for_each_property(
        x, [&](const char* what, auto& value, const auto& rule) { check(value, rule, what, x.name); });
    set_area_ratio(x, quad.area / entry_area);
    return x;
  }

  void check(float& value, const NumberRule& rule, const char* what, const std::string& exit) {
    value = checked(value, rule.low, rule.high, rule.if_no_number, exit, what, warnings_);
  }
  void check(Color& value, const TintRule&, const char*, const std::string& exit) {
    value = checked_tint(value, exit, warnings_);
  }
  void check(bool&, const SwitchRule&, const char*, const std::string&) {}
  void check(int& image, const TextureRule& rule, const char* what, const std::string& exit) {
    image = texture(image, rule, exit, what);
  }

  // σ of the paper acts on flux. For radiance the same law reads σ · entry / exit, which is 1 when σ is on
  // (design §4).
  void set_area_ratio(Exit& x, double ratio) {
    if (!x.keep_brightness) {
      x.radiance_ratio = static_cast<float>(1 / ratio);
    } else if (ratio > static_cast<double>(max_area_ratio)) {
      warnings_.push_back({x.name,
                           "this exit is more than a million times larger than its entry; its light gets "
                           "darker than keep_brightness says"});
      x.area_ratio = max_area_ratio;
      x.radiance_ratio = static_cast<float>(static_cast<double>(max_area_ratio) / ratio);
    } else {
      x.area_ratio = static_cast<float>(ratio);
    }
  }

  // The edits keep copies of the images they use: a compiled scene does not point into its description.
  int texture(int image, const TextureRule& rule, const std::string& exit, const char* what) {
    if (image < 0) return -1;
    const auto i = static_cast<std::size_t>(image);
    if (i >= images_.size() || images_[i].empty()) {
      const std::string name =
          i < images_.size() ? "the image '" + images_[i].name + "'" : std::string("the image");
      warnings_.push_back(
          {exit, name + " of " + what + " cannot be read; the exit's own number is used alone"});
      return -1;
    }
    const std::size_t broken = images_[i].sanitised + (rule.is_light ? negative_texels(images_[i]) : 0);
    if (broken > 0)
      warnings_.push_back({exit, std::to_string(broken) + " pixels of the image '" + images_[i].name +
                                     "' of " + what + " are negative or no numbers; they count as 0"});
    const auto [it, is_new] = image_numbers_.emplace(i, static_cast<int>(edits_.images_.size()));
    if (is_new) edits_.images_.push_back(images_[i]);
    return it->second;
  }

  // Design §2: δ from the quads' size and the scene's largest coordinate, then planes.
  void place() {
    Box quads;
    for (const Edit& e : edits_.edits_)
      for_each_quad(descriptions_[e.description], [&](const QuadDescription& q) { extend(quads, q); });
    if (quads.isEmpty()) return;
    Box all = space_.bounds;
    all.extendBy(quads);
    const double m = largest_coordinate(quads, quads.center()), w = largest_coordinate(all, V3d(0));
    edits_.delta_ = std::max(0x1p-17 * m, 0x1p-22 * w);

    std::vector<Quad*> list;
    for (Edit& e : edits_.edits_) {
      list.push_back(&e.entry);
      for (Exit& x : e.exits) list.push_back(&x.quad);
    }
    // Light from infinity starts outside of all bounds, hence the factor.
    const int groups = place_quads(list, edits_.delta_, 4 * largest_coordinate(all, space_.centre), cancel_);
    edits_.groups_.resize(static_cast<std::size_t>(groups));
  }

  void compile_expressions(std::span<const Entity> entities) {
    const auto entity_of = [](const EditDescription& d) {
      Entity entity{{d.entry.name}};
      entity.names.insert(entity.names.end(), d.collections.begin(), d.collections.end());
      return entity;
    };
    std::vector<Rule> rules;
    std::vector<Entity> gates, known;
    for (std::size_t i = 0; i < edits_.edits_.size(); ++i) {
      const Edit& e = edits_.edits_[i];
      rules.push_back({e.name, &expressions_[i], e.repeat ? -1 : static_cast<int>(i), e.side == Side::View});
      gates.push_back(entity_of(descriptions_[e.description]));
    }
    for (std::size_t i = 0; i < layer_expressions_.size(); ++i)
      rules.push_back(
          {.name = said(edits_.layers_[i]), .expression = &layer_expressions_[i], .is_layer = true});
    // one that is off still exists by name
    for (const EditDescription& d : descriptions_) known.push_back(entity_of(d));
    warn_unknown_names(rules, entities, known, warnings_, cancel_);
    edits_.automata_ = compile_automata(rules, entities, gates, cancel_);
    find_reach(entities);
  }

  // Which edits any path of this scene can spell, and after which event. View paths go on by S alone: at the
  // first D or G lobe they end.
  void find_reach(std::span<const Entity> entities) {
    for (const Side side : {Side::Light, Side::View}) {
      const bool light = side == Side::Light;
      std::vector<char> occurs(static_cast<std::size_t>(edits_.automata_.alphabet.size()), 0);
      for (std::size_t i = 0; i < entities.size(); ++i)
        for (const Event e : {Event::L, Event::D, Event::S, Event::G})
          if ((entities[i].events & mask_of(e)) && (light || e == Event::S))
            occurs[edits_.event_class(e, static_cast<int>(i))] = 1;
      if (!light) occurs[edits_.event_class(Event::E, -1)] = 1;
      for (int i = 0; i < edits_.size(); ++i) occurs[edits_.gate_class(i)] = 1;
      edits_.reach_[index(side)] =
          Reach(light ? edits_.automata_.forward : edits_.automata_.backward, occurs, edits_.size(), cancel_);
    }
    for (int i = 0; i < edits_.size(); ++i)
      if (!contains(edits_.could_take(edits_[i].side), i))
        warnings_.push_back({edits_[i].name,
                             "no path of this scene can match its expression (lights, materials and names as "
                             "they are); the edit does nothing"});
  }

  void index_quads() {
    for (int i = 0; i < edits_.size(); ++i) {
      const Edit& e = edits_[i];
      const std::size_t side = index(e.side);
      const auto add = [&](int exit) {
        const QuadId id{i, exit};
        const Quad& q = edits_.quad(i, exit);
        (exit < 0 ? edits_.entries_ : edits_.exits_)[side].add(q, id);
        edits_.groups_[static_cast<std::size_t>(q.group)].push_back(id);
      };
      add(QuadId::entry);
      for (int exit = 0; exit < static_cast<int>(e.exits.size()); ++exit) add(exit);
    }
    for (std::size_t side = 0; side < 2; ++side) {
      edits_.entries_[side].build();
      edits_.exits_[side].build();
    }
    for (auto& group : edits_.groups_)
      std::sort(group.begin(), group.end(), [&](const QuadId& a, const QuadId& b) {
        const auto key = [&](const QuadId& id) {
          return std::tuple(id.exit >= 0, edits_.quad(id.edit, id.exit).order, id.edit, id.exit);
        };
        return key(a) < key(b);
      });
  }

  std::span<const EditDescription> descriptions_;
  std::span<const Image> images_;
  const EditSpace& space_;
  Warnings& warnings_;
  const CancelPoint& cancel_;
  std::vector<Expression> expressions_;  // [edit]
  std::vector<Expression> layer_expressions_;
  std::map<std::size_t, int> image_numbers_;
  Edits edits_;
};

Edits compile_edits(std::span<const EditDescription> descriptions, std::span<const Entity> entities,
                    std::span<const Image> images, const EditSpace& space, int max_gates, Warnings& warnings,
                    std::span<const LayerDescription> layers, const CancelPoint& cancel) {
  return EditsBuilder(descriptions, images, space, warnings, cancel).build(entities, max_gates, layers);
}

}  // namespace sluice
