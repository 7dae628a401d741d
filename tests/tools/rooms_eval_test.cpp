#include <gtest/gtest.h>

#include "eval/rooms.h"
#include "tools/scratch.h"

namespace hgg::rooms_eval_test {
namespace {

using Groups = std::vector<std::size_t>;

TEST(NormalisedMutualInformation, HasTheValuesOfTheFormula) {
  EXPECT_NEAR(normalisedMutualInformation(Groups{0, 0, 1, 1}, Groups{7, 7, 3, 3}), 1, 1e-12);
  EXPECT_NEAR(normalisedMutualInformation(Groups{0, 0, 1, 1}, Groups{5, 6, 5, 6}), 0, 1e-12);
  EXPECT_NEAR(normalisedMutualInformation(Groups{0, 0, 1, 1}, Groups{5, 5, 5, 5}), 0, 1e-12);
  // H = ln 2, H' = 1.5 ln 2, I = ln 2: one of two rooms is cut in half.
  EXPECT_NEAR(normalisedMutualInformation(Groups{0, 0, 1, 1}, Groups{5, 5, 6, 7}), 2 / 2.5, 1e-12);
  EXPECT_NEAR(normalisedMutualInformation(Groups{4, 4}, Groups{1, 1}), 1, 1e-12) << "one group each";
}

/// Two rooms side by side and a hall, seen from a body that is turned.
TruthRooms house() {
  TruthRooms rooms;
  rooms.T_world_map.translation() = Vec3(10, 0, 0);
  rooms.T_world_map.linear() = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()).toRotationMatrix();
  rooms.rooms = {{"kitchen", {{Vec3(0, 0, 0), Vec3(4, 4, 2.5)}}},
                 {"bath", {{Vec3(4, 0, 0), Vec3(8, 4, 2.5)}}},
                 {"hall", {{Vec3(0, 4, 0), Vec3(8, 6, 2.5)}, {Vec3(8, 0, 0), Vec3(10, 6, 2.5)}}}};
  return rooms;
}

std::optional<std::size_t> roomAtWorld(double x, double y, double z = 1) {
  const TruthRooms rooms = house();
  return roomAt(rooms, rooms.T_world_map.inverse() * Vec3(x, y, z));
}

TEST(TruthRooms, APlaceIsInTheOneRoomAroundIt) {
  EXPECT_EQ(roomAtWorld(1, 1), 0U);
  EXPECT_EQ(roomAtWorld(5, 1), 1U);
  EXPECT_EQ(roomAtWorld(9, 1), 2U);
  EXPECT_EQ(roomAtWorld(8.05, 5), 2U) << "where parts of one room meet";
  EXPECT_EQ(roomAtWorld(-0.05, 1), 0U) << "a window in the outer wall";
  EXPECT_EQ(roomAtWorld(4.05, 1), std::nullopt) << "a closed door between two rooms";
  EXPECT_EQ(roomAtWorld(-1, 1), std::nullopt);
  EXPECT_EQ(roomAtWorld(1, 1, 4), std::nullopt) << "another storey";
}

TEST(TruthRooms, AreReadAsTheyWereWritten) {
  const Scratch scratch;
  ASSERT_EQ(writeRooms(house(), scratch / "rooms.json"), "");
  const auto read = readRooms(scratch / "rooms.json");
  ASSERT_TRUE(read) << read.error;
  EXPECT_TRUE(read->T_world_map.isApprox(house().T_world_map, 1e-12));
  ASSERT_EQ(read->rooms.size(), 3U);
  EXPECT_EQ(read->rooms[2].name, "hall");
  ASSERT_EQ(read->rooms[2].parts.size(), 2U);
  EXPECT_TRUE(read->rooms[2].parts[1].isApprox(house().rooms[2].parts[1]));
  EXPECT_FALSE(readRooms(scratch / "none.json"));
}

TEST(ScoreRooms, TellsWhichRoomsAreCutAndWhichAreJoined) {
  TruthRooms rooms = house();
  rooms.T_world_map = Pose::Identity();
  std::vector<TruthObject> truth;
  std::vector<ObjectMatch> matches;
  std::map<NodeId, std::int64_t> region_of;
  const auto add = [&](double x, double y, std::int64_t region) {
    const auto id = static_cast<std::int64_t>(truth.size()) + 1;
    truth.push_back({.id = id, .belief = {Vec3(x, y, 1), Mat3::Identity(), 10}});
    matches.push_back({.prediction = 100 + id, .truth = id});
    region_of[100 + id] = region;
  };
  add(1, 1, 1), add(2, 1, 1), add(5, 1, 2), add(6, 1, 3), add(9, 1, 4), add(9, 3, 4);
  const RoomScore score = scoreRooms(matches, truth, rooms, region_of);
  EXPECT_EQ(score.things, 6U);
  EXPECT_EQ(score.rooms, 3U);
  EXPECT_EQ(score.regions, 4U);
  EXPECT_EQ(score.alike, 2U);
  EXPECT_EQ(score.cut, std::vector<std::string>{"bath"});
  EXPECT_TRUE(score.joined.empty());
  add(2, 2, 4);
  EXPECT_EQ(scoreRooms(matches, truth, rooms, region_of).joined, (std::vector<std::string>{"kitchen", "hall"}));
  add(4, 1, 9);
  EXPECT_EQ(scoreRooms(matches, truth, rooms, region_of).things, 7U) << "a door belongs to neither room";
}

}  // namespace
}  // namespace hgg::rooms_eval_test
