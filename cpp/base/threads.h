// SPDX-License-Identifier: GPL-3.0-or-later
// A small pool of std::jthread for parallel loops. TBB is avoided on purpose: it is the commonest clash
// inside Blender.
#pragma once
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace sluice {

class ThreadPool {
 public:
  explicit ThreadPool(int threads);  // the calling thread works too, so threads - 1 are started
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  [[nodiscard]] int size() const noexcept { return static_cast<int>(workers_.size()) + 1; }

  // Calls body(index, thread) once for each index in [0, count), in any order; thread is in [0, size()).
  // Serial form:
  //   for (i = 0; i < count; ++i) body(i, 0);
  // Returns when all are done. The first exception of a body is rethrown here, in the caller's thread.
  void parallel_for(std::size_t count, const std::function<void(std::size_t, int)>& body);

 private:
  void work(int thread);
  void worker_loop(const std::stop_token& stop, int thread);

  std::mutex mutex_;
  std::condition_variable_any start_, done_;
  const std::function<void(std::size_t, int)>* body_ = nullptr;
  std::size_t count_ = 0, next_ = 0;
  std::uint64_t round_ = 0;
  int busy_ = 0;
  std::exception_ptr error_;
  std::vector<std::jthread> workers_;  // last: joined before the state above dies
};

// A function on a thread of its own, which the destructor waits for. What it throws is its own business: it
// must catch.
class BackgroundTask {
 public:
  BackgroundTask() = default;
  explicit BackgroundTask(std::function<void()> task) : thread_(std::move(task)) {}

 private:
  std::jthread thread_;
};

// As many as the machine has, at least 1.
[[nodiscard]] int hardware_threads() noexcept;

}  // namespace sluice
