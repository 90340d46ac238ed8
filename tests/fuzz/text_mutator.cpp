// SPDX-License-Identifier: BSD-3-Clause
// Readers refuse nearly all texts with changed bytes. Three of four mutations therefore
// keep the form: a line is doubled, dropped or moved, or a token takes the place of another.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t limit);

namespace {

using Random = std::minstd_rand;

std::size_t below(std::size_t n, Random& random) { return random() % n; }

/// What lies between the characters of `separators`, which stay at the ends of pieces.
std::vector<std::string> split(const std::string& text, const char* separators) {
  std::vector<std::string> pieces;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size() - 1) + 1;
    pieces.push_back(text.substr(begin, end - begin));
    begin = end;
  }
  return pieces;
}

void changeOrder(std::vector<std::string>& lines, Random& random) {
  const std::size_t from = below(lines.size(), random);
  const std::string line = lines[from];
  const std::size_t kind = below(3, random);
  if (kind != 0) lines.erase(lines.begin() + std::ptrdiff_t(from));
  if (kind != 1)
    lines.insert(lines.begin() + std::ptrdiff_t(below(lines.size() + 1, random)), line);
}

void changeToken(std::vector<std::string>& tokens, Random& random) {
  static const char* const kOthers[] = {"0",     "-0",   "1",  "-1",     "0.5", "2",
                                        "1e308", "1e-9", "-7", "1e-320", "",    "3"};
  std::string& token = tokens[below(tokens.size(), random)];
  const char end = token.back();
  const std::string other = below(2, random) == 0
                                ? tokens[below(tokens.size(), random)]
                                : kOthers[below(std::size(kOthers), random)] + std::string(1, end);
  token = other;
  if (!token.empty()) token.back() = end;
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t limit, unsigned int seed) {
  Random random(seed + 1);
  const std::size_t kind = below(4, random);
  if (kind == 0 || size < 2) return LLVMFuzzerMutate(data, size, limit);
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::vector<std::string> pieces = split(text, kind == 1 ? "\n" : " \t\n,\"<>=");
  kind == 1 ? changeOrder(pieces, random) : changeToken(pieces, random);
  std::string changed;
  for (const std::string& piece : pieces) changed += piece;
  if (changed.size() > limit) return LLVMFuzzerMutate(data, size, limit);
  std::memcpy(data, changed.data(), changed.size());
  return changed.size();
}
