#include "leftovers.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "directory_lock.h"
#include "map/file.h"
#include "map/test_map.h"
#include "output.h"
#include "snapshot.h"
#include "test_scene.h"
#include "tools/scratch.h"

namespace hgg::leftovers_test {
namespace {

using std::filesystem::exists;

constexpr auto kSecond = std::chrono::seconds(1);

/// What a run leaves that was killed: a snapshot, two poses and the beginning of a third.
void leaveKilledRun(const Scratch& scratch) {
  ASSERT_EQ(saveMap(mapOf({nodeAt(10, Vec3(1, 2, 0))}), (scratch / kSnapshotFile).string()), "");
  const std::string pose = "0 0 0 0 0 0 1";
  writeText(scratch / kTrajectoryPart, "1.0 " + pose + " 0 " + pose + "\n2.0 " + pose + " 7 " + pose + "\n3.0 0 0");
}

TEST(Leftovers, OfAKilledRunAreKeptWithTheWayUpToTheSnapshot) {
  const Scratch scratch;
  leaveKilledRun(scratch);
  writeText(scratch / "map.hgg.123.tmp", "half a map");
  const Result<std::string> kept = keepLeftovers((scratch / "").string(), false);
  ASSERT_TRUE(kept) << kept.error;
  EXPECT_NE(kept->find("was killed"), std::string::npos);
  const Result<StoredMap> map = loadMap((scratch / "recovered.hgg").string());
  ASSERT_TRUE(map) << map.error;
  EXPECT_EQ(map->map.nodes().size(), 1U);
  // The second pose moves with a keyframe that the snapshot does not have, the third ends in the middle.
  EXPECT_EQ(readText(scratch / "recovered.tum"), "1.0 0 0 0 0 0 0 1\n");
  EXPECT_FALSE(exists(scratch / kSnapshotFile));
  EXPECT_FALSE(exists(scratch / "map.hgg.123.tmp"));
}

TEST(Leftovers, OfASecondKilledRunDoNotReplaceThoseOfTheFirst) {
  const Scratch scratch;
  for (const char* name : {"recovered.hgg", "recovered-2.hgg"}) {
    leaveKilledRun(scratch);
    ASSERT_TRUE(keepLeftovers((scratch / "").string(), false));
    EXPECT_TRUE(exists(scratch / name));
  }
}

TEST(Leftovers, ThatPileUpAreAnErrorThatSaysWhatToDo) {
  const Scratch scratch;
  Result<std::string> kept = Result<std::string>::ok({});
  for (int k = 0; k < 100 && kept; ++k) {
    leaveKilledRun(scratch);
    kept = keepLeftovers((scratch / "").string(), false);
  }
  EXPECT_NE(kept.error.find("move them away"), std::string::npos);
  EXPECT_TRUE(exists(scratch / kSnapshotFile));
}

TEST(Leftovers, ASnapshotThatTheRunGoesOnFromStaysUntilTheNext) {
  const Scratch scratch;
  leaveKilledRun(scratch);
  ASSERT_TRUE(keepLeftovers((scratch / "").string(), true));
  EXPECT_TRUE(exists(scratch / kSnapshotFile));
  EXPECT_FALSE(exists(scratch / "recovered.hgg"));
  EXPECT_TRUE(exists(scratch / "recovered.tum"));
}

TEST(Leftovers, OfARunThatEndedWellAreNone) {
  const Scratch scratch;
  ASSERT_EQ(saveMap(mapOf({}), (scratch / "map.hgg").string()), "");
  const Result<std::string> kept = keepLeftovers((scratch / "").string(), false);
  ASSERT_TRUE(kept);
  EXPECT_EQ(*kept, "");
  EXPECT_TRUE(exists(scratch / "map.hgg"));
}

TEST(Leftovers, TheLastMapIsTheSnapshotOfAKilledRunElseThatOfOneThatEnded) {
  const Scratch scratch;
  const std::string directory = (scratch / "").string();
  EXPECT_EQ(lastMapIn(directory), "");
  writeText(scratch / "map.hgg", "");
  EXPECT_TRUE(lastMapIn(directory).ends_with("map.hgg"));
  writeText(scratch / kSnapshotFile, "");
  EXPECT_TRUE(lastMapIn(directory).ends_with(kSnapshotFile));
}

TEST(Leftovers, ARunThatEndsWellReplacesItsSnapshotByTheMap) {
  const Scratch scratch;
  const std::string directory = (scratch / "out").string();
  Result<OutputDirectory> out = OutputDirectory::open(directory);
  ASSERT_TRUE(out) << out.error;
  writeText(scratch / "out" / kSnapshotFile, "");
  const Mapper mapper({}, testClasses(), mapOf({}));
  ASSERT_EQ(out->finish(mapper, {}), "");
  EXPECT_FALSE(exists(scratch / "out" / kSnapshotFile));
  EXPECT_TRUE(exists(scratch / "out" / "map.hgg"));
}

TEST(DirectoryLock, IsRefusedToTheSecondAndFreeAgainAfterTheFirst) {
  const Scratch scratch;
  const std::string directory = (scratch / "").string();
  {
    const Result<DirectoryLock> first = DirectoryLock::take(directory);
    ASSERT_TRUE(first) << first.error;
    const Result<DirectoryLock> second = DirectoryLock::take(directory);
    EXPECT_FALSE(second);
    EXPECT_NE(second.error.find("another hggmap writes there"), std::string::npos);
  }
  EXPECT_TRUE(DirectoryLock::take(directory));
}

TEST(Snapshot, IsWrittenWhenItIsDueAndNotBefore) {
  const Scratch scratch;
  const std::string path = (scratch / "s.hgg").string();
  const Map map = mapOf({nodeAt(10, Vec3::Zero())});
  SnapshotWriter writer(path, 5);
  const SnapshotWriter::Clock::time_point start{};
  writer.offer(map, start);
  writer.offer(map, start + 4 * kSecond);
  EXPECT_EQ(writer.finish(), "");
  EXPECT_FALSE(exists(path));
  writer.offer(map, start + 5 * kSecond);
  EXPECT_EQ(writer.finish(), "");
  EXPECT_EQ(readText(path), encodeMap(map));
}

TEST(Snapshot, ThatCannotBeWrittenIsSaidAndTriedAgain) {
  const Scratch scratch;
  const std::string path = (scratch / "missing" / "s.hgg").string();
  const Map map = mapOf({nodeAt(10, Vec3::Zero())});
  SnapshotWriter writer(path, 1);
  const SnapshotWriter::Clock::time_point start{};
  writer.offer(map, start);
  writer.offer(map, start + kSecond);
  EXPECT_NE(writer.finish().find("cannot write the map"), std::string::npos);
  std::filesystem::create_directories(scratch / "missing");
  writer.offer(map, start + 1000 * kSecond);
  EXPECT_EQ(writer.finish(), "");
  EXPECT_TRUE(exists(path));
}

TEST(Snapshot, IsNoneOfAnEmptyMapNorWhenSwitchedOff) {
  const Scratch scratch;
  const std::string path = (scratch / "s.hgg").string();
  SnapshotWriter writer(path, 1), off(path, 0);
  const Map map = mapOf({nodeAt(10, Vec3::Zero())});
  for (int k = 0; k < 5; ++k) {
    writer.offer({}, SnapshotWriter::Clock::time_point{} + k * kSecond);
    off.offer(map, SnapshotWriter::Clock::time_point{} + k * kSecond);
  }
  EXPECT_EQ(writer.finish() + off.finish(), "");
  EXPECT_FALSE(exists(path));
}

}  // namespace
}  // namespace hgg::leftovers_test
