// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace graft {

struct ThreadPool::Shared {
  std::mutex mutex;
  std::condition_variable wake;
  std::condition_variable done;
  std::vector<std::thread> workers;
  bool stop = false;
  std::uint64_t job = 0;  ///< counts run() calls, so that a worker joins each once
  int working = 0;
  std::int64_t pieces = 0;
  const std::function<void(std::int64_t)>* body = nullptr;
  std::atomic<std::int64_t> next{0};
  std::exception_ptr error;
  std::int64_t error_piece = 0;

  void work() {
    for (;;) {
      const std::int64_t piece = next.fetch_add(1, std::memory_order_relaxed);
      if (piece >= pieces) return;
      try {
        (*body)(piece);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        if (!error || piece < error_piece) {
          error = std::current_exception();
          error_piece = piece;
        }
      }
    }
  }

  void serve() {
    std::uint64_t seen = 0;
    std::unique_lock<std::mutex> lock(mutex);
    for (;;) {
      wake.wait(lock, [&] { return stop || job != seen; });
      if (stop) return;
      seen = job;
      lock.unlock();
      work();
      lock.lock();
      if (--working == 0) done.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int threads) : threads_(threads) {
  if (threads_ <= 0) threads_ = std::max(1, int(std::thread::hardware_concurrency()));
  if (threads_ == 1) return;
  shared_ = std::make_unique<Shared>();
  try {
    shared_->workers.reserve(std::size_t(threads_ - 1));
    for (int i = 1; i < threads_; ++i) shared_->workers.emplace_back([this] { shared_->serve(); });
  } catch (const std::system_error&) {
    // The system gives no more threads: those there are do the work, to the same result.
    threads_ = 1 + int(shared_->workers.size());
  }
}

ThreadPool::~ThreadPool() {
  if (!shared_) return;
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    shared_->stop = true;
  }
  shared_->wake.notify_all();
  for (std::thread& worker : shared_->workers) worker.join();
}

void ThreadPool::run(std::int64_t pieces, const std::function<void(std::int64_t)>& body) {
  if (!shared_ || pieces <= 1) {
    for (std::int64_t i = 0; i < pieces; ++i) body(i);
    return;
  }
  Shared& s = *shared_;
  {
    const std::lock_guard<std::mutex> lock(s.mutex);
    s.pieces = pieces;
    s.body = &body;
    s.next.store(0, std::memory_order_relaxed);
    s.error = nullptr;
    s.working = threads_ - 1;
    ++s.job;
  }
  s.wake.notify_all();
  s.work();
  std::exception_ptr error;
  {
    std::unique_lock<std::mutex> lock(s.mutex);
    s.done.wait(lock, [&] { return s.working == 0; });
    error = s.error;
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace graft
