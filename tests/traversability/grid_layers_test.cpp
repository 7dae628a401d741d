#include "traversability/grid_layers.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "surfaces_world.h"

namespace hgg::grid_layers_test {
namespace {

const std::string& bytesOf(const std::vector<GridFile>& files, const std::string& suffix) {
  for (const GridFile& f : files) {
    if (f.suffix == suffix) {
      return f.bytes;
    }
  }
  ADD_FAILURE() << "no " << suffix;
  return files.front().bytes;
}

/// A bridge at 2 m over a floor.
GridLayers bridge(double reference_z) {
  SurfacesWorld world;
  world.setEye({0, 0, 4});
  world.addFloor(-2, -2, 2, 2);
  world.addFloor(-2, -0.8, 2, 0.8, 2);
  return layersOf(world.grid(), reference_z);
}

TEST(GridLayers, LevelZeroIsTheSurfaceNearestToTheReference) {
  const GridLayers low = bridge(0.1), high = bridge(1.9);
  ASSERT_EQ(low.levels, 2);
  const auto cell = static_cast<std::size_t>(low.shape.cell(low.shape.columnOf(0), low.shape.rowOf(0)));
  const auto plane = static_cast<std::size_t>(low.shape.cells());
  EXPECT_EQ(low.layers[0].name, "height");
  EXPECT_NEAR(low.layers[0].values[cell], 0, 0.03);
  EXPECT_NEAR(low.layers[0].values[plane + cell], 2, 0.03);
  EXPECT_NEAR(high.layers[0].values[cell], 2, 0.03);
  const auto single = static_cast<std::size_t>(low.shape.cell(low.shape.columnOf(0), low.shape.rowOf(1.5)));
  EXPECT_TRUE(std::isnan(low.layers[0].values[plane + single]));
  EXPECT_EQ(low.cost[plane + single], kCostUnknown);
}

TEST(GridLayers, FilesAreThoseOfMapServerAndNumPy) {
  const GridLayers grid = bridge(0);
  const std::vector<GridFile> files = gridFiles(grid, "drive");
  EXPECT_NE(bytesOf(files, ".yaml").find("image: \"drive.pgm\"\nresolution: 0.1\n"), std::string::npos);
  const std::string& pgm = bytesOf(files, ".pgm");
  ASSERT_TRUE(pgm.starts_with("P5\n80 80\n255\n"));
  const std::size_t head = pgm.size() - 80 * 80;
  const auto grey = [&](double x, double y) {  // row 0 is the largest y
    const auto row = static_cast<std::size_t>(79 - grid.shape.rowOf(y)),
               column = static_cast<std::size_t>(grid.shape.columnOf(x));
    return static_cast<unsigned char>(pgm[head + row * 80 + column]);
  };
  EXPECT_EQ(grey(0, 1.5), 254);
  EXPECT_EQ(grey(0, 3.5), 205);
  const auto json = nlohmann::json::parse(bytesOf(files, ".layers.json"));
  EXPECT_EQ(json["format"], "hgg-grid");
  EXPECT_EQ(json["levels"], 2);
  for (const auto& [name, layer] : json["layers"].items()) {
    const std::string& npy = bytesOf(files, "." + name + ".npy");
    EXPECT_EQ(layer["file"], "drive." + name + ".npy");
    ASSERT_TRUE(npy.starts_with(std::string("\x93NUMPY\x01\x00", 8))) << name;
    EXPECT_NE(npy.find("(2, 80, 80)"), std::string::npos);
    const std::size_t data = 10 + static_cast<unsigned char>(npy[8]) + 256U * static_cast<unsigned char>(npy[9]);
    EXPECT_EQ(data % 64, 0U);
    EXPECT_EQ(npy.size() - data, 2U * 80 * 80 * (layer["dtype"] == "uint8" ? 1 : 4)) << name;
  }
}

}  // namespace
}  // namespace hgg::grid_layers_test
