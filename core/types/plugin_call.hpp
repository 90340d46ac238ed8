// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "core/base/error.hpp"
#include "core/types/abi.h"

namespace graft {

/// Functions of a plugin that the host calls.
enum class Callback : int {
  kNone,
  kIdentity,
  kNormalize,
  kPlus,
  kShape,
  kEvaluate,
  kAssociate,
  kPropagate,
  kRelax,
  kKernel,
  kDestroyResource,
  kSolver,        ///< may take long: one call factors a whole system
  kGuess,         ///< may take long
  kLoadResource,  ///< may take long
  kLoadFile       ///< may take long
};
/// As in the tables of abi.h: "evaluate()", ...
const char* callbackName(Callback callback) noexcept;

/// What a thread does in a plugin.
struct PluginActivity {
  const char* tag = nullptr;  ///< of the type, null = it is in no plugin
  Callback callback = Callback::kNone;
  int thread = -1;           ///< place in a table, to recognise it
  std::uint64_t number = 0;  ///< of calls, and signs of life, of the thread
  /// Whether one call of this kind handles a few hundred items at most.
  bool isShort() const { return callback < Callback::kSolver; }
};

/// Marks, as long as it lives, that this thread runs a function of a plugin. Costs a
/// few stores. Only last words ask (a crash, a call that does not return): results
/// never depend on it.
class PluginCall {
 public:
  /// `tag`: of the type, a string of the plugin's own (it tells which file it is).
  PluginCall(Callback callback, const char* tag) noexcept;
  ~PluginCall();
  PluginCall(const PluginCall&) = delete;
  PluginCall& operator=(const PluginCall&) = delete;

  /// What the calling thread does. Safe in a signal handler.
  static PluginActivity ofThisThread() noexcept;
  /// That, or where it is in no plugin, what the first thread does that is in one.
  static PluginActivity ofAnyThread() noexcept;
  /// What the thread at a place of the table does, 0 <= place < kPlaces: so a watcher asks
  /// for all threads without memory.
  static constexpr int kPlaces = 1088;
  static PluginActivity at(int place) noexcept;
  /// Says that the plugin's function that this thread is in gets on: it has called back.
  static void signOfLife() noexcept;

 private:
  const char* outer_tag_;
  Callback outer_callback_;
};

/// Says, as long as it lives, what the process reads or works on, for last words and for
/// messages about plugins: a file, or "file:line". The text must live as long.
class WorkSubject {
 public:
  explicit WorkSubject(const char* what) noexcept;
  ~WorkSubject();
  WorkSubject(const WorkSubject&) = delete;
  WorkSubject& operator=(const WorkSubject&) = delete;
  /// Of the innermost one alive; "" without. Safe in a signal handler.
  static const char* now() noexcept;

 private:
  const char* outer_;
};

/// File of the library that holds a tag's text; empty where that is the program.
/// Valid as long as the library is, which is for ever.
const char* libraryOf(const char* tag) noexcept;

/// " (plugin /path/libgraft_x.so)" for messages about a type, or empty.
std::string ofPlugin(const char* tag);
/// A text that ends so, once.
std::string withPlugin(const std::string& text, const char* tag);

[[noreturn]] void throwFromPlugin(Callback callback, const char* tag, const char* what);

/// Calls a function of a plugin that has no status. None may throw; one that does all
/// the same becomes Error(kPlugin) with type and function. Running out of memory stays
/// what it is.
template <class Body>
auto callPlugin(Callback callback, const char* tag, Body&& body) -> decltype(body()) {
  const PluginCall call(callback, tag);
  try {
    return std::forward<Body>(body)();
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    throwFromPlugin(callback, tag, e.what());
  } catch (...) {
    throwFromPlugin(callback, tag, "unknown exception");
  }
}

/// The same for a function with a status and a message: an exception becomes
/// GRAFT_FAILED and its text, with the plugin's file.
template <class Body>
int callPlugin(Callback callback, const char* tag, graft_message& message, Body&& body) {
  const PluginCall call(callback, tag);
  const auto say = [&message, tag](const char* text) {
    const std::string whole = text + ofPlugin(tag);
    message.text[whole.copy(message.text, sizeof message.text - 1)] = '\0';
  };
  int status = GRAFT_FAILED;
  try {
    status = std::forward<Body>(body)();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    say(e.what());
  } catch (...) {
    say("unknown exception");
  }
  // A plugin may have filled the text to its end.
  message.text[sizeof message.text - 1] = '\0';
  return status;
}

}  // namespace graft
