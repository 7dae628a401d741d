// walk_grid.json and the arrays beside it: what is written is read, what is broken is said.
#include <gtest/gtest.h>

#include "tools/scratch.h"
#include "truth/npy.h"
#include "truth/walk_grid.h"

namespace hgg::walk_files_test {
namespace {

WalkGrid smallGrid() {
  WalkGrid grid;
  grid.T_grid_map.linear() = Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  grid.T_grid_map.translation() = Vec3(1, -2, 0.5);
  grid.origin_x = -1.5, grid.origin_y = 2.5, grid.width = 3, grid.height = 2, grid.reach = 15.0;
  grid.known = {1, 1, 0, 1, 1, 1};
  grid.first = {0, 1, 3, 3, 3, 4, 4};
  grid.surfaces = {{0.25F, Standing::kFree, false, 7},
                   {0.0F, Standing::kBlocked, false, 100'000, 11},
                   {0.74F, Standing::kFree, true, 1},
                   {-0.5F, Standing::kClose, false, 0}};
  return grid;
}

TEST(Npy, IsWhatNumPyWrites) {
  const Scratch scratch;
  ASSERT_EQ(writeNpy(npyOf<std::uint16_t>({1, 2, 3, 4, 5, 515}, {2, 3}), scratch / "a.npy"), "");
  std::string expected("\x93NUMPY\x01\x00\x76\x00", 10);
  expected += "{'descr': '<u2', 'fortran_order': False, 'shape': (2, 3), }";
  expected.resize(127, ' ');
  expected += '\n';
  expected += std::string("\x01\0\x02\0\x03\0\x04\0\x05\0\x03\x02", 12);
  EXPECT_EQ(readText(scratch / "a.npy"), expected);
  const auto array = readNpy(scratch / "a.npy");
  ASSERT_TRUE(array) << array.error;
  EXPECT_EQ(array->shape, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(array->as<std::uint16_t>(), (std::vector<std::uint16_t>{1, 2, 3, 4, 5, 515}));
}

TEST(Npy, BrokenFilesAreErrors) {
  const Scratch scratch;
  ASSERT_EQ(writeNpy(npyOf<float>({1, 2, 3}, {3}), scratch / "a.npy"), "");
  const std::string whole = readText(scratch / "a.npy");
  const auto replaced = [&](const std::string& what, const std::string& by) {
    std::string text = whole;
    return text.replace(text.find(what), what.size(), by);
  };
  for (const std::string& text :
       {std::string(), whole.substr(0, 9), whole.substr(0, 40), whole.substr(0, whole.size() - 1), whole + "x",
        replaced("False", "True "), replaced("<f4", ">f4"), replaced("<f4", "<f8"), replaced("(3,)", "(4,)"),
        replaced("(3,)", "(9999999999999999999999,)")}) {
    writeText(scratch / "b.npy", text);
    EXPECT_FALSE(readNpy(scratch / "b.npy")) << text;
  }
  EXPECT_FALSE(readNpy(scratch / "none.npy"));
}

TEST(WalkGridFiles, WhatIsWrittenIsRead) {
  const Scratch scratch;
  const WalkGrid grid = smallGrid();
  ASSERT_EQ(writeWalkGrid(grid, scratch / ""), "");
  for (const std::string& name : walkGridFiles()) {
    EXPECT_TRUE(std::filesystem::exists(scratch / name)) << name;
  }
  const auto read = readWalkGrid(scratch / "");
  ASSERT_TRUE(read) << read.error;
  EXPECT_TRUE(read->T_grid_map.isApprox(grid.T_grid_map, 1e-9));
  EXPECT_EQ(read->first, grid.first);
  EXPECT_EQ(read->known, grid.known);
  ASSERT_EQ(read->surfaces.size(), grid.surfaces.size());
  for (std::size_t i = 0; i < grid.surfaces.size(); ++i) {
    EXPECT_EQ(read->surfaces[i].height, grid.surfaces[i].height);
    EXPECT_EQ(read->surfaces[i].standing, grid.surfaces[i].standing);
    EXPECT_EQ(read->surfaces[i].island, grid.surfaces[i].island);
    EXPECT_EQ(read->surfaces[i].cause, grid.surfaces[i].cause);
    EXPECT_EQ(read->surfaces[i].returns, std::min(grid.surfaces[i].returns, 65535U));
  }
  EXPECT_EQ(read->cellOf(-1.45, 2.65), 3U);
  EXPECT_EQ(read->cellOf(-1.51, 2.65), std::nullopt);
  EXPECT_EQ(read->cellOf(-1.19, 2.65), std::nullopt);
  EXPECT_TRUE(read->middle(4, 0.5).isApprox(Vec3(-1.35, 2.65, 0.5)));
  EXPECT_EQ(surfaceNear(*read, 1, 0.6, 0.3), 2U);
  EXPECT_EQ(surfaceNear(*read, 1, 0.4, 0.3), std::nullopt);
}

TEST(WalkGridFiles, BrokenOnesAreErrors) {
  const Scratch scratch;
  const auto fails = [&](const std::string& name, const std::string& text) {
    EXPECT_EQ(writeWalkGrid(smallGrid(), scratch / ""), "");
    writeText(scratch / name, text);
    EXPECT_FALSE(readWalkGrid(scratch / "")) << name << ": " << text;
  };
  ASSERT_EQ(writeWalkGrid(smallGrid(), scratch / ""), "");
  const std::string json = readText(scratch / "walk_grid.json");
  fails("walk_grid.json", "");
  fails("walk_grid.json", "{}");
  fails("walk_grid.json", json.substr(0, json.size() / 2));
  for (const auto& [key, value] : {std::pair<std::string, std::string>{"\"width\": 3", "\"width\": 4"},
                                   {"\"width\": 3", "\"width\": -3"},
                                   {"\"resolution\": 0.1", "\"resolution\": 0"},
                                   {"\"version\": 1", "\"version\": 2"}}) {
    std::string text = json;
    fails("walk_grid.json", text.replace(text.find(key), key.size(), value));
  }
  const auto bytes = [&](const NpyArray& array) {
    EXPECT_EQ(writeNpy(array, scratch / "x.npy"), "");
    return readText(scratch / "x.npy");
  };
  fails("walk_grid.cell.npy", bytes(npyOf<std::uint32_t>({0, 1, 1, 6}, {4})));
  fails("walk_grid.cell.npy", bytes(npyOf<std::uint32_t>({1, 0, 1, 4}, {4})));
  fails("walk_grid.standing.npy", bytes(npyOf<std::uint8_t>({0, 1, 3, 0}, {4})));
  fails("walk_grid.height.npy", bytes(npyOf<float>({0, 1, 3}, {3})));
  fails("walk_grid.height.npy", bytes(npyOf<std::uint32_t>({0, 1, 3, 4}, {4})));
  std::filesystem::remove(scratch / "walk_grid.returns.npy");
  EXPECT_FALSE(readWalkGrid(scratch / ""));
}

}  // namespace
}  // namespace hgg::walk_files_test
