// SPDX-License-Identifier: GPL-3.0-or-later
// Errors and warnings of describing and compiling a scene. Nothing throws after that: per-path code drops and
// counts.
#pragma once
#include <stdexcept>
#include <string>
#include <vector>

namespace sluice {

// `item` is the name of the object, light, edit, material or image at fault; the message says what to do.
struct SceneError : std::runtime_error {
  std::string item;
  SceneError(std::string item_name, const std::string& message)
      : std::runtime_error(message), item(std::move(item_name)) {}
};

// `column` counts characters (code points) from 1.
struct ExpressionError : SceneError {
  int column;
  ExpressionError(std::string item_name, int at, const std::string& message)
      : SceneError(std::move(item_name), message), column(at) {}
};

struct Warning {
  std::string item, message;
};
using Warnings = std::vector<Warning>;

}  // namespace sluice
