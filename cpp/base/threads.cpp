// SPDX-License-Identifier: GPL-3.0-or-later
#include "base/threads.h"

#include <algorithm>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace sluice {
namespace {

// Denormals cost up to 100 cycles each; flush them in our threads only, the caller's mode is restored
// (Blender must not inherit it).
class FlushDenormals {
 public:
#if defined(__SSE2__)
  FlushDenormals() noexcept : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040u); }
  ~FlushDenormals() { _mm_setcsr(saved_); }

 private:
  unsigned saved_;
#endif
};

}  // namespace

int hardware_threads() noexcept {
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

ThreadPool::ThreadPool(int threads) {
  for (int i = 1; i < std::max(1, threads); ++i)
    workers_.emplace_back([this, i](const std::stop_token& stop) { worker_loop(stop, i); });
}

ThreadPool::~ThreadPool() {
  for (auto& worker : workers_) worker.request_stop();
  start_.notify_all();
}

void ThreadPool::parallel_for(std::size_t count, const std::function<void(std::size_t, int)>& body) {
  {
    const std::lock_guard lock(mutex_);
    body_ = &body, count_ = count, next_ = 0, error_ = nullptr, ++round_;
    busy_ = static_cast<int>(workers_.size());
  }
  start_.notify_all();
  work(0);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return busy_ == 0; });
  if (error_) std::rethrow_exception(error_);
}

void ThreadPool::work(int thread) {
  const FlushDenormals mode;
  for (;;) {
    std::size_t index;
    {
      const std::lock_guard lock(mutex_);
      if (next_ >= count_) return;
      index = next_++;
    }
    try {
      (*body_)(index, thread);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = std::current_exception();
      next_ = count_;
    }
  }
}

void ThreadPool::worker_loop(const std::stop_token& stop, int thread) {
  std::uint64_t seen = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      if (!start_.wait(lock, stop, [&] { return round_ != seen; })) return;
      seen = round_;
    }
    work(thread);
    {
      const std::lock_guard lock(mutex_);
      --busy_;
    }
    done_.notify_all();
  }
}

}  // namespace sluice
