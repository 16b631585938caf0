// SPDX-License-Identifier: GPL-3.0-or-later
// An array that begins as zeros and takes no time for it: the system lays down its pages when they are first
// touched, by whichever thread does. (std::vector would write them all, one after the other.)
#pragma once
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

namespace sluice {

template <class T>
  requires std::is_arithmetic_v<T>
class Zeros {
 public:
  // Throws std::bad_alloc.
  explicit Zeros(std::size_t size) : values_(static_cast<T*>(std::calloc(size, sizeof(T)))), size_(size) {
    if (size > 0 && !values_) throw std::bad_alloc();
  }
  [[nodiscard]] T& operator[](std::size_t i) noexcept { return values_.get()[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const noexcept { return values_.get()[i]; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::span<T> all() noexcept { return {values_.get(), size_}; }

 private:
  struct Free {
    void operator()(T* p) const noexcept { std::free(p); }
  };
  std::unique_ptr<T[], Free> values_;
  std::size_t size_;
};

}  // namespace sluice
