// SPDX-License-Identifier: GPL-3.0-or-later
// How what compiles a scene learns that nobody wants it any more. It asks at points less than a tenth of a
// second apart and ends by an exception, which is no error and does not leave compile(). Passes look at a
// flag instead.
#pragma once
#include <cstddef>
#include <functional>

namespace sluice {

struct Cancelled {};

class CancelPoint {
 public:
  CancelPoint() = default;  // never
  explicit CancelPoint(std::function<bool()> asked) : asked_(std::move(asked)) {}

  void operator()() const {
    if (asked_ && asked_()) throw Cancelled();
  }
  // In loops over small things, triangles or states.
  void at(std::size_t step) const {
    if (step % 65536 == 65535) (*this)();
  }

 private:
  std::function<bool()> asked_;
};

}  // namespace sluice
