// SPDX-License-Identifier: GPL-3.0-or-later
// Small scenes for the oracles: a floor that the camera looks at from above, a wall, and what a case adds.
#pragma once
#include "edit_scene.h"
#include "scene_fixtures.h"
#include "transport/settings.h"

namespace sluice::oracle {

using test::add, test::glowing, test::grid, test::input, test::one_node, test::place, test::sphere;

inline MaterialDescription painted(const Color& c) {
  return one_node("painted", "BsdfDiffuse", {input("Color", c.x, c.y, c.z), input("Roughness", 0)});
}
inline MaterialDescription translucent(const Color& c) {
  return one_node("translucent", "BsdfTranslucent", {input("Color", c.x, c.y, c.z)});
}
inline MaterialDescription mirror(const Color& c) {
  return one_node("mirror", "BsdfGlossy", {input("Color", c.x, c.y, c.z), input("Roughness", 0)});
}
inline MaterialDescription glossy(const Color& c, float roughness) {
  return one_node("glossy", "BsdfGlossy", {input("Color", c.x, c.y, c.z), input("Roughness", roughness)});
}
inline MaterialDescription glass(const Color& c, float ior) {
  return one_node("glass", "BsdfGlass",
                  {input("Color", c.x, c.y, c.z), input("Roughness", 0), input("IOR", ior)});
}
inline MaterialDescription sky(const Color& c) { return test::background(c, 1); }
// `part` of b over a.
inline MaterialDescription mixed(const MaterialDescription& a, const MaterialDescription& b, float part) {
  MaterialDescription m;
  m.name = "mixed";
  m.nodes = {a.nodes[0],
             b.nodes[0],
             {"MixShader",
              "MixShader",
              {input("Fac", part), {"Shader", {}, 0, ""}, {"Shader_001", {}, 1, ""}},
              {},
              {},
              -1}};
  m.surface = 2;
  return m;
}

// a where it is seen head-on, b where at grazing angles, nothing between.
inline MaterialDescription faced(const MaterialDescription& a, const MaterialDescription& b, float from) {
  MaterialDescription m = mixed(a, b, 0);
  m.nodes.push_back(
      {"LayerWeight", "LayerWeight", {input("Blend", 0.5f), {"Normal", {}, -1, ""}}, {}, {}, -1});
  m.nodes.push_back({"Math",
                     "Math",
                     {{"Value", {}, 3, "Facing"}, input("Value_001", from), input("Value_002", 0)},
                     {{"operation", "GREATER_THAN"}},
                     {},
                     -1});
  m.nodes[2].inputs[0] = {"Fac", {}, 4, ""};
  return m;
}

// Looks along `z`: a quad or plate whose local Z is that direction, turned about it by `turn`.
inline M44d facing(const V3d& z, const V3d& at, double half_x = 1, double half_y = 1, double turn = 0) {
  const V3d n = z.normalized(), side = std::abs(n.z) < 0.9 ? V3d(0, 0, 1) : V3d(0, 1, 0);
  const V3d a = side.cross(n).normalized(), b = n.cross(a);
  const V3d x = a * std::cos(turn) + b * std::sin(turn), y = n.cross(x);
  return placed(x * half_x, y * half_y, n, at);
}

struct Stage {
  SceneDescription scene;
  TransportSettings settings;
  double gather_radius = 0.03;

  // `wall` makes indirect light; the camera sees the floor alone, within about 0.8 m of the origin.
  explicit Stage(bool wall = true) {
    scene.camera.matrix = facing(V3d(0, -2.4, 2.6), V3d(0, -2.4, 2.6));
    scene.camera.lens = 100, scene.camera.sensor_width = 36;
    scene.frame = {32, 32, 1, 1, 0, 0, 32, 32, 1, true};
    settings.max_depth = 4, scene.max_gates = 3;
    settings.photons = 8192;
    settings.caustic_radius_factor = 0.4f;
    plate("Floor", facing({0, 0, 1}, {0, 0, 0}, 2, 2), painted({0.8f, 0.55f, 0.35f}));
    if (wall) plate("Wall", facing({0, -1, -0.6}, {0, 1.2, 1.1}, 1.8, 1.2), painted({0.3f, 0.5f, 0.9f}));
  }

  InstanceDescription& plate(const std::string& name, const M44d& matrix,
                             const MaterialDescription& material) {
    return place(scene, add(scene, grid(1)), matrix, add(scene, material), name);
  }
  InstanceDescription& solid(const std::string& name, MeshDescription mesh, const V3d& at, double size,
                             const MaterialDescription& material) {
    return place(scene, add(scene, std::move(mesh)), placed({size, 0, 0}, {0, size, 0}, {0, 0, size}, at),
                 add(scene, material), name);
  }
  LightDescription& lamp(const std::string& name, LightKind kind, const M44d& matrix, float power,
                         const Color& color = Color(1)) {
    LightDescription light;
    light.names = {name};
    light.kind = kind, light.matrix = matrix, light.power = power, light.color = color;
    scene.lights.push_back(light);
    return scene.lights.back();
  }
  // A ceiling light, 2 half_size wide, looking down.
  LightDescription& area(const std::string& name, const V3d& at, float size, float power,
                         const Color& color = Color(1)) {
    LightDescription& light = lamp(name, LightKind::Area, facing({0, 0, 1}, at), power, color);
    light.shape = AreaShape::Square, light.size_x = light.size_y = size;
    return light;
  }
  void world(const Color& c) {
    scene.world.name = "World";
    scene.world.material = add(scene, sky(c));
  }
  EditDescription& edit(const std::string& name, const std::string& expression, const M44d& matrix,
                        double half) {
    scene.edits.push_back(edit_at(name, matrix, expression, order_, half));
    order_ += 10;
    return scene.edits.back();
  }
  ExitDescription& exit(EditDescription& edit, const M44d& matrix, double half) {
    edit.exits.push_back(
        exit_at(edit.entry.name + " exit " + std::to_string(edit.exits.size()), matrix, order_, half));
    order_ += 10;
    return edit.exits.back();
  }

 private:
  int order_ = 10;
};

}  // namespace sluice::oracle
