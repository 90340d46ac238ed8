// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>

#include "core/base/error.hpp"
#include "core/base/file.hpp"
#include "core/base/staged_directory.hpp"
#include "core/base/text.hpp"
#include "tests/support/test_data.hpp"

namespace graft {
namespace {

using testing::makeTemporaryDirectory;
using testing::readTestFile;
using testing::writeTestFile;

struct BadNumber {
  const char* token;
  NumberStatus status;
};

TEST(ParseDouble, RefusesWhatIsNoFiniteNumber) {
  const BadNumber cases[] = {
      {"", NumberStatus::kEmpty},           {"nan", NumberStatus::kNotFinite},
      {"-inf", NumberStatus::kNotFinite},   {"Infinity", NumberStatus::kNotFinite},
      {"1e999", NumberStatus::kOutOfRange}, {"-1e999", NumberStatus::kOutOfRange},
      {"1,5", NumberStatus::kDecimalComma}, {"1.5abc", NumberStatus::kNotANumber},
      {"1.5.2", NumberStatus::kNotANumber}, {"0x1p3", NumberStatus::kNotANumber},
      {"+-1", NumberStatus::kNotANumber},   {"++1", NumberStatus::kNotANumber},
      {"+", NumberStatus::kNotANumber},     {"1e", NumberStatus::kNotANumber},
      {"1_000", NumberStatus::kNotANumber}, {"1d5", NumberStatus::kNotANumber}};
  for (const BadNumber& c : cases) {
    double value = 42;
    EXPECT_EQ(parseDouble(c.token, value), c.status) << c.token;
    EXPECT_EQ(value, 42) << c.token;
  }
}

TEST(ParseDouble, AcceptsWhatIs) {
  const std::pair<const char*, double> cases[] = {
      {"1.5", 1.5}, {"+1.5", 1.5},   {"-0", -0.0},   {"5.", 5.0},
      {".5", 0.5},  {"1e-999", 0.0}, {"-1E-999", 0}, {"4e-320", 4e-320}};
  for (const auto& [token, expected] : cases) {
    double value = 42;
    EXPECT_EQ(parseDouble(token, value), NumberStatus::kOk) << token;
    EXPECT_EQ(value, expected) << token;
  }
}

TEST(ParseInteger, RefusesFractionsAndOverflow) {
  std::int64_t value = 42;
  EXPECT_EQ(parseInteger("2.7", value), NumberStatus::kNotANumber);
  EXPECT_EQ(parseInteger("1e3", value), NumberStatus::kNotANumber);
  EXPECT_EQ(parseInteger("9223372036854775808", value), NumberStatus::kOutOfRange);
  EXPECT_EQ(value, 42);
  EXPECT_EQ(parseInteger("9223372036854775807", value), NumberStatus::kOk);
  EXPECT_EQ(value, std::int64_t{9223372036854775807});
}

TEST(FormatDouble, RoundTripsEveryBit) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 100000; ++i) {
    const std::uint64_t bits = random();
    double value;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    double back = 0;
    ASSERT_EQ(parseDouble(formatDouble(value), back), NumberStatus::kOk);
    ASSERT_EQ(std::memcmp(&back, &value, sizeof value), 0) << value;
  }
}

TEST(LineTokens, KnowColumnsAndComments) {
  LineTokens tokens("  ab\tcd # ef");
  EXPECT_EQ(tokens.next(), "ab");
  EXPECT_EQ(tokens.column(), 3);
  EXPECT_EQ(tokens.next(), "cd");
  EXPECT_EQ(tokens.column(), 6);
  EXPECT_TRUE(tokens.atEnd());
  EXPECT_EQ(tokens.next(), "");
}

TEST(LineReader, HandlesBomCrlfAndMissingNewline) {
  LineReader reader(
      "\xef\xbb\xbf"
      "a\r\n\nb");
  std::string_view line;
  ASSERT_TRUE(reader.next(line));
  EXPECT_EQ(line, "a");
  ASSERT_TRUE(reader.next(line));
  EXPECT_EQ(line, "");
  ASSERT_TRUE(reader.next(line));
  EXPECT_EQ(line, "b");
  EXPECT_EQ(reader.lineNumber(), 3);
  EXPECT_FALSE(reader.next(line));
}

TEST(Diagnostics, ShowsTwentyAndCountsTheRest) {
  Diagnostics diagnostics;
  for (int i = 1; i <= 25; ++i) diagnostics.error({"f", i, 2}, "bad\x1b");
  const std::string text = diagnostics.text();
  EXPECT_NE(text.find("f:1:2: error: bad\\x1b"), std::string::npos);
  EXPECT_EQ(text.find("f:21:"), std::string::npos);
  EXPECT_NE(text.find("... and 5 more errors"), std::string::npos);
  EXPECT_THROW(diagnostics.throwIfErrors(), Error);
}

TEST(Messages, ShowNoByteThatATerminalMayTakeForACommand) {
  EXPECT_EQ(quoted("a\x1b[2J"), "'a\\x1b[2J'");
  EXPECT_EQ(quoted("\x7f\r"), "'\\x7f\\x0d'");
  EXPECT_EQ(quoted("\x9b"
                   "31m"),
            "'\\x9b31m'");  // CSI as one byte
  EXPECT_EQ(quoted("\xc2\x9b"
                   "31m"),
            "'\\xc2\\x9b31m'");  // and as a character
  EXPECT_EQ(quoted("gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x98\x80"),
            "'gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x98\x80'");
  EXPECT_EQ(quoted("\xc3"), "'\\xc3'");
  EXPECT_EQ(quoted("\xc0\xaf"), "'\\xc0\\xaf'");  // overlong
}

/// A locale with a decimal comma, made where the system has none; skips without a source.
class DecimalComma : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string folder = testing::makeTemporaryDirectory();
    const std::string make = "localedef -i de_DE -f UTF-8 " + folder + "/de_DE.UTF-8 2>&1";
    testing::runCommand(make);
    ::setenv("LOCPATH", folder.c_str(), 1);
    if (std::setlocale(LC_ALL, "de_DE.UTF-8") == nullptr) {
      GTEST_SKIP() << "no source of a German locale";
    }
  }
  void TearDown() override {
    std::setlocale(LC_ALL, "C");
    ::unsetenv("LOCPATH");
  }
};

TEST_F(DecimalComma, DoesNotChangeNumbers) {
  char text[16];
  std::snprintf(text, sizeof text, "%.1f", 1.5);
  ASSERT_STREQ(text, "1,5") << "the locale has no effect";
  double value = 0;
  EXPECT_EQ(parseDouble("-1234.5e-3", value), NumberStatus::kOk);
  EXPECT_EQ(value, -1.2345);
  EXPECT_EQ(parseDouble("1,5", value), NumberStatus::kDecimalComma);
  EXPECT_EQ(formatDouble(-1234.5), "-1234.5");
  std::mt19937_64 random(8);
  for (int i = 0; i < 10000; ++i) {
    const std::uint64_t bits = random();
    double number = 0;
    std::memcpy(&number, &bits, sizeof number);
    if (!std::isfinite(number)) continue;
    EXPECT_EQ(parseDouble(formatDouble(number), value), NumberStatus::kOk);
    EXPECT_EQ(std::memcmp(&value, &number, sizeof value), 0) << formatDouble(number);
  }
}

TEST(ReadFile, RefusesFoldersAndMissingFiles) {
  const std::string directory = makeTemporaryDirectory();
  for (const std::string& path : {directory, directory + "/none"}) {
    try {
      readFile(path);
      FAIL() << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kInput);
      EXPECT_EQ(error.where().path, path);
    }
  }
}

TEST(WriteFileAtomically, ReplacesAndKeepsOldOnFailure) {
  const std::string directory = makeTemporaryDirectory();
  const std::string path = writeTestFile(directory, "out", "old");
  writeFileAtomically(path, "new");
  EXPECT_EQ(readTestFile(path), "new");
  EXPECT_THROW(writeFileAtomically(directory + "/no/out", "x"), Error);
  EXPECT_THROW(writeFileAtomically("/dev/full", "x"), Error);
  int entries = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(directory)) {
    ++entries;
  }
  EXPECT_EQ(entries, 1) << "temporary files were left behind";
}

TEST(WriteFileAtomically, ReplacesALinkInsteadOfFollowingIt) {
  const std::string directory = makeTemporaryDirectory();
  const std::string victim = writeTestFile(directory, "victim", "precious");
  const std::string link = directory + "/link";
  std::filesystem::create_symlink(victim, link);
  writeFileAtomically(link, "new");
  EXPECT_EQ(readTestFile(victim), "precious");
  EXPECT_EQ(readTestFile(link), "new");
}

TEST(StagedDirectory, ShowsNothingBeforeCommit) {
  const std::string target = makeTemporaryDirectory() + "/out";
  {
    StagedDirectory staged(target);
    staged.write("a/b.txt", "1");
  }
  EXPECT_FALSE(std::filesystem::exists(target));
  {
    StagedDirectory staged(target);
    staged.write("a/b.txt", "1");
    staged.write("c.txt", "2");
    staged.commit();
  }
  writeTestFile(target, "mine.txt", "keep");
  {
    StagedDirectory staged(target);
    staged.replaces({"c.txt"});
    staged.write("a/d.txt", "3");
    staged.commit();
  }
  EXPECT_FALSE(std::filesystem::exists(target + "/a/b.txt"));
  EXPECT_FALSE(std::filesystem::exists(target + "/c.txt"));
  EXPECT_EQ(readTestFile(target + "/a/d.txt"), "3");
  EXPECT_EQ(readTestFile(target + "/mine.txt"), "keep");
}

}  // namespace
}  // namespace graft
