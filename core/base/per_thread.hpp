// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pthread.h>

#include <memory>
#include <new>

namespace graft {

/// A T per thread, made at the thread's first use and destroyed at its end. Unlike a
/// thread_local object, for whose destructor the C library ends the program where memory
/// is out, this throws std::bad_alloc. For objects with static storage only.
template <class T>
class PerThread {
 public:
  PerThread() : good_(::pthread_key_create(&key_, &destroy) == 0) {}
  PerThread(const PerThread&) = delete;
  PerThread& operator=(const PerThread&) = delete;

  T& get() {
    if (!good_) throw std::bad_alloc();
    if (void* mine = ::pthread_getspecific(key_)) return *static_cast<T*>(mine);
    auto made = std::make_unique<T>();
    if (::pthread_setspecific(key_, made.get()) != 0) throw std::bad_alloc();
    return *made.release();
  }

 private:
  static void destroy(void* one) { delete static_cast<T*>(one); }
  pthread_key_t key_ = 0;
  bool good_;
};

}  // namespace graft
