// SPDX-License-Identifier: BSD-3-Clause
// Resources and loaders: what reads files.
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

#include "core/base/temporary.hpp"
#include "core/conformance/checks.hpp"
#include "core/conformance/sampler.hpp"

namespace graft::conformance {

namespace {

void requireRefused(const graft_resource_type& type, const std::vector<std::string>& tokens) {
  std::vector<const char*> pointers;
  pointers.reserve(tokens.size());
  for (const std::string& token : tokens) pointers.push_back(token.c_str());
  graft_message message = {};
  const void* loaded = type.load(".", std::int32_t(tokens.size()), pointers.data(), &message);
  std::string text = std::to_string(tokens.size()) + " tokens";
  if (!tokens.empty()) text += " that begin with '" + tokens.front() + "'";
  if (loaded != nullptr) {
    type.destroy(loaded);
    throw Defect("load() accepts " + text);
  }
  if (message.text[0] == '\0') throw Defect("load() refuses " + text + " without a reason");
}

/// Counts what a loader hands over; accepts everything.
struct CountingSink {
  graft_graph_sink table() {
    graft_graph_sink sink = {};
    sink.struct_size = sizeof sink;
    sink.host = this;
    sink.add_vertex = [](void* host, const char*, std::int64_t, const double*, std::int32_t,
                         std::int64_t) { return count(host); };
    sink.add_resource = [](void* host, const char*, std::int64_t, std::int32_t, const char* const*,
                           std::int64_t) { return count(host); };
    sink.add_edge = [](void* host, const char*, std::int32_t, const std::int64_t*, std::int32_t,
                       const std::int64_t*, std::int32_t, const double*, std::int32_t,
                       const double*, std::int64_t) { return count(host); };
    sink.fix_vertex = [](void* host, std::int64_t, std::int64_t) { return count(host); };
    sink.set_kernel = [](void* host, const char*, double, std::int64_t) { return count(host); };
    sink.set_level = [](void* host, std::int32_t, std::int64_t) { return count(host); };
    sink.report = [](void* host, std::int32_t severity, const char*, std::int64_t, std::int64_t,
                     const char*) {
      if (severity >= 2) ++static_cast<CountingSink*>(host)->errors;
    };
    return sink;
  }
  static int count(void* host) {
    ++static_cast<CountingSink*>(host)->things;
    return GRAFT_OK;
  }
  std::size_t things = 0;
  std::size_t errors = 0;
};

/// A file in memory that has a name as long as this lives: no folder needs to be writable.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& content)
      : file_(::memfd_create("graft-conformance", MFD_CLOEXEC)) {
    if (file_.get() < 0 || !writeAll(file_.get(), content)) {
      failOutput("a file in memory", std::strerror(errno));
    }
  }
  std::string path() const { return "/proc/self/fd/" + std::to_string(file_.get()); }

 private:
  Descriptor file_;
};

void requireSaid(const graft_loader_type& type, const std::string& path, const char* what) {
  CountingSink sink;
  const graft_graph_sink table = sink.table();
  const int status = type.load(path.c_str(), &table);
  if (status == GRAFT_OK && sink.errors == 0 && sink.things == 0) {
    throw Defect(std::string("load() takes ") + what + " for a graph without anything in it");
  }
  if (status != GRAFT_OK && sink.errors == 0) {
    throw Defect(std::string("load() refuses ") + what + " without a reason");
  }
}

const std::string kGarbage(
    "\x7f"
    "ELF\0\xff\xfe no graph\n\n<<<>>>\n",
    25);

}  // namespace

void addResourceChecks(const Context& context, const graft_resource_type& type, Checks& checks) {
  checks.push_back({"load", [context, &type] {
                      const ResourceSample first = sampleResource(context, type);
                      const ResourceSample second = sampleResource(context, type);
                      if (first.data == nullptr || second.data == nullptr) {
                        throw Defect("load() gives null");
                      }
                    }});
  checks.push_back({"load.refuses", [&type] {
                      requireRefused(type, {"no_such_file_or_number"});
                      requireRefused(type, {"nan", "", "\xff"});
                      if (!wordsOf(type.fields).empty()) requireRefused(type, {});
                    }});
}

void addLoaderChecks(const Context&, const graft_loader_type& type, Checks& checks) {
  checks.push_back(
      {"recognizes", [&type] {
         for (const std::string& head : {std::string(), kGarbage}) {
           if (type.recognizes("garbage.bin", head.data(), std::int64_t(head.size())) != 0) {
             throw Defect("recognizes() takes garbage for its format");
           }
         }
       }});
  checks.push_back({"load.refuses", [&type] {
                      const TemporaryFile empty("");
                      requireSaid(type, empty.path(), "an empty file");
                      const TemporaryFile garbage(kGarbage);
                      requireSaid(type, garbage.path(), "garbage");
                      requireSaid(type, "/no/such/file", "a missing file");
                    }});
}

}  // namespace graft::conformance
