// SPDX-License-Identifier: BSD-3-Clause
// staged_writer DIR TEXT: writes a/first, a/b/second and third into DIR, each with TEXT in
// it, as the programs write their folders, and takes the place of an entry "obsolete".
#include <cstdio>
#include <exception>

#include "core/base/error.hpp"
#include "core/base/staged_directory.hpp"

int main(int argc, char** argv) {
  if (argc != 3) return int(graft::ExitCode::kUsage);
  try {
    graft::StagedDirectory out(argv[1]);
    out.replaces({"obsolete", "third"});
    for (const char* name : {"a/first", "a/b/second", "third"}) out.write(name, argv[2]);
    out.commit();
  } catch (const graft::Error& e) {
    std::fprintf(stderr, "%s\n", e.formatted().c_str());
    return int(e.code());
  }
  return 0;
}
