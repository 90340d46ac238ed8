// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/new_plugin.hpp"

#include <cctype>
#include <cstdio>
#include <filesystem>

#include "apps/graft/commands.hpp"
#include "apps/graft/engine_options.hpp"
#include "core/base/staged_directory.hpp"

namespace graft {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestName = 40;

struct NewPluginOptions {
  std::string name;
  std::string output;
};

char upper(char c) { return static_cast<char>(std::toupper(static_cast<unsigned char>(c))); }

void requireGoodName(const std::string& name) {
  const auto lower = [](char c) { return c >= 'a' && c <= 'z'; };
  bool good = !name.empty() && name.size() <= kLongestName && lower(name.front());
  for (const char c : name) good = good && (lower(c) || (c >= '0' && c <= '9') || c == '_');
  if (!good) {
    throw Error(ExitCode::kUsage, graft::quoted(name) +
                                      " is no name of a plugin: lower case letters, digits and "
                                      "'_', first a letter, at most " +
                                      std::to_string(kLongestName));
  }
  Engine engine;
  for (const PluginManager::Known& known : engine.plugins().known()) {
    if (known.file.name == name) {
      throw Error(ExitCode::kUsage,
                  "there is a plugin named " + name + " already: " + known.file.path);
    }
  }
}

/// my_edges -> MyEdges
std::string camelCase(const std::string& name) {
  std::string camel;
  bool begin = true;
  for (const char c : name) {
    if (c != '_') camel += begin ? upper(c) : c;
    begin = c == '_';
  }
  return camel;
}

std::string fill(std::string text, const std::string& name) {
  std::string in_upper;
  for (const char c : name) in_upper += upper(c);
  const std::pair<std::string, std::string> words[] = {
      {"@NAME@", name}, {"@UPPER@", in_upper}, {"@CAMEL@", camelCase(name)}};
  for (const auto& [word, value] : words) {
    for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += value.size()) {
      text.replace(at, word.size(), value);
    }
  }
  return text;
}

ExitCode run(const NewPluginOptions& options) {
  requireGoodName(options.name);
  const std::string folder = options.output.empty() ? options.name : options.output;
  std::error_code ignored;
  if (fs::symlink_status(folder, ignored).type() != fs::file_type::not_found) {
    throw Error(ExitCode::kOutput, {folder, 0, 0}, "exists already; nothing was written");
  }
  StagedDirectory staged(folder);
  std::string files;
  for (const PluginTemplate& one : pluginTemplates()) {
    staged.write(one.file, fill(one.text, options.name));
    files += std::string(" ") + one.file;
  }
  staged.commit();
  const char* at = folder.c_str();
  std::printf("wrote %s:%s\n\n", at, files.c_str());
  std::printf("cmake -S %s -B %s/build && cmake --build %s/build\n", at, at, at);
  std::printf("ctest --test-dir %s/build\n", at);
  std::printf("graft optimize %s/example.g2o --plugin %s/build/libgraft_%s.so -o optimized.g2o\n",
              at, at, options.name.c_str());
  return ExitCode::kSuccess;
}

}  // namespace

void addNewPlugin(Program& program) {
  auto options = std::make_shared<NewPluginOptions>();
  CLI::App* command =
      program.add("new-plugin", "Write a complete, tested plugin with a vertex and two edges",
                  [options] { return run(*options); });
  command->add_option("NAME", options->name, "Lower case letters, digits and _, first a letter")
      ->required();
  command->add_option("-o,--output", options->output, "Folder to make (default: NAME)");
}

}  // namespace graft
