// SPDX-License-Identifier: BSD-3-Clause
#include "core/types/plugin_call.hpp"

#include <dlfcn.h>

#include <array>
#include <atomic>
#include <cstring>

#include "core/base/per_thread.hpp"

namespace graft {

namespace {

/// One thread's entry; lines of their own, so that threads do not slow each other.
struct alignas(64) Slot {
  std::atomic<bool> taken{false};
  std::atomic<const char*> tag{nullptr};
  std::atomic<Callback> callback{Callback::kNone};
  std::atomic<std::uint64_t> number{0};
};

constexpr int kSlots = PluginCall::kPlaces;  // threads beyond that many are not watched
std::array<Slot, kSlots> slots;

/// Takes a slot at a thread's first call and gives it back at the thread's end.
struct Place {
  Place() {
    for (int i = 0; i < kSlots; ++i) {
      bool free = false;
      if (slots[std::size_t(i)].taken.compare_exchange_strong(free, true)) {
        index = i;
        return;
      }
    }
  }
  ~Place() {
    if (index < 0) return;
    Slot& slot = slots[std::size_t(index)];
    slot.taken.store(false, std::memory_order_release);
    index = -1;
  }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  int index = -1;
};

std::atomic<const char*> subject{""};

// A plain number beside the object: a signal handler must not construct anything.
thread_local int this_place = -1;

Slot* takeSlot() {
  static PerThread<Place> places;
  try {
    this_place = places.get().index;
  } catch (const std::bad_alloc&) {
    // Calls go on unrecorded.
  }
  return this_place >= 0 ? &slots[std::size_t(this_place)] : nullptr;
}

PluginActivity read(int index) {
  const Slot& slot = slots[std::size_t(index)];
  PluginActivity activity;
  activity.tag = slot.tag.load(std::memory_order_acquire);
  activity.callback = slot.callback.load(std::memory_order_relaxed);
  activity.number = slot.number.load(std::memory_order_relaxed);
  activity.thread = index;
  return activity;
}

}  // namespace

const char* callbackName(Callback callback) noexcept {
  switch (callback) {
    case Callback::kNone:
      break;
    case Callback::kIdentity:
      return "identity()";
    case Callback::kNormalize:
      return "normalize()";
    case Callback::kPlus:
      return "plus()";
    case Callback::kShape:
      return "shape()";
    case Callback::kEvaluate:
      return "evaluate()";
    case Callback::kAssociate:
      return "associate()";
    case Callback::kPropagate:
      return "propagate()";
    case Callback::kRelax:
      return "its relaxation";
    case Callback::kKernel:
      return "evaluate()";
    case Callback::kDestroyResource:
      return "destroy()";
    case Callback::kSolver:
      return "the linear solver";
    case Callback::kGuess:
      return "guess()";
    case Callback::kLoadResource:
      return "load()";
    case Callback::kLoadFile:
      return "the loader";
  }
  return "nothing";
}

PluginCall::PluginCall(Callback callback, const char* tag) noexcept
    : outer_tag_(nullptr), outer_callback_(Callback::kNone) {
  Slot* slot = this_place >= 0 ? &slots[std::size_t(this_place)] : takeSlot();
  if (slot == nullptr) return;
  outer_tag_ = slot->tag.load(std::memory_order_relaxed);
  outer_callback_ = slot->callback.load(std::memory_order_relaxed);
  slot->number.store(slot->number.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  slot->callback.store(callback, std::memory_order_relaxed);
  slot->tag.store(tag, std::memory_order_release);
}

PluginCall::~PluginCall() {
  if (this_place < 0) return;
  Slot& slot = slots[std::size_t(this_place)];
  slot.tag.store(outer_tag_, std::memory_order_release);
  slot.callback.store(outer_callback_, std::memory_order_relaxed);
}

PluginActivity PluginCall::ofThisThread() noexcept {
  return this_place >= 0 ? read(this_place) : PluginActivity();
}

PluginActivity PluginCall::ofAnyThread() noexcept {
  PluginActivity activity = ofThisThread();
  for (int i = 0; i < kSlots && activity.tag == nullptr; ++i) activity = read(i);
  return activity;
}

PluginActivity PluginCall::at(int place) noexcept {
  if (!slots[std::size_t(place)].taken.load(std::memory_order_acquire)) return PluginActivity();
  return read(place);
}

void PluginCall::signOfLife() noexcept {
  if (this_place < 0) return;
  std::atomic<std::uint64_t>& number = slots[std::size_t(this_place)].number;
  number.store(number.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

WorkSubject::WorkSubject(const char* what) noexcept : outer_(subject.exchange(what)) {}
WorkSubject::~WorkSubject() { subject.store(outer_); }
const char* WorkSubject::now() noexcept { return subject.load(); }

const char* libraryOf(const char* tag) noexcept {
  // A place in this library, or in the program that it is linked into.
  static const char here = '\0';
  Dl_info theirs = {};
  Dl_info ours = {};
  if (tag == nullptr || ::dladdr(tag, &theirs) == 0 || theirs.dli_fname == nullptr) return "";
  if (::dladdr(&here, &ours) != 0 && ours.dli_fbase == theirs.dli_fbase) return "";
  return theirs.dli_fname;
}

std::string withPlugin(const std::string& text, const char* tag) {
  const std::string plugin = ofPlugin(tag);
  const bool has = text.size() >= plugin.size() &&
                   text.compare(text.size() - plugin.size(), plugin.size(), plugin) == 0;
  return has ? text : text + plugin;
}

std::string ofPlugin(const char* tag) {
  const std::string library = libraryOf(tag);
  return library.empty() ? std::string() : " (plugin " + library + ")";
}

void throwFromPlugin(Callback callback, const char* tag, const char* what) {
  const std::string input = WorkSubject::now();
  throw Error(ExitCode::kPlugin, {libraryOf(tag), 0, 0},
              std::string(tag) + ": " + callbackName(callback) + " threw an exception: " + what +
                  (input.empty() ? "" : " (input: " + input + ")"));
}

}  // namespace graft
