// SPDX-License-Identifier: GPL-3.0-or-later
// A material as plain data: Blender's node tree, flattened (groups, reroutes and muted nodes are gone) to a
// list of nodes whose inputs are constants or references to other nodes' outputs. Strings are Blender's own
// words, so the exporter stays generic and a node this core does not know can still be named in a warning.
// Nothing is checked here; compile_material() checks all of it.
//
// kind     Blender's bl_idname without "ShaderNode" ("TexImage", "BsdfGlass"). Principled has two shapes:
//          "BsdfPrincipled" has the sockets of Blender 4 ("Specular IOR Level", "Coat Weight" ...),
//          "BsdfPrincipledV1" those of 3.x ("Specular", ...).
// inputs   by Blender's socket name; where names repeat (Math, Mix ...) they are numbered: "Value",
//          "Value_001", "Value_002". The Mix node of every data type has "Factor", "A", "B" and the output
//          "Result". A socket that is not linked and shows no value in Blender ("Normal", "Vector" of
//          textures, "Tangent") is left out: it means the node's implicit default.
// options  Blender's property name -> enum identifier, or "1"/"0" for booleans, or a number as text:
//            TexImage                       interpolation, extension, projection, projection_blend
//            TexEnvironment                 interpolation, projection
//            TexGradient                    gradient_type
//            Math, VectorMath               operation, use_clamp
//            Mix                            data_type, blend_type, clamp_factor, clamp_result, factor_mode
//            MixRGB                         blend_type, use_clamp
//            MapRange                       interpolation_type, data_type, clamp
//            Clamp                          clamp_type
//            Mapping                        vector_type
//            VectorTransform                vector_type, convert_from, convert_to
//            NormalMap                      space, uv_map
//            UVMap                          uv_map
//            Bump                           invert
//            Attribute, VertexColor         name, attribute_type
//            CombineColor, SeparateColor    mode
//            ValToRGB                       interpolation, color_mode
//            Bsdf*                          distribution
//          The node's own reader (nodes_*.cpp) has the rest.
// table    ValToRGB: 256 RGBA rows of the ramp over [0, 1]; RGBCurve, FloatCurve, VectorCurve: 256 RGBA rows
//          of the curves' values over [minimum, maximum], which are the options "min" and "max"
// image    index into the images given to compile_material(), -1 = none or missing
#pragma once
#include <array>
#include <map>
#include <string>
#include <vector>

namespace sluice {

struct InputDescription {
  std::string name;
  std::array<float, 4> value{};  // of an unlinked socket; numbers fill all four
  int node = -1;                 // index into MaterialDescription::nodes; -1 = unlinked
  std::string output;            // the output's name, numbered like inputs
};

struct NodeDescription {
  std::string kind;
  std::string name;  // for messages
  std::vector<InputDescription> inputs;
  std::map<std::string, std::string> options;
  std::vector<float> table;
  int image = -1;
};

// A surface material, or a world (its shader is a Background or Emission).
struct MaterialDescription {
  std::string name;
  std::vector<NodeDescription> nodes;
  // the node whose shader is the surface; -1 = black, as Blender draws an unlinked output
  int surface = -1;
  std::string surface_output;  // which of its outputs; may be empty when it has one
};

}  // namespace sluice
