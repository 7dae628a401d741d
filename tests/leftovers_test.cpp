#include "leftovers.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "directory_lock.h"
#include "map/file.h"
#include "map/map_store.h"
#include "map/test_map.h"
#include "output.h"
#include "test_scene.h"
#include "tools/scratch.h"

namespace hgg::leftovers_test {
namespace {

using std::filesystem::exists;

/// A journal that holds a map.
void writeJournal(const std::string& path, Map map) {
  Result<MapStore> store = MapStore::open(path, MapStore::Safety::kDurable);
  ASSERT_TRUE(store) << store.error;
  map.trackChanges();
  const MapChanges changes = map.takeChanges(true);
  ASSERT_EQ(store->write(&changes, {}), "");
}

/// What a run leaves that was killed: a journal, two poses and the beginning of a third.
void leaveKilledRun(const Scratch& scratch) {
  writeJournal((scratch / kJournalFile).string(), mapOf({nodeAt(10, Vec3(1, 2, 0))}));
  const std::string pose = "0 0 0 0 0 0 1";
  writeText(scratch / kTrajectoryPart, "1.0 " + pose + " 0 " + pose + "\n2.0 " + pose + " 7 " + pose + "\n3.0 0 0");
}

TEST(Leftovers, OfAKilledRunAreKeptWithTheWayUpToTheJournal) {
  const Scratch scratch;
  leaveKilledRun(scratch);
  writeText(scratch / "map.hgg.123.tmp", "half a map");
  const Result<std::string> kept = keepLeftovers((scratch / "").string(), false);
  ASSERT_TRUE(kept) << kept.error;
  EXPECT_NE(kept->find("was killed"), std::string::npos);
  const Result<StoredMap> map = loadMap((scratch / "recovered.hgg").string());
  ASSERT_TRUE(map) << map.error;
  EXPECT_EQ(map->map.nodes().size(), 1U);
  // The second pose moves with a keyframe that the journal does not have, the third ends in the middle.
  EXPECT_EQ(readText(scratch / "recovered.tum"), "1.0 0 0 0 0 0 0 1\n");
  EXPECT_FALSE(exists(scratch / kJournalFile));
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
  EXPECT_TRUE(exists(scratch / kJournalFile));
}

TEST(Leftovers, AJournalThatTheRunGoesOnFromStaysUntilTheNext) {
  const Scratch scratch;
  leaveKilledRun(scratch);
  ASSERT_TRUE(keepLeftovers((scratch / "").string(), true));
  EXPECT_TRUE(exists(scratch / kJournalFile));
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

TEST(Leftovers, TheLastMapIsTheJournalOfAKilledRunElseThatOfOneThatEnded) {
  const Scratch scratch;
  const std::string directory = (scratch / "").string();
  EXPECT_EQ(lastMapIn(directory), "");
  writeText(scratch / "map.hgg", "");
  EXPECT_TRUE(lastMapIn(directory).ends_with("map.hgg"));
  writeText(scratch / kJournalFile, "");
  EXPECT_TRUE(lastMapIn(directory).ends_with("map.hgg")) << "killed before anything was written";
  writeJournal((scratch / kJournalFile).string(), mapOf({nodeAt(10, Vec3(1, 2, 0))}));
  EXPECT_TRUE(lastMapIn(directory).ends_with(kJournalFile));
}

TEST(Leftovers, AJournalThatCannotBeReadIsKeptAsItIs) {
  const Scratch scratch;
  writeText(scratch / kJournalFile, std::string("SQLite format 3") + std::string(5000, 'x'));
  const Result<std::string> kept = keepLeftovers((scratch / "").string(), false);
  ASSERT_TRUE(kept) << kept.error;
  EXPECT_NE(kept->find("damaged"), std::string::npos);
  EXPECT_TRUE(exists(scratch / "recovered.db"));
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

}  // namespace
}  // namespace hgg::leftovers_test
