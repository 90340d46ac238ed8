// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <png.h>

#include <filesystem>

#include "tests/support/test_data.hpp"
#include "tests/types_lfd/map/random_map.hpp"
#include "types_lfd/map/occupancy_map.hpp"

namespace graft::lfd {
namespace {

using graft::testing::makeTemporaryDirectory;
using graft::testing::writeTestFile;

const std::string kYaml =
    "image: m.pgm\nresolution: 0.05\norigin: [-1, 2, 0.5]\nnegate: 0\n"
    "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
const std::string kPgm = "P2\n3 2\n255\n0 254 205\n254 100 89\n";

OccupancyMap readText(const std::string& yaml, const std::string& image, Diagnostics& diagnostics) {
  const std::string directory = makeTemporaryDirectory();
  writeTestFile(directory, "m.pgm", image);
  return OccupancyMap::read(writeTestFile(directory, "m.yaml", yaml), diagnostics);
}

/// The yaml with one piece of text replaced.
std::string changed(const std::string& from, const std::string& to) {
  std::string yaml = kYaml;
  return yaml.replace(yaml.find(from), from.size(), to);
}

/// The cells from the top row down: '#' occupied, '.' free, 'u' unknown.
std::string picture(const OccupancyMap& map) {
  std::string out;
  for (int row = map.height() - 1; row >= 0; --row) {
    for (int column = 0; column < map.width(); ++column) {
      out += ".#u"[static_cast<int>(map.cell(column, row))];
    }
    out += '/';
  }
  return out;
}

TEST(MapReader, ReadsTextAndBinaryAlike) {
  Diagnostics diagnostics;
  const OccupancyMap text = readText(kYaml, kPgm, diagnostics);
  EXPECT_EQ(picture(text), "#.u/.u#/");  // 89 gives p = 0.651, 100 gives 0.608
  EXPECT_EQ(text.resolution(), 0.05);
  EXPECT_EQ(text.origin().x, -1);
  EXPECT_EQ(text.origin().y, 2);
  EXPECT_EQ(text.origin().theta, 0.5);
  const std::string pixels("\x00\xfe\xcd\xfe\x64\x59", 6);
  const OccupancyMap binary =
      readText(kYaml, "P5 # made by hand\n3 2\n# size\n255\n" + pixels, diagnostics);
  EXPECT_EQ(picture(binary), picture(text));
  EXPECT_EQ(diagnostics.text(), "");
}

TEST(MapReader, KnowsOtherSpellings) {
  Diagnostics diagnostics;
  const OccupancyMap map = readText(
      "# a comment\r\n---\r\nimage: \"m.pgm\"  # beside\r\nresolution: +5e-2\r\norigin:\r\n- -1\r\n"
      "- 2.0\r\n- 0.5\r\nnegate: true\r\noccupied_thresh: 0.65\r\nfree_thresh: 0.196\r\n"
      "mode: trinary\r\n",
      kPgm, diagnostics);
  EXPECT_EQ(diagnostics.text(), "");
  EXPECT_EQ(picture(map), ".##/#uu/");
  EXPECT_EQ(map.origin().x, -1);
}

TEST(MapReader, QuotesKeepANumberSign) {
  for (const char* quote : {"\"", "'"}) {
    const std::string directory = makeTemporaryDirectory();
    writeTestFile(directory, "floor #1.pgm", kPgm);
    Diagnostics diagnostics;
    const OccupancyMap map = OccupancyMap::read(
        writeTestFile(directory, "m.yaml",
                      changed("m.pgm", std::string(quote) + "floor #1.pgm" + quote + " # beside")),
        diagnostics);
    EXPECT_EQ(diagnostics.text(), "");
    EXPECT_EQ(map.width(), 3) << quote;
  }
}

TEST(MapReader, ScalesByMaxval) {
  Diagnostics diagnostics;
  EXPECT_EQ(picture(readText(kYaml, "P2 3 1 15 0 15 8", diagnostics)), "#.u/");
  const std::string wide("\x00\x00\x03\xe8\x01\xf4", 6);
  EXPECT_EQ(picture(readText(kYaml, "P5 3 1 1000\n" + wide, diagnostics)), "#.u/");
  EXPECT_EQ(diagnostics.text(), "");
}

TEST(MapReader, WarnsOfMapsThatSayNothing) {
  Diagnostics diagnostics;
  readText(kYaml, "P2 2 1 255 0 0", diagnostics);
  readText(kYaml, "P2 2 1 255 205 205", diagnostics);
  EXPECT_EQ(diagnostics.warningCount(), 2u);
  EXPECT_NE(diagnostics.text().find("every cell of the map is occupied"), std::string::npos);
  EXPECT_NE(diagnostics.text().find("every cell of the map is unknown"), std::string::npos);
}

TEST(MapReader, WhatIsWrittenReadsBack) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 20; ++i) {
    const OccupancyMap map = testing::randomMap(random, 0.3, 12);
    Diagnostics diagnostics;
    const OccupancyMap back = readText(map.formatYaml("m.pgm"), map.formatPgm(), diagnostics);
    EXPECT_EQ(diagnostics.errorCount(), 0u) << diagnostics.text();
    EXPECT_EQ(picture(back), picture(map));
    EXPECT_EQ(back.resolution(), map.resolution());
    EXPECT_EQ(back.origin().theta, map.origin().theta);
    EXPECT_EQ(back.formatPgm(), map.formatPgm());
  }
}

std::string writePng(const std::vector<unsigned char>& pixels, int width, int height, int format) {
  const std::string path = makeTemporaryDirectory() + "/m.pgm";
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = static_cast<png_uint_32>(format);
  EXPECT_NE(png_image_write_to_file(&image, path.c_str(), 0, pixels.data(), 0, nullptr), 0);
  return graft::testing::readTestFile(path);
}

TEST(MapReader, ReadsPng) {
  Diagnostics diagnostics;
  const std::string grey = writePng({0, 254, 205, 254, 100, 89}, 3, 2, PNG_FORMAT_GRAY);
  EXPECT_EQ(picture(readText(kYaml, grey, diagnostics)), "#.u/.u#/");
  // The mean of the colours counts: (255 + 0 + 0) / 3 = 85.
  const std::string colour =
      writePng({255, 0, 0, 255, 255, 255, 205, 205, 205}, 3, 1, PNG_FORMAT_RGB);
  EXPECT_EQ(picture(readText(kYaml, colour, diagnostics)), "#.u/");
  EXPECT_EQ(diagnostics.text(), "");
  const std::string clear =
      writePng({0, 0, 0, 255, 0, 0, 0, 100, 255, 255, 255, 255}, 3, 1, PNG_FORMAT_RGBA);
  EXPECT_EQ(picture(readText(kYaml, clear, diagnostics)), "#u./");
  EXPECT_NE(diagnostics.text().find("1 pixels are not opaque"), std::string::npos);
  Diagnostics truncated;
  readText(kYaml, grey.substr(0, grey.size() / 2), truncated);
  EXPECT_EQ(truncated.errorCount(), 1u);
  EXPECT_NE(truncated.text().find("m.pgm: error: the PNG cannot be read"), std::string::npos);
}

struct BadMap {
  std::string yaml;
  std::string image;
  const char* message;  ///< after the folder, with line
};

TEST(MapReader, RefusesBadInputByLine) {
  const BadMap cases[] = {
      {changed("image: m.pgm\n", ""), kPgm, "m.yaml:5: error: the key 'image' is missing"},
      {changed("resolution: 0.05\n", ""), kPgm, "m.yaml:5: error: the key 'resolution' is missing"},
      {changed("origin: [-1, 2, 0.5]\n", ""), kPgm, "m.yaml:5: error: the key 'origin' is missing"},
      {changed("negate: 0\n", ""), kPgm, "m.yaml:5: error: the key 'negate' is missing"},
      {changed("free_thresh: 0.196\n", ""), kPgm,
       "m.yaml:5: error: the key 'free_thresh' is missing"},
      {"", kPgm, "m.yaml: error: the key 'image' is missing"},
      {kYaml + "colour: red\n", kPgm, "m.yaml:7: error: unknown key 'colour'"},
      {kYaml + "negate: 1\n", kPgm, "m.yaml:7: error: the key 'negate' is given twice"},
      {kYaml + "mode: scale\n", kPgm, "m.yaml:7: error: mode 'scale' is not supported"},
      {kYaml + "just text\n", kPgm, "m.yaml:7: error: expected 'key: value', got 'just text'"},
      {kYaml + "- 5\n", kPgm, "m.yaml:7: error: a list item without a list"},
      {changed("0.05", "0"), kPgm, "m.yaml:2: error: resolution is 0, expected more than 0"},
      {changed("0.05", "-1"), kPgm, "m.yaml:2: error: resolution is -1, expected more than 0"},
      {changed("0.05", "nan"), kPgm, "m.yaml:2: error: resolution: 'nan' is not a finite number"},
      {changed("0.05", ""), kPgm, "m.yaml:2: error: resolution: the value is missing"},
      {changed("0.05", "0,05"), kPgm, "m.yaml:2: error: resolution: '0,05' is not a number"},
      {changed("[-1, 2, 0.5]", "[-1, 2]"), kPgm,
       "m.yaml:3: error: origin: expected [x, y, yaw], got 2 numbers"},
      {changed("[-1, 2, 0.5]", "5"), kPgm,
       "m.yaml:3: error: origin: expected [x, y, yaw], got '5'"},
      {changed("[-1, 2, 0.5]", "[-1, nan, 0]"), kPgm,
       "m.yaml:3: error: origin: 'nan' is not a finite number"},
      {changed("[-1, 2, 0.5]", "[-1, 2, 0.5"), kPgm,
       "m.yaml:3: error: the list does not end with ']' on its line"},
      {changed("negate: 0", "negate: 2"), kPgm, "m.yaml:4: error: negate is '2', expected 0 or 1"},
      {changed("0.65", "1.5"), kPgm, "m.yaml:5: error: occupied_thresh is 1.5, expected 0 to 1"},
      {changed("0.65", "0.1"), kPgm,
       "m.yaml:6: error: free_thresh 0.196 is above occupied_thresh 0.1"},
      {changed("m.pgm", "../m.pgm"), kPgm, "m.yaml:1: error: image: '../m.pgm' leaves the map's"},
      {changed("m.pgm", "none.pgm"), kPgm, "m.yaml:1: error: the image cannot be read: "},
      {changed("m.pgm", "."), kPgm, "m.yaml:1: error: the image cannot be read: "},
      {kYaml, "", "m.pgm:1: error: the image is empty"},
      {kYaml, "P6\n3 2\n255\n", "m.pgm:1: error: an image that begins with 'P6' is neither"},
      {kYaml, "P2\n", "m.pgm:2: error: truncated: the header lacks the width"},
      {kYaml, "P2\n3 two\n", "m.pgm:2: error: the height of the image is 'two', expected a whole"},
      {kYaml, "P2\n3 -2\n", "m.pgm:2: error: the height of the image is '-2', expected a whole"},
      {kYaml, "P2\n0 0\n255\n", "m.pgm:2: error: the image has no pixels (0 x 0)"},
      {kYaml, "P5\n65536 32768\n255\n", "m.pgm:2: error: the image is too large (65536 x 32768;"},
      {kYaml, "P5\n9000000000 9000000000\n255\n", "m.pgm:2: error: the image is too large"},
      {kYaml, "P2\n3 2\n0\n", "m.pgm:3: error: the maxval is 0, expected 1 to 65535"},
      {kYaml, "P2\n3 2\n70000\n", "m.pgm:3: error: the maxval is 70000, expected 1 to 65535"},
      {kYaml, "P2\n3 2\n255\n1 2 3\n4 5\n",
       "m.pgm:6: error: truncated: the header says 6 pixels, the file has 5"},
      {kYaml, "P2\n30 20\n255\n1 2 3\n", "m.pgm: error: truncated: the header says 600 pixels"},
      {kYaml, "P2\n3 2\n255\n1 2 3\n4 5 256\n",
       "m.pgm:5: error: '256' is no pixel value from 0 to 255"},
      {kYaml, "P2\n3 2\n255\n1 2 3\n4 5 6 7\n", "m.pgm:5: error: unexpected '7' after the last"},
      {kYaml, "P5\n3 2\n255\n12345",
       "m.pgm: error: truncated: the header says 6 bytes of pixels, the file has 5"},
      {kYaml, "P5\n3 2\n1000\n1234567",
       "m.pgm: error: truncated: the header says 12 bytes of pixels, the file has 7"},
      {kYaml, "P5\n3 2\n255\n12345678", "m.pgm: error: 2 bytes follow the pixels"},
      {kYaml, "P5\n3 2\n15\n\x01\x02\x03\x04\x05\x10",
       "m.pgm: error: pixel 5 is 16, above the maxval 15"}};
  for (const BadMap& c : cases) {
    Diagnostics diagnostics;
    const OccupancyMap map = readText(c.yaml, c.image, diagnostics);
    EXPECT_GE(diagnostics.errorCount(), 1u) << c.message;
    EXPECT_NE(diagnostics.text().find(std::string("/") + c.message), std::string::npos)
        << "expected " << c.message << "\ngot " << diagnostics.text();
    EXPECT_EQ(map.width(), 0) << c.message;
  }
}

TEST(MapReader, ReadsTheAuthorsLab) {
  GRAFT_REQUIRE_DATA("maps/aisoffice_door.yaml");
  Diagnostics diagnostics;
  const OccupancyMap map =
      OccupancyMap::read(graft::testing::dataPath("maps/aisoffice_door.yaml"), diagnostics);
  EXPECT_EQ(diagnostics.text(), "");
  EXPECT_GT(map.occupiedCount(), 0u);
  EXPECT_EQ(map.width(), 512);
  EXPECT_EQ(map.height(), 512);
}

}  // namespace
}  // namespace graft::lfd
