// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

namespace graft {

/// Threads that share out numbered pieces of work. Which thread takes a piece is
/// left to chance, so that work stays balanced; results are the same for any
/// number of threads as long as a piece writes only what belongs to it.
class ThreadPool {
 public:
  /// `threads` in all, the caller included; 0 = one per processor. Fewer where the
  /// system gives no more.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return threads_; }

  /// Calls body(0) .. body(pieces - 1), each once, and returns when all are
  /// done. If some throw, the exception of the lowest piece is thrown here.
  /// Not reentrant: a body must not call run() of the same pool.
  void run(std::int64_t pieces, const std::function<void(std::int64_t)>& body);

 private:
  struct Shared;
  int threads_;
  std::unique_ptr<Shared> shared_;
};

}  // namespace graft
