// SPDX-License-Identifier: GPL-3.0-or-later
// Node programs: values against those that Cycles 3.4.1 renders from the same nodes, closed forms, and what
// depends on the point.
#include <gtest/gtest.h>

#include "shading_nodes.h"
#include "shading_statistics.h"

namespace sluice::test {
namespace {

const V3f vector_input(0.31f, -1.27f, 2.43f);

void expect_color(const Color& got, const V3f& wanted, double tolerance, const std::string& what) {
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(got[c], wanted[c], tolerance * std::max(1.0f, std::abs(wanted[c])))
        << what << ", channel " << c;
}

TEST(Nodes, MixLikeCycles) {
  const std::pair<const char*, V3f> table[] = {{"DARKEN", {0.32f, 0.3f, 0.15f}},
                                               {"MULTIPLY", {0.264f, 0.1845f, 0.129f}},
                                               {"BURN", {0.090909f, 0, 0.011628f}},
                                               {"LIGHTEN", {0.6f, 0.405f, 0.605f}},
                                               {"SCREEN", {0.656f, 0.5205f, 0.626f}},
                                               {"DODGE", {0.697674f, 0.437956f, 0.340909f}},
                                               {"ADD", {0.74f, 0.615f, 0.71f}},
                                               {"OVERLAY", {0.432f, 0.279f, 0.213f}},
                                               {"SOFT_LIGHT", {0.4992f, 0.2853f, 0.20355f}},
                                               {"LINEAR_LIGHT", {0.18f, 0.23f, 0.57f}},
                                               {"DIFFERENCE", {0.46f, 0.195f, 0.5f}},
                                               {"SUBTRACT", {0.46f, 0, 0}},
                                               {"DIVIDE", {2.28f, 0.556667f, 0.17625f}},
                                               {"HUE", {0.285f, 0.32625f, 0.465f}},
                                               {"SATURATION", {0.6f, 0.3f, 0.15f}},
                                               {"COLOR", {0.285f, 0.32625f, 0.465f}},
                                               {"VALUE", {0.74f, 0.37f, 0.185f}},
                                               {"MIX", {0.32f, 0.405f, 0.605f}}};
  const V3f a(0.6f, 0.3f, 0.15f), b(0.2f, 0.45f, 0.8f);
  for (const auto& [mode, wanted] : table) {
    Tree old, current;
    const int x = old.add("MixRGB", {{"blend_type", mode}}),
              y = current.add("Mix", {{"data_type", "RGBA"}, {"blend_type", mode}});
    old.set(x, "Fac", 0.7f).set(x, "Color1", a).set(x, "Color2", b);
    current.set(y, "Factor", 0.7f).set(y, "A", a).set(y, "B", b);
    expect_color(old.value(x), wanted, 2e-6, mode);
    EXPECT_EQ(current.value(y), old.value(x));
  }
}

struct Row {
  std::string kind;
  std::map<std::string, std::string> options;
  std::vector<std::pair<std::string, V3f>> inputs;
  std::string output;
  V3f wanted;
  float offset = 0;  // added before comparing: emission has no negative values
};

TEST(Nodes, ValuesLikeCycles) {
  const V3f skin(0.6f, 0.3f, 0.15f), v = vector_input, w(0.31f, 0.27f, 0.2f);
  const auto n = [](float x) { return V3f(x); };
  std::vector<Row> rows = {
      {"HueSaturation",
       {},
       {{"Hue", n(0.7f)}, {"Saturation", n(0.8f)}, {"Value", n(1.3f)}, {"Fac", n(0.9f)}, {"Color", skin}},
       "Color",
       {0.53736f, 0.732f, 0.2958f}},
      {"BrightContrast",
       {},
       {{"Bright", n(0.2f)}, {"Contrast", n(0.4f)}, {"Color", skin}},
       "Color",
       {0.84f, 0.42f, 0.21f}},
      {"Gamma", {}, {{"Gamma", n(2.2f)}, {"Color", skin}}, "Color", {0.325037f, 0.07074f, 0.015396f}},
      {"Invert", {}, {{"Fac", n(0.8f)}, {"Color", skin}}, "Color", {0.44f, 0.62f, 0.71f}},
      {"TexChecker", {}, {{"Vector", v}, {"Scale", n(5)}}, "Fac", n(0)},
      {"TexChecker", {}, {{"Vector", {0.1f, 0.1f, 0.3f}}, {"Scale", n(5)}}, "Fac", n(1)},
      {"CombineColor",
       {{"mode", "HSV"}},
       {{"Red", n(0.6f)}, {"Green", n(0.7f)}, {"Blue", n(0.4f)}},
       "Color",
       {0.12f, 0.232f, 0.4f}},
      {"CombineColor",
       {{"mode", "HSL"}},
       {{"Red", n(0.6f)}, {"Green", n(0.7f)}, {"Blue", n(0.4f)}},
       "Color",
       {0.12f, 0.344f, 0.68f}},
      {"SeparateColor", {{"mode", "HSV"}}, {{"Color", {0.3f, 0.8f, 0.5f}}}, "Green", n(0.625f)},
      {"SeparateColor", {{"mode", "HSL"}}, {{"Color", {0.3f, 0.8f, 0.5f}}}, "Green", n(0.555556f)},
      {"SeparateColor", {{"mode", "HSL"}}, {{"Color", {0.3f, 0.8f, 0.5f}}}, "Blue", n(0.55f)},
  };
  const std::pair<const char*, float> gradients[] = {
      {"LINEAR", 0.31f},        {"QUADRATIC", 0.0961f},          {"EASING", 0.228718f}, {"DIAGONAL", 0.29f},
      {"SPHERICAL", 0.542834f}, {"QUADRATIC_SPHERE", 0.294669f}, {"RADIAL", 0.614041f}};
  for (const auto& [type, wanted] : gradients)
    rows.push_back({"TexGradient", {{"gradient_type", type}}, {{"Vector", w}}, "Fac", n(wanted)});
  const std::tuple<const char*, const char*, float> waves[] = {
      {"BANDS", "SIN", 0.211445f}, {"BANDS", "SAW", 0.15209f},  {"BANDS", "TRI", 0.30418f},
      {"RINGS", "SIN", 0.014189f}, {"RINGS", "SAW", 0.038006f}, {"RINGS", "TRI", 0.076012f}};
  for (const auto& [type, profile, wanted] : waves)
    rows.push_back({"TexWave",
                    {{"wave_type", type},
                     {"wave_profile", profile},
                     {"bands_direction", "DIAGONAL"},
                     {"rings_direction", "Y"}},
                    {{"Vector", w},
                     {"Scale", n(1.7f)},
                     {"Distortion", n(1.5f)},
                     {"Detail", n(2)},
                     {"Detail Scale", n(1.3f)},
                     {"Detail Roughness", n(0.6f)},
                     {"Phase Offset", n(0.4f)}},
                    "Fac",
                    n(wanted)});
  const std::tuple<float, float, float, float> noises[] = {
      {2.0f, 0.6f, 0.0f, 0.554394f}, {3.5f, 0.6f, 0.0f, 0.572403f}, {2.0f, 0.6f, 0.8f, 0.459356f}};
  for (const auto& [detail, rough, distortion, wanted] : noises)
    rows.push_back({"TexNoise",
                    {},
                    {{"Vector", v},
                     {"Scale", n(3.3f)},
                     {"Detail", n(detail)},
                     {"Roughness", n(rough)},
                     {"Distortion", n(distortion)}},
                    "Fac",
                    n(wanted)});
  rows.push_back(
      {"TexNoise",
       {},
       {{"Vector", v}, {"Scale", n(3.3f)}, {"Detail", n(2)}, {"Roughness", n(0.5f)}, {"Distortion", n(0)}},
       "Color",
       {0.555517f, 0.416145f, 0.650167f}});
  const std::pair<const char*, V3f> mappings[] = {{"POINT", {10.838601f, 7.453976f, 14.366936f}},
                                                  {"TEXTURE", {10.083471f, 9.524205f, 11.286011f}},
                                                  {"VECTOR", {10.738602f, 7.253976f, 14.066936f}},
                                                  {"NORMAL", {10.713796f, 9.364843f, 10.295079f}}};
  for (const auto& [type, wanted] : mappings)
    rows.push_back({"Mapping",
                    {{"vector_type", type}},
                    {{"Vector", v},
                     {"Location", {0.1f, 0.2f, 0.3f}},
                     {"Rotation", {0.3f, -0.5f, 0.9f}},
                     {"Scale", {1.5f, 0.7f, 2}}},
                    "Vector",
                    wanted,
                    10});
  const std::pair<const char*, float> maths[] = {
      {"POWER", 5.478507f}, {"LOGARITHM", 4.986704f}, {"SMOOTH_MIN", 1.3f}, {"SMOOTH_MAX", 3.7f},
      {"WRAP", 0.9f},       {"SNAP", 2.6f},           {"PINGPONG", 1.1f},   {"MODULO", 1.1f},
      {"COMPARE", 0},       {"ARCTAN2", 1.232918f},   {"ROUND", 4},         {"TRUNC", 3},
      {"FRACT", 0.7f}};
  for (const auto& [operation, wanted] : maths)
    rows.push_back({"Math",
                    {{"operation", operation}},
                    {{"Value", n(3.7f)}, {"Value_001", n(1.3f)}, {"Value_002", n(0.6f)}},
                    "Value",
                    n(wanted)});
  const std::pair<const char*, V3f> vectors[] = {{"PROJECT", {9.926733f, 9.670297f, 9.853465f}},
                                                 {"REFLECT", {10.446535f, 9.959406f, 10.793069f}},
                                                 {"REFRACT", {10.165599f, 9.105194f, 10.251198f}},
                                                 {"FACEFORWARD", {9.7f, 10.7f, 9.5f}},
                                                 {"WRAP", {9.6f, 10.9f, 10.3f}},
                                                 {"SNAP", {10.2f, 9.1f, 10.4f}},
                                                 {"MODULO", {10.1f, 9.3f, 10.1f}},
                                                 {"CROSS_PRODUCT", {9.27f, 9.98f, 10.41f}}};
  for (const auto& [operation, wanted] : vectors)
    rows.push_back({"VectorMath",
                    {{"operation", operation}},
                    {{"Vector", {0.3f, -0.7f, 0.5f}},
                     {"Vector_001", {0.2f, 0.9f, 0.4f}},
                     {"Vector_002", {-0.5f, 0.1f, 0.3f}},
                     {"Scale", n(0.8f)}},
                    "Vector",
                    wanted,
                    10});
  const std::pair<const char*, float> ranges[] = {
      {"LINEAR", 3.876923f}, {"STEPPED", 4}, {"SMOOTHSTEP", 3.816317f}, {"SMOOTHERSTEP", 3.77155f}};
  for (const auto& [type, wanted] : ranges)
    rows.push_back({"MapRange",
                    {{"interpolation_type", type}, {"clamp", "1"}},
                    {{"Value", n(0.37f)},
                     {"From Min", n(-0.2f)},
                     {"From Max", n(1.1f)},
                     {"To Min", n(3)},
                     {"To Max", n(5)},
                     {"Steps", n(4)}},
                    "Result",
                    n(wanted)});
  const std::pair<const char*, V3f> turns[] = {{"AXIS_ANGLE", {11.814846f, 8.940374f, 11.788136f}},
                                               {"EULER_XYZ", {11.33073f, 8.479084f, 11.805208f}},
                                               {"Y_AXIS", {11.632801f, 8.73f, 11.793828f}}};
  for (const auto& [type, wanted] : turns)
    rows.push_back({"VectorRotate",
                    {{"rotation_type", type}},
                    {{"Vector", v},
                     {"Center", {0.1f, 0.2f, 0.3f}},
                     {"Axis", {1, 2, 3}},
                     {"Angle", n(0.7f)},
                     {"Rotation", {0.3f, -0.5f, 0.9f}}},
                    "Vector",
                    wanted,
                    10});
  for (const Row& row : rows) {
    Tree tree;
    int node = tree.add(row.kind, row.options);
    for (const auto& [name, value] : row.inputs) tree.set(node, name, value);
    std::string output = row.output;
    if (row.offset != 0) {
      const int sum = tree.add("VectorMath", {{"operation", "ADD"}});
      tree.link(sum, "Vector", node, output).set(sum, "Vector_001", V3f(row.offset));
      node = sum, output = "Vector";
    }
    expect_color(tree.value(node, output), row.wanted, 1e-5,
                 row.kind + " " + (row.options.empty() ? "" : row.options.begin()->second));
    EXPECT_TRUE(tree.warnings.empty()) << tree.warnings.front().message;
  }
}

TEST(Nodes, BlackbodyLikeCycles) {
  const std::pair<float, V3f> table[] = {{1500.0f, {3.264307f, 0.434045f, 0}},
                                         {3000.0f, {1.77084f, 0.844284f, 0.272223f}},
                                         {6500.0f, {1.042551f, 0.984051f, 1.035271f}}};
  for (const auto& [kelvin, wanted] : table) {
    Tree tree;
    const int node = tree.add("Blackbody");
    tree.set(node, "Temperature", kelvin);
    const Color got = tree.value(node);
    expect_color(got, wanted, 3e-3, "blackbody");
    EXPECT_NEAR(luminance(got), 1, 5e-3);
  }
}

TEST(Nodes, RampsAndCurvesReadTheirTables) {
  Tree tree;
  const int ramp = tree.add("ValToRGB", {{"interpolation", "LINEAR"}}),
            curve = tree.add("RGBCurve", {{"min", "-1"}, {"max", "1"}});
  tree.at(ramp).table = {0, 0, 0, 1, 1, 0.5f, 0, 0.5f, 1, 1, 1, 0};
  tree.set(ramp, "Fac", 0.25f);
  tree.at(curve).table = {-1, -1, -1, 1, 1, 0, 3, 1};
  tree.set(curve, "Fac", 0.5f).set(curve, "Color", V3f(0.5f, 0.5f, 0.5f));
  expect_color(tree.value(ramp, "Color"), V3f(0.5f, 0.25f, 0), 1e-6, "ramp");
  EXPECT_NEAR(tree.value(ramp, "Alpha").x, 0.75, 1e-6);
  // half way from 0.5 to (0.5, -0.25, 2)
  expect_color(tree.value(curve), V3f(0.5f, 0.125f, 1.25f), 1e-6, "curve");
  EXPECT_TRUE(tree.warnings.empty());
  Tree broken;
  const int empty = broken.add("ValToRGB");
  broken.set(empty, "Fac", 0.3f);
  EXPECT_NEAR(broken.value(empty, "Color").x, 0.3, 1e-6);
  EXPECT_EQ(broken.warnings.size(), 1u);
}

TEST(Nodes, FresnelAndLayerWeight) {
  SurfacePoint point;
  point.wo = direction(0.4);
  const auto get = [&](const char* kind, const char* input, float value, const char* output) {
    Tree tree;
    const int node = tree.add(kind);
    tree.set(node, input, value);
    return tree.value(node, output, point).x;
  };
  EXPECT_NEAR(get("Fresnel", "IOR", 1.5f, "Fac"), fresnel_dielectric(0.4f, 1.5f), 1e-6);
  EXPECT_NEAR(get("LayerWeight", "Blend", 0.5f, "Facing"), 0.6, 1e-6);
  EXPECT_NEAR(get("LayerWeight", "Blend", 0.25f, "Facing"), 1 - std::sqrt(0.4), 1e-6);
  EXPECT_NEAR(get("LayerWeight", "Blend", 0.5f, "Fresnel"), fresnel_dielectric(0.4f, 2), 1e-6);
  point.front = false;
  EXPECT_NEAR(get("Fresnel", "IOR", 1.5f, "Fac"), fresnel_dielectric(0.4f, 1 / 1.5f), 1e-6);
}

TEST(Nodes, CoordinatesOfThePoint) {
  ObjectShading object;
  object.object_to_world.makeIdentity();
  object.object_to_world.setTranslation(V3f(10, 20, 30));
  object.world_to_object = object.object_to_world.inverse();
  object.texture_origin = V3f(-1);
  object.texture_size = V3f(2, 2, 4);
  object.color = Color(0.1f, 0.2f, 0.3f);
  object.random = 0.75f;
  SurfacePoint point;
  point.object = &object;
  point.position = V3f(10.5f, 20, 31);
  point.uv[0].uv = V2f(0.25f, 0.75f);
  point.colors[0] = Color(0.7f, 0.2f, 0.1f);
  const auto get = [&](const char* kind, const char* output) {
    Tree tree;
    return tree.value(tree.add(kind), output, point);
  };
  EXPECT_EQ(get("TexCoord", "Generated"), V3f(0.75f, 0.5f, 0.5f));
  EXPECT_EQ(get("TexCoord", "Object"), V3f(0.5f, 0, 1));
  EXPECT_EQ(get("TexCoord", "UV"), V3f(0.25f, 0.75f, 0));
  EXPECT_EQ(get("UVMap", "UV"), V3f(0.25f, 0.75f, 0));
  EXPECT_EQ(get("NewGeometry", "Position"), point.position);
  EXPECT_EQ(get("NewGeometry", "Normal"), V3f(0, 0, 1));
  EXPECT_EQ(get("ObjectInfo", "Location"), V3f(10, 20, 30));
  EXPECT_EQ(get("ObjectInfo", "Color"), object.color);
  EXPECT_EQ(get("ObjectInfo", "Random"), V3f(0.75f));
  EXPECT_EQ(get("VertexColor", "Color"), point.colors[0]);
  EXPECT_EQ(get("LightPath", "Is Camera Ray"), V3f(1));
}

TEST(Nodes, NeedsNameTheLayers) {
  Tree tree;
  const int a = tree.add("UVMap", {{"uv_map", "Second"}}), b = tree.add("TexCoord"),
            c = tree.add("VertexColor", {{"layer_name", "Dirt"}}), sum = tree.add("VectorMath"),
            all = tree.add("VectorMath");
  tree.link(sum, "Vector", a, "UV")
      .link(sum, "Vector_001", b, "UV")
      .link(all, "Vector", sum, "Vector")
      .link(all, "Vector_001", c, "Color");
  const int emission = tree.add("Emission");
  tree.link(emission, "Color", all, "Vector").set(emission, "Strength", 1);
  const Material material = tree.compile(emission);
  EXPECT_EQ(material.needs().uv_maps, (std::vector<std::string>{"Second", ""}));
  EXPECT_EQ(material.needs().color_layers, std::vector<std::string>{"Dirt"});
  EXPECT_FALSE(material.needs().uv_gradients);
}

// A height of amplitude·sin along x: the normal is the surface's own.
TEST(Nodes, BumpIsTheSlopeOfItsHeight) {
  for (const bool by_uv : {false, true}) {
    Tree tree;
    const int where = tree.add(by_uv ? "TexCoord" : "NewGeometry"), split = tree.add("SeparateXYZ"),
              sine = tree.add("Math", {{"operation", "SINE"}}), bump = tree.add("Bump", {{"invert", "0"}});
    tree.link(split, "Vector", where, by_uv ? "UV" : "Position")
        .link(sine, "Value", split, "X")
        .link(bump, "Height", sine, "Value");
    tree.set(sine, "Value_001", 0).set(bump, "Strength", 1).set(bump, "Distance", 0.5f);
    ObjectShading object;
    object.object_to_world.makeIdentity();
    object.world_to_object.makeIdentity();
    object.bump_step = 1e-3f;
    SurfacePoint point;
    point.object = &object;
    point.position = V3f(0.8f, 0.1f, 0);
    point.uv[0] = {V2f(0.8f, 0.1f), V3f(1, 0, 0), V3f(0, 1, 0)};
    const int offset = tree.add("VectorMath", {{"operation", "ADD"}});
    tree.link(offset, "Vector", bump, "Normal").set(offset, "Vector_001", V3f(1));
    const V3f got = tree.value(offset, "Vector", point) - V3f(1),
              wanted = V3f(-0.5f * std::cos(0.8f), 0, 1).normalized();
    expect_color(got, wanted, 2e-3, by_uv ? "uv" : "position");
    const int diffuse = tree.add("BsdfDiffuse");
    tree.set(diffuse, "Color", V3f(1)).set(diffuse, "Roughness", 0).link(diffuse, "Normal", bump, "Normal");
    const Material material = tree.compile(diffuse);
    EXPECT_EQ(material.needs().uv_gradients, by_uv);
    expect_color(shaded(material, point).lobes[0].n, wanted, 2e-3, "lobe");
  }
}

TEST(Nodes, NormalMapTurnsTheTangentFrame) {
  const V3f local(0.3f, -0.2f, std::sqrt(1 - 0.09f - 0.04f)), encoded = local * 0.5f + V3f(0.5f);
  SurfacePoint point;  // u grows along +y, v along -x: a frame turned by 90°
  point.uv[0] = {V2f(0.5f), V3f(0, 2, 0), V3f(-2, 0, 0)};
  const auto normal = [&](float strength) {
    Tree tree;
    const int map = tree.add("NormalMap", {{"space", "TANGENT"}}), diffuse = tree.add("BsdfDiffuse");
    tree.set(map, "Strength", strength)
        .set(map, "Color", encoded)
        .set(diffuse, "Color", V3f(1))
        .set(diffuse, "Roughness", 0)
        .link(diffuse, "Normal", map, "Normal");
    const Material material = tree.compile(diffuse);
    EXPECT_TRUE(material.needs().uv_gradients);
    return shaded(material, point).lobes[0].n;
  };
  expect_color(normal(1), V3f(0.2f, 0.3f, local.z), 1e-5, "full");  // t = +y, b = -x
  expect_color(normal(0), V3f(0, 0, 1), 1e-5, "off");
  // seen from the back the true normal is -z: t = +y, b = -x still, and z is turned over with the flip
  point.front = false;
  const V3f behind = normal(1);
  expect_color(V3f(behind.x, behind.y, behind.z), V3f(-0.2f, -0.3f, local.z), 1e-5, "behind");
}

}  // namespace
}  // namespace sluice::test
