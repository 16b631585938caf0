// SPDX-License-Identifier: GPL-3.0-or-later
// Short words for node trees in tests.
#pragma once
#include "shading/material.h"

namespace sluice::test {

struct Tree {
  MaterialDescription description{"Test", {}, -1, ""};
  Warnings warnings;

  // Adds a node; inputs and options follow by name.
  int add(const std::string& kind, std::map<std::string, std::string> options = {}) {
    NodeDescription node;
    node.kind = node.name = kind;
    node.options = std::move(options);
    description.nodes.push_back(std::move(node));
    return static_cast<int>(description.nodes.size()) - 1;
  }
  Tree& set(int node, const std::string& input, float x) { return put(node, {input, {x, x, x, x}, -1, ""}); }
  Tree& set(int node, const std::string& input, const V3f& v) {
    return put(node, {input, {v.x, v.y, v.z, 1}, -1, ""});
  }
  Tree& link(int node, const std::string& input, int from, const std::string& output = "") {
    return put(node, {input, {}, from, output});
  }
  NodeDescription& at(int node) { return description.nodes[static_cast<std::size_t>(node)]; }

  [[nodiscard]] Material compile(int surface, std::span<const Image> images = {}, float threshold = 0.1f) {
    description.surface = surface;
    return compile_material(description, images, threshold, warnings);
  }
  // What a value node gives at a point: it is made to shine.
  [[nodiscard]] Color value(int node, const std::string& output = "", const SurfacePoint& point = {},
                            std::span<const Image> images = {}) {
    const int emission = add("Emission");
    link(emission, "Color", node, output).set(emission, "Strength", 1);
    const Material material = compile(emission, images);
    Bsdf bsdf;
    shade(material, point, bsdf);
    return bsdf.emission;
  }

 private:
  Tree& put(int node, const InputDescription& input) {
    at(node).inputs.push_back(input);
    return *this;
  }
};

inline Bsdf shaded(const Material& material, const SurfacePoint& point = {}) {
  Bsdf bsdf;
  shade(material, point, bsdf);
  return bsdf;
}

}  // namespace sluice::test
