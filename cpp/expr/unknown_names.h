// SPDX-License-Identifier: GPL-3.0-or-later
// Names in expressions that nothing bears.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "base/cancel.h"
#include "base/error.h"
#include "expr/alphabet.h"
#include "expr/rule.h"

namespace sluice {

// For each such name a warning on its rule, with the nearest name that exists.
void warn_unknown_names(std::span<const Rule> rules, std::span<const Entity> entities,
                        std::span<const Entity> gates, Warnings& warnings, const CancelPoint& cancel = {});

// The messages about one expression alone; `names` are those of objects, lights, collections and entries
// alike.
[[nodiscard]] std::vector<std::string> unknown_names(const Expression& expression,
                                                     std::span<const std::string> names);

}  // namespace sluice
