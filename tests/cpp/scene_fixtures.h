// SPDX-License-Identifier: GPL-3.0-or-later
// Small scenes for the tests of the scene room, and a plain random stream.
#pragma once
#include <gtest/gtest.h>

#include <random>

#include "edit/edits.h"
#include "scene/scene.h"
#include "shading/material.h"

namespace sluice::test {

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  double real(double low = 0, double high = 1) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  float unit() { return static_cast<float>(engine_() >> 8) * 0x1p-24f; }
  V2f pair() {
    const float x = unit();
    return {x, unit()};
  }
  V3f direction() { return sample_sphere(pair()).normalized(); }
  std::uint32_t bits() { return static_cast<std::uint32_t>(engine_()); }

 private:
  std::mt19937 engine_;
};

inline M44d translation(const V3d& t) {
  M44d m;
  m.setTranslation(t);
  return m;
}
inline M44d rotation(double x, double y, double z) {  // as Blender's XYZ Euler
  M44d m;
  m.setEulerAngles(V3d(x, y, z));
  return m;
}
inline M44d scaling(const V3d& s) {
  M44d m;
  m.setScale(s);
  return m;
}

// A grid of n × n squares over [-1, 1]², normal +z.
inline MeshDescription grid(int n = 1) {
  MeshDescription mesh;
  mesh.name = "grid";
  const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (n + 1) + x); };
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x)
      mesh.positions.emplace_back(-1 + 2.0f * static_cast<float>(x) / static_cast<float>(n),
                                  -1 + 2.0f * static_cast<float>(y) / static_cast<float>(n), 0);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      mesh.triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      mesh.triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  return mesh;
}

// Latitudes and longitudes, radius 1, normals outwards, convex.
inline MeshDescription sphere(int n = 16) {
  MeshDescription mesh;
  mesh.name = "sphere";
  const int around = 2 * n;
  mesh.positions.emplace_back(0, 0, -1);
  for (int y = 1; y < n; ++y)
    for (int x = 0; x < around; ++x) {
      const double theta = std::numbers::pi * y / n, phi = 2 * std::numbers::pi * x / around;
      mesh.positions.emplace_back(
          V3f(V3d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), -std::cos(theta))));
    }
  mesh.positions.emplace_back(0, 0, 1);
  const auto top = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  const auto at = [&](int y, int x) { return static_cast<std::uint32_t>(1 + (y - 1) * around + x % around); };
  for (int x = 0; x < around; ++x) {
    mesh.triangles.push_back({0, at(1, x + 1), at(1, x)});
    for (int y = 1; y + 1 < n; ++y) {
      mesh.triangles.push_back({at(y, x), at(y, x + 1), at(y + 1, x + 1)});
      mesh.triangles.push_back({at(y, x), at(y + 1, x + 1), at(y + 1, x)});
    }
    mesh.triangles.push_back({at(n - 1, x), at(n - 1, x + 1), top});
  }
  return mesh;
}

inline InputDescription input(const std::string& name, float x, float y, float z) {
  return {name, {x, y, z, 1}, -1, {}};
}
inline InputDescription input(const std::string& name, float x) { return {name, {x, x, x, x}, -1, {}}; }

inline MaterialDescription one_node(const std::string& name, const std::string& kind,
                                    std::vector<InputDescription> inputs) {
  MaterialDescription material;
  material.name = name;
  material.nodes.push_back({kind, kind, std::move(inputs), {}, {}, -1});
  material.surface = 0;
  return material;
}
inline MaterialDescription diffuse(float grey) {
  return one_node("diffuse", "BsdfDiffuse", {input("Color", grey, grey, grey), input("Roughness", 0)});
}
inline MaterialDescription glowing(const Color& c, float strength) {
  return one_node("glowing", "Emission", {input("Color", c.x, c.y, c.z), input("Strength", strength)});
}
inline MaterialDescription see_through(const Color& c) {
  return one_node("see-through", "BsdfTransparent", {input("Color", c.x, c.y, c.z)});
}
inline MaterialDescription background(const Color& c, float strength) {
  return one_node("sky", "Background", {input("Color", c.x, c.y, c.z), input("Strength", strength)});
}

inline int add(SceneDescription& scene, MeshDescription mesh) {
  scene.meshes.push_back(std::move(mesh));
  return static_cast<int>(scene.meshes.size()) - 1;
}
inline int add(SceneDescription& scene, MaterialDescription material) {
  scene.materials.push_back(std::move(material));
  return static_cast<int>(scene.materials.size()) - 1;
}
inline InstanceDescription& place(SceneDescription& scene, int mesh, const M44d& matrix = {},
                                  int material = -1, const std::string& name = "Object") {
  InstanceDescription instance;
  instance.names = {name};
  instance.mesh = mesh;
  instance.matrix = matrix;
  if (material >= 0) instance.materials = {material};
  scene.instances.push_back(instance);
  return scene.instances.back();
}

inline std::unique_ptr<const Scene> compiled(const SceneDescription& description) {
  Warnings warnings;
  return compile(description, warnings, {}, 1);
}

// Mean and standard error of a stream of numbers.
class Mean {
 public:
  void add(double x) { ++count_, sum_ += x, squares_ += x * x; }
  [[nodiscard]] double value() const { return sum_ / static_cast<double>(count_); }
  [[nodiscard]] double error() const {
    const double n = static_cast<double>(count_), m = value();
    return std::sqrt(std::max(0.0, squares_ / n - m * m) / n);
  }

 private:
  std::size_t count_ = 0;
  double sum_ = 0, squares_ = 0;
};

// Within 4 standard errors, or the given part of the expected value (what a quadrature or a tessellation
// leaves).
inline void expect_mean(const Mean& mean, double expected, const std::string& what, double part = 1e-5) {
  EXPECT_NEAR(mean.value(), expected, 4 * mean.error() + part * std::abs(expected))
      << what << ", standard error " << mean.error();
}

}  // namespace sluice::test
