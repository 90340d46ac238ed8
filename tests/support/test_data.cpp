// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/test_data.hpp"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

namespace graft::testing {

namespace fs = std::filesystem;

namespace {

struct TemporaryDirectories {
  std::vector<std::string> paths;
  ~TemporaryDirectories() {
    std::error_code ignored;
    for (const std::string& path : paths) fs::remove_all(path, ignored);
  }
};

}  // namespace

std::string dataPath(const std::string& relative) {
  const char* root = std::getenv("GRAFT_DATA");
  return std::string(root != nullptr ? root : GRAFT_DATA_DEFAULT) + "/" + relative;
}

bool dataExists(const std::string& relative) { return fs::exists(dataPath(relative)); }

std::string binaryDirectory() { return GRAFT_BINARY_DIR; }

std::string makeTemporaryDirectory() {
  static TemporaryDirectories made;
  std::string path = (fs::temp_directory_path() / "graft-test-XXXXXX").string();
  if (::mkdtemp(path.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
  made.paths.push_back(path);
  return path;
}

std::string writeTestFile(const std::string& directory, const std::string& name,
                          const std::string& content) {
  const fs::path path = fs::path(directory) / name;
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << content;
  return path.string();
}

std::string readTestFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  return content.str();
}

CommandResult runCommand(const std::string& command) {
  const std::string directory = makeTemporaryDirectory();
  const std::string out = directory + "/out";
  const std::string err = directory + "/err";
  const int status = std::system(("{ " + command + "\n} >" + out + " 2>" + err).c_str());
  CommandResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.out = readTestFile(out);
  result.err = readTestFile(err);
  return result;
}

}  // namespace graft::testing
