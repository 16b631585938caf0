// SPDX-License-Identifier: GPL-3.0-or-later
// The core against the eye path tracer (design §5, oracle b) on small scenes: mirrors, glass and gates in
// front of the eye, view edits, edits on every segment from light to eye. Lights have extent here, so that
// chance finds them.
#include "oracle/compare.h"
#include "oracle/random_edits.h"

namespace sluice::oracle {
namespace {

// A large warm ceiling lamp and a cool world.
Stage under_ceiling(bool wall = true) {
  Stage s(wall);
  s.area("Lamp", {0.2, -0.2, 1.8}, 1.6f, 30, {1, 0.8f, 0.5f});
  s.world({0.15f, 0.25f, 0.4f});
  return s;
}

// The camera looks into a mirror on the floor and at the floor around it.
Stage with_mirror() {
  Stage s = under_ceiling();
  s.plate("Mirror", facing({0, -0.2, 1}, {0, 0.1, 0.15}, 0.45, 0.35), mirror({0.9f, 0.85f, 0.8f}));
  return s;
}

TEST(EyeOracle, no_edit) {
  compare("no edit", under_ceiling(), Which::Eye, everything);
  compare("no edit, mirror", with_mirror(), Which::Eye, everything);
}

TEST(EyeOracle, gates_in_front_of_the_eye) {
  Stage s = under_ceiling();
  auto& e = s.edit("In", "LD'Floor'", facing({0, -0.5, 1}, {0.3, -0.1, 0.4}), 0.3);
  s.exit(e, facing({0.2, -0.6, 1}, {-0.3, -0.1, 0.5}, 1, 1, 0.3), 0.3).hue_shift = 1.2f;
  s.scene.edits[0].exits[0].tint = {0.2f, 0.1f, 0.6f};
  compare("what the floor sends to the eye, moved", s, Which::Eye, everything);
  s.scene.edits[0].expression = "L.*";
  s.scene.edits[0].amount = 0.6f, s.scene.edits[0].feather = 0.5f;
  s.scene.edits[0].exits[0].keep_brightness = false;
  s.scene.edits[0].exits[0].quad.half_size = 0.4;
  compare("any light, partly, to a larger exit", s, Which::Eye, everything);
}

TEST(EyeOracle, edits_in_a_mirror) {
  Stage s = with_mirror();
  // red floor and blue wall; H acts on the colour of one path
  s.scene.materials[0] = painted({0.9f, 0.2f, 0.1f}), s.scene.materials[1] = painted({0.1f, 0.2f, 0.9f});
  auto& e = s.edit("In", "L.*S'Mirror'", facing({0, -0.6, 1}, {-0.1, -0.1, 0.4}), 0.3);
  s.exit(e, facing({0, -0.6, 1}, {0, -0.1, 0.45}), 0.3).hue_shift = std::numbers::pi_v<float> / 6;
  s.scene.edits[0].exits[0].tint = {0.5f, 0.8f, 0.3f};
  compare("hue of a mirror's picture", s, Which::Eye, everything);
  auto& f = s.edit("Before", "LD+", facing({0, 0.6, 1}, {0, 0.5, 0.5}), 0.4);
  s.exit(f, facing({0, 0.5, 1}, {0.1, 0.5, 0.6}, 1, 1, 0.5), 0.35).hue_shift = -2;
  compare("edits before and behind a mirror", s, Which::Eye, everything);
}

TEST(EyeOracle, quads_in_one_plane) {
  const auto chain = [](double height, double arrow, bool swapped) {
    Stage s = under_ceiling(false);
    s.scene.max_gates = 4;
    const V3d up(0, -0.3, 1), at(0, 0, 0.4);
    auto& a = s.edit("A", "LD", facing({0.2, -0.2, 1}, {0.25, 0, 0.25}), 0.3);
    s.exit(a, facing(up, at), 0.35).hue_shift = 0.5f;
    auto& b = s.edit("B", "L.*F'A'",
                     facing(up * arrow, at + up.normalized() * height + V3d(0.1, 0, 0), 1, 1, 0.3), 0.35);
    s.exit(b, facing({0, -0.2, 1}, {-0.25, 0, 0.3}), 0.3).intensity = 0.6f;
    auto& c = s.edit("C", "LDF'A'|LDF'A'F'B'|LD", facing(up, at - V3d(0.1, 0, 0), 1, 1, 1), 0.3);
    s.exit(c, facing(up, at + V3d(0.05, 0, 0), 0.7, 0.7), 0.3).hue_shift = 2;
    if (swapped) std::swap(s.scene.edits[1].entry.order, s.scene.edits[2].entry.order);
    return s;
  };
  const Stage plain = chain(0, 1, false);
  const double delta = Gates(plain.scene, *test::compiled(plain.scene)).delta();
  compare("quads in one plane before the eye", plain, Which::Eye, everything);
  compare("other order, 0.3 δ apart", chain(0.3 * delta, 1, true), Which::Eye, everything);
  compare("back to back", chain(0, -1, false), Which::Eye, everything);
  compare("opposite arrows, planes 0.3 δ apart", chain(2.3 * delta, -1, true), Which::Eye, everything);
}

TEST(EyeOracle, gates_used_once_and_capped) {
  Stage s = under_ceiling();
  auto& e = s.edit("Ring", "L.*", facing({0, -0.4, 1}, {0.1, 0, 0.3}), 0.4);
  // above its own entry, seen by eye and light
  s.exit(e, facing({0, -0.4, 1}, {0, 0, 0.6}), 0.4).intensity = 0.8f;
  auto& f = s.edit("Other", "LD|L.*F", facing({0, -0.4, 1}, {-0.1, 0, 0.5}), 0.4);
  s.exit(f, facing({0, -0.3, 1}, {0.2, 0, 0.2}), 0.4).hue_shift = 1;
  compare("once per path", s, Which::Eye, everything);
  s.scene.edits[0].repeat = s.scene.edits[1].repeat = true;
  s.scene.max_gates = 2;
  compare("repeat, at most two gates", s, Which::Eye, everything);
  s.settings.max_depth = 2;
  compare("two scatterings", s, Which::Eye, everything);
}

// Light between two surfaces that is seen by a gather segment: straight on only.
TEST(EyeOracle, gather_segment_crosses_an_exit) {
  Stage s = under_ceiling();
  auto& e = s.edit("In", "LD'Floor'", facing({0.5, 0, 1}, {0.9, 0.2, 0.4}), 0.4);
  s.exit(e, facing({0, -0.8, 1}, {0, 0.7, 0.5}), 0.6).intensity = 1.5f;
  auto& f = s.edit("Wall light", "L.*D'Wall'", facing({0, -0.8, 1}, {0, 0.75, 0.7}), 0.3);
  s.exit(f, facing({0, -0.5, 1}, {-0.1, 0.4, 0.5}), 0.3).hue_shift = 1;
  compare("gather segment crosses an exit", s, Which::Eye, everything);
}

TEST(EyeOracle, normal_map_and_textures) {
  Stage s = under_ceiling();
  std::vector<float> bumps, stripes;
  for (int i = 0; i < 16; ++i) {
    const float x = i % 4 < 2 ? 0.7f : 0.35f, y = i / 4 < 2 ? 0.6f : 0.3f;
    for (const float c : {x, y, 0.9f, 1.0f}) bumps.push_back(c);
    for (const float c : {0.2f + 0.05f * static_cast<float>(i), 0.5f, 0.8f, 1.0f}) stripes.push_back(c);
  }
  s.scene.images.push_back(make_image("bumps", 4, 4, bumps, ColorSpace::NonColor));
  s.scene.images.push_back(make_image("stripes", 4, 4, stripes, ColorSpace::Linear));
  auto& e = s.edit("In", "LD", facing({0, -0.5, 1}, {0.2, -0.1, 0.4}), 0.3);
  ExitDescription& x = s.exit(e, facing({0.2, -0.6, 1}, {-0.1, 0, 0.6}, 1, 1, 0.3), 0.35);
  x.normal_map = 0, x.intensity_texture = 1, x.hue_shift = 2, x.hue_shift_texture = 1;
  compare("normal map and textures before the eye", s, Which::Eye, everything);
  s.scene.edits[0].expression = "L";
  s.scene.edits[0].entry.matrix = facing({0.1, 0, 1}, {0.3, 0, 0.8});
  compare("normal map and textures in direct light", s, Which::Eye, everything);
}

// A table through the middle of a ball of glass, gates in the glass: radiance scales by η² in and out.
TEST(EyeOracle, inside_glass) {
  Stage s = under_ceiling();
  s.solid("Glass", sphere(5), {0, 0, 0.45}, 0.4, glass({0.9f, 1, 0.95f}, 1.5f));
  s.plate("Table", facing({0, 0, 1}, {0, 0, 0.45}, 1.1, 1.1), painted({0.9f, 0.4f, 0.3f}));
  s.settings.max_depth = 6;
  compare("a table in glass", s, Which::Eye, everything);
  auto& e = s.edit("Out of glass", "L.*D'Table'", facing({0, -0.5, 1}, {0.1, -0.1, 0.6}), 0.15);
  s.exit(e, facing({0, -0.6, 1}, {0.4, -0.4, 0.7}), 0.2);
  auto& f = s.edit("Into glass", "LD'Table'", facing({0, -0.5, 1}, {-0.5, -0.3, 0.6}), 0.25);
  s.exit(f, facing({0, -0.5, 1}, {-0.15, -0.1, 0.6}), 0.12).hue_shift = 2;
  compare("gates in glass", s, Which::Eye, everything);
}

TEST(EyeOracle, mixed_and_rough_surfaces) {
  Stage s = under_ceiling();
  s.scene.materials[0] = mixed(painted({0.7f, 0.4f, 0.3f}), mirror({0.9f, 0.9f, 0.9f}), 0.3f);
  s.scene.materials[1] = mixed(painted({0.3f, 0.5f, 0.9f}), glossy({0.9f, 0.9f, 0.9f}, 0.4f), 0.4f);
  compare("plastic floor, glossy wall", s, Which::Eye, everything);
  auto& e = s.edit("Gloss", "L.*S'Floor'", facing({0, -0.6, 1}, {0.1, -0.1, 0.3}), 0.4);
  s.exit(e, facing({0, -0.5, 1}, {0, 0, 0.45}), 0.4).hue_shift = 1;
  auto& f = s.edit("Sheen", "L.*G'Wall'", facing({0, -0.6, 1}, {0, 0.7, 0.6}), 0.5);
  s.exit(f, facing({0, -0.5, 1}, {0.1, 0.6, 0.5}), 0.5).intensity = 2;
  compare("plastic floor, glossy wall, edits by lobe", s, Which::Eye, everything);
  s.scene.materials[0] = mixed(painted({0.7f, 0.4f, 0.3f}), glossy({0.9f, 0.9f, 0.9f}, 0.09f), 0.5f);
  compare("a rough followed lobe", s, Which::Eye, everything);
}

// What a bundle shares must not depend on how its finder sees it. Straight light alone: materials that see
// the direction are not the same to photons and to the eye.
TEST(EyeOracle, far_ends_that_look_different_from_different_sides) {
  Stage s = under_ceiling(false);
  s.settings.max_depth = 2;
  s.plate("Screen", facing({0, -1, 0.2}, {0, 0.4, 0.3}, 0.6, 0.3), painted(Color(1)));
  const auto look = [&](const std::string& name, const MaterialDescription& screen) {
    s.scene.materials.back() = screen;
    compare(name, s, Which::Eye, everything, {.passes = 30, .side = 1});
  };
  look("a screen that is glossy at grazing angles",
       faced(painted({0.1f, 0.2f, 0.3f}), glossy({0.9f, 0.9f, 0.9f}, 0.5f), 0.4f));
  look("a screen that lets light through where seen head-on",
       faced(translucent({0.9f, 0.5f, 0.3f}), painted({0.3f, 0.8f, 0.3f}), 0.4f));
  look("a glossy screen", glossy({0.9f, 0.8f, 0.7f}, 0.35f));
}

TEST(EyeOracle, leaf_before_the_eye) {
  Stage s = under_ceiling();
  s.plate("Leaf", facing({0, -0.4, 1}, {0.1, -0.1, 0.5}, 0.35, 0.35, 0.3),
          mixed(painted({0.2f, 0.7f, 0.2f}), test::see_through({0.6f, 1, 0.5f}), 0.6f));
  auto& e = s.edit("In", "LD'Floor'|L", facing({0, -0.4, 1}, {0.2, -0.1, 0.3}), 0.35);
  s.exit(e, facing({0, -0.5, 1}, {-0.1, -0.2, 0.7}), 0.3).hue_shift = 1;
  s.scene.edits[0].exits[0].tint = {0.3f, 0.4f, 0.8f};
  compare("leaf before the eye", s, Which::Eye, everything);
}

TEST(EyeOracle, emissive_things_and_world) {
  Stage s;
  s.plate("Panel", facing({0, -0.8, -1}, {0, 0.7, 1.1}, 0.8, 0.3), glowing({1, 0.5f, 0.3f}, 6));
  s.plate("Mirror", facing({0, -0.2, 1}, {0, 0.1, 0.15}, 0.45, 0.35), mirror({0.9f, 0.85f, 0.8f}));
  s.world({0.3f, 0.4f, 0.6f});
  compare("emissive panel and world", s, Which::Eye, everything);
  auto& e = s.edit("Glow", "L'Panel'S?", facing({0, -0.6, 1}, {0.1, 0, 0.6}), 0.35);
  s.exit(e, facing({0.1, -0.3, 1}, {-0.1, -0.1, 0.4}), 0.3).hue_shift = 2;
  auto& f = s.edit("Sky", "L'World'", facing({0, 0, 1}, {-0.2, -0.1, 0.5}), 0.4);
  s.exit(f, facing({0.2, 0, -1}, {0.2, 0, 0.5}), 0.4).intensity = 1.5f;
  compare("emissive panel and world, edits by light", s, Which::Eye, everything);
}

TEST(EyeOracle, view_edits) {
  Stage s = with_mirror();
  auto& e = s.edit("Picture", "SE", facing({0, 0.3, 1}, {0, 0.3, 0.5}), 0.4);  // what the mirror shows
  s.exit(e, facing({0.2, 0.3, 1}, {-0.6, -0.2, 0.6}, 1, 1, 0.3), 0.4).hue_shift = 1;
  s.exit(e, facing({0, 0.3, 1}, {0.1, 0.2, 0.9}), 0.3).intensity = 0.5f;
  compare("a mirror's picture turned elsewhere", s, Which::Eye, everything);
  auto& v = s.edit("Window", "E", facing({0, -0.6, 1}, {0.2, -0.4, 0.7}), 0.2);  // a hole before the eye
  v.amount = 0.7f;
  s.exit(v, facing({0, -0.7, 1}, {-0.2, -0.4, 0.6}), 0.25).keep_brightness = false;
  auto& w = s.edit("Again", "F'Window'E|FSE", facing({0, -0.6, 1}, {-0.2, -0.35, 0.4}), 0.4);
  s.exit(w, facing({0, -0.7, 1}, {0.1, -0.3, 0.5}), 0.4);
  compare("view edits in a chain", s, Which::Eye, everything);
}

// Next-event estimation sees a lamp past a view edit that takes the path on to it: then the lamp's reflection
// is not there. The lamp is about as wide as the lobe, so that both ways of MIS have much of the light.
TEST(EyeOracle, view_edits_between_rough_followed_lobes_and_a_lamp) {
  Stage s(false);
  s.scene.specular_threshold = 0.35f;
  s.scene.materials[0] = glossy({0.9f, 0.8f, 0.7f}, 0.3f);
  s.lamp("Lamp", LightKind::Area, facing({0, 1.6, 1.75}, {0, 1.6, 1.75}), 10).size_x = 0.4f;
  compare("a rough mirror and a lamp", s, Which::Eye, everything);
  auto& e = s.edit("In", "S'Floor'E", facing({0, -0.6, 1}, {0.1, 0.8, 0.9}), 0.25);
  compare("the reflection of a lamp removed", s, Which::Eye, everything);
  s.scene.edits[0].amount = 0.6f, s.scene.edits[0].feather = 0.5f;
  compare("partly", s, Which::Eye, everything);
  s.exit(e, facing({0.2, -0.6, 1}, {-0.15, 0.7, 0.8}), 0.3).hue_shift = 1;
  compare("and moved", s, Which::Eye, everything);
  s.scene.materials[0] = mixed(painted({0.7f, 0.4f, 0.3f}), s.scene.materials[0], 0.5f);
  compare("of plastic, whose other lobe keeps its light", s, Which::Eye, everything);
  s.scene.edits[0].expression = "F S E";
  compare("an edit that does not match", s, Which::Eye, everything);
}

TEST(EyeOracle, view_and_light_edits_together) {
  Stage s = with_mirror();
  auto& v = s.edit("View", "SE|E", facing({0, -0.6, 1}, {0.1, -0.3, 0.6}), 0.3);
  s.exit(v, facing({0, -0.6, 1}, {-0.1, -0.2, 0.55}), 0.3).hue_shift = 1;
  s.scene.edits[0].exits[0].tint = {0.9f, 0.5f, 0.4f};
  auto& l = s.edit("Light", "L.*", facing({0, -0.5, 1}, {-0.1, -0.1, 0.3}), 0.35);
  s.exit(l, facing({0, -0.5, 1}, {0.1, 0, 0.5}), 0.35).intensity = 0.8f;
  // light that view edit sends to the eye
  auto& m = s.edit("After", "L.*F'View'|LD", facing({0, -0.6, 1}, {0, -0.5, 0.8}), 0.3);
  s.exit(m, facing({0, -0.6, 1}, {0.1, -0.5, 0.85}), 0.3).hue_shift = -1;
  compare("view and light edits", s, Which::Eye, everything);
}

// An entry laid on the light itself, on a mirror: quads float in front of what they lie on.
TEST(EyeOracle, entries_laid_on_lights_and_mirrors) {
  Stage lamp = under_ceiling();
  auto& a = lamp.edit("In", "L'Lamp'", facing({0, 0, -1}, {0.2, -0.2, 1.8}), 0.5);
  lamp.exit(a, facing({0.1, 0, -1}, {0, 0, 1}), 0.4);
  compare("entry laid on a lamp", lamp, Which::Eye, everything);
  compare("entry laid on a lamp, forward", lamp, Which::Forward, lit);
  Stage panel;
  panel.plate("Panel", facing({0, -0.8, -1}, {0, 0.7, 1.1}, 0.8, 0.3), glowing({1, 0.5f, 0.3f}, 6));
  panel.world({0.3f, 0.4f, 0.6f});
  auto& b = panel.edit("In", "L'Panel'", facing({0, -0.8, -1}, {0, 0.7, 1.1}, 0.8, 0.3), 0.5);
  panel.exit(b, facing({0.1, 0, -1}, {0, 0, 1}), 0.4);
  compare("entry laid on an emissive panel", panel, Which::Eye, everything);
  Stage reflection = with_mirror();
  auto& c = reflection.edit("In", "L.*S'Mirror'", facing({0, -0.2, 1}, {0, 0.1, 0.15}, 1, 1, 0.3), 0.3);
  reflection.exit(c, facing({0, -0.6, 1}, {0, -0.1, 0.45}), 0.3).hue_shift = 1;
  compare("entry laid on a mirror", reflection, Which::Eye, everything);
  Stage picture = with_mirror();
  auto& d = picture.edit("In", "SE", facing({0, -0.2, 1}, {0, 0.1, 0.15}, 1, 1, 0.3), 0.3);
  picture.exit(d, facing({0.3, 0, 1}, {-0.5, -0.1, 0.45}), 0.3).hue_shift = 1;
  compare("entry of a view edit laid on a mirror", picture, Which::Eye, everything);
}

// More branches than the split budget: one is chosen, with weight.
TEST(EyeOracle, many_exits) {
  Stage s = under_ceiling();
  auto& e = s.edit("In", "L.*", facing({0, -0.2, 1}, {0.1, 0, 0.5}, 1, 1, 0.3), 0.4);
  e.repeat = true;
  for (int i = 0; i < 7; ++i)
    s.exit(e,
           facing({0.3 * std::sin(i), 0.3 * std::cos(i), 1},
                  {0.3 * std::sin(i), 0.3 * std::cos(i), 0.1 + 0.1 * i}),
           0.25)
        .intensity = 0.4f;
  auto& v = s.edit("View", "E|FE", facing({0, -0.6, 1}, {0, -0.5, 0.8}), 0.3);
  for (int i = 0; i < 5; ++i)
    s.exit(v, facing({0.1 * std::sin(i), -0.6, 1}, {0.1 * std::sin(i), -0.4, 0.75 + 0.01 * i}), 0.25)
        .intensity = 0.3f;
  compare("many exits", s, Which::Eye, everything);
}

TEST(EyeOracle, three_edits_two_gates) {
  Stage s = with_mirror();
  s.scene.max_gates = 2;
  for (int i = 0; i < 3; ++i) {
    auto& e =
        s.edit("Edit" + std::to_string(i), i == 1 ? "L.*D" : "L.*",
               facing({0.2 * (i - 1), -0.5, 1}, {0.2 * (i - 1), -0.1 * i, 0.3 + 0.2 * i}, 1, 1, 0.3), 0.35);
    s.exit(e, facing({0, -0.5, 1}, {0.15 * (1 - i), -0.1 * i, 0.4 + 0.2 * ((i + 1) % 3)}), 0.35).hue_shift =
        static_cast<float>(i);
  }
  compare("three edits, two gates", s, Which::Eye, everything);
}

TEST(EyeOracle, round_lamps_and_a_sun) {
  Stage s;
  s.lamp("Sun", LightKind::Sun, facing({-0.4, -0.2, 1}, {0, 0, 3}), 0.8f).angle = 0.8f;
  s.lamp("Bulb", LightKind::Point, facing({0, 0, 1}, {-0.3, 0.2, 1}), 20, {0.4f, 0.6f, 1}).radius = 0.4f;
  LightDescription& spot =
      s.lamp("Spot", LightKind::Spot, facing({0.3, 0, 1}, {0.6, 0, 1.4}), 60, {1, 0.6f, 0.3f});
  spot.spot_angle = 1.8f, spot.radius = 0.3f;
  s.plate("Mirror", facing({0, -0.2, 1}, {0, 0.1, 0.15}, 0.45, 0.35), mirror({0.9f, 0.85f, 0.8f}));
  s.world({0.1f, 0.1f, 0.15f});
  auto& a = s.edit("A", "L'Sun,Bulb'S*", facing({0, 0, 1}, {0, 0, 0.4}), 0.4);
  s.exit(a, facing({0.3, 0, 1}, {0.2, 0.1, 0.6}, 1, 1, 0.5), 0.4);
  auto& b = s.edit("B", "L'World'.*|L'Spot'", facing({0, -0.3, 1}, {0.2, 0, 0.5}), 0.4);
  s.exit(b, facing({0, -0.3, 1}, {-0.2, 0.1, 0.3}), 0.4).intensity = 0.5f;
  compare("round lamps and a sun", s, Which::Eye, everything);
}

// Shading normals: flux takes Veach's adjoint factor, so that photons and eye paths agree.
TEST(EyeOracle, smooth_normals) {
  Stage s = under_ceiling();
  MeshDescription ball = sphere(8);
  for (const auto& triangle : ball.triangles)
    for (const std::uint32_t corner : triangle) ball.normals.push_back(ball.positions[corner]);
  s.solid("Ball", ball, {0, 0, 0.5}, 0.3, glass({0.95f, 1, 0.9f}, 1.5f));
  s.settings.max_depth = 6;
  compare("smooth ball of glass", s, Which::Eye, everything);
  s.scene.materials.back() = painted({0.8f, 0.8f, 0.3f});
  compare("smooth painted ball", s, Which::Eye, everything);
}

// Each switch alone gives its part, and nothing else but what no switch removes.
TEST(EyeOracle, each_effect_alone) {
  Stage s = with_mirror();
  auto& e = s.edit("In", "L.*", facing({0, -0.4, 1}, {0.1, 0, 0.4}), 0.35);
  s.exit(e, facing({0, -0.4, 1}, {-0.1, 0, 0.5}), 0.35).intensity = 0.8f;
  const auto scene = test::compiled(s.scene);
  Effort effort;
  if (is_full()) effort.passes *= full_effort, effort.paths *= full_effort;
  const std::vector<Regions> oracle = ask_oracle(s.scene, *scene, s.settings, Which::Eye, effort, 4711);
  for (const Part only : lit) {
    TransportSettings alone = s.settings;
    alone.use_direct = only == Part::Direct, alone.use_caustics = only == Part::Caustics;
    alone.use_edited = only == Part::Edited, alone.use_indirect = only == Part::Indirect;
    Counts counts;
    const std::vector<Regions> core =
        render_core(*scene, alone, {.seeds = effort.seeds, .passes = effort.passes, .first_seed = 815},
                    effort.side, pool(), counts);
    std::cout << report_line("alone " + std::to_string(static_cast<int>(only)), core, oracle, {only});
    for (const Part part : everything) {
      if (part == only || part == Part::Emission)
        expect_equal("effect alone", core, oracle, part);
      else
        EXPECT_TRUE(is_dark(core, part)) << static_cast<int>(part) << " with only " << static_cast<int>(only);
    }
  }
}

// Layers stand where the parts do, so that 0 and 4, which no photon reaches, are asked without tolerance.
TEST(EyeOracle, layers) {
  Stage s = with_mirror();
  s.scene.materials[1] = mixed(painted({0.3f, 0.5f, 0.9f}), glossy({0.9f, 0.9f, 0.9f}, 0.4f), 0.4f);
  auto& e = s.edit("In", "L.*S'Mirror'|LD", facing({0, -0.6, 1}, {-0.1, -0.1, 0.4}), 0.3);
  s.exit(e, facing({0, -0.6, 1}, {0, -0.1, 0.45}), 0.3).hue_shift = 1;
  auto& v = s.edit("View", "SE|E", facing({0, -0.6, 1}, {0.1, -0.3, 0.6}), 0.3);
  s.exit(v, facing({0, -0.6, 1}, {-0.1, -0.2, 0.55}), 0.3).intensity = 0.8f;
  s.scene.layers = {{"straight", "L D'Floor' [SF]* E"},
                    {"lamp, moved", "L'Lamp'.*F'In'.*E"},
                    {"gloss of the wall", "L.*G'Wall'.*E"},
                    {"by two bounces", "L'World'F*(!FF*){2}E"},
                    {"view of light sources", "L S*F'View'S*E"}};
  compare("layers", s, Which::Eye, everything, {.passes = 15});
}

TEST(EyeOracle, random_edits_everywhere) {
  const int count = is_full() ? 8 : 3;
  for (int seed = 1; seed <= count; ++seed) {
    Stage s = seed % 2 ? under_ceiling() : with_mirror();
    s.scene.max_gates = 2;
    EditMaker maker(static_cast<std::uint64_t>(seed));
    for (int i = 0; i < 4; ++i)
      maker.add(s, {.expressions = {"L", "L.*", "LD", "LD*", "L.*D'Wall'", "LF+D?", "L'World'.*", "L.*S",
                                    "L(!F)*", "L.*F.*"}});
    if (seed % 3 == 0) maker.add(s, {.expressions = {"E", "S*E", "SE", "F*SF*E"}});
    maker.shuffle_orders(s);
    compare("random edits " + std::to_string(seed), s, Which::Eye, everything);
  }
}

}  // namespace
}  // namespace sluice::oracle
