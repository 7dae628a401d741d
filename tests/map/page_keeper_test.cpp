// Holds that a map whose far parts are on disk is whole again when it is stored, after whatever happened to the disk.
#include "map/page_keeper.h"

#include <gtest/gtest.h>

#include <fstream>

#include "map/drive_along.h"
#include "map/file.h"
#include "tools/scratch.h"

namespace hgg::paging_test {
namespace {

PageStore storeOf(PageKeeper& keeper, double keep_radius) {
  PageStore store = keeper.store();
  store.keep_radius = keep_radius;
  store.most_at_once = std::numeric_limits<std::size_t>::max();
  return store;
}

/// More than these maps take at least, so that everything far leaves.
constexpr double kTiny = 0.001;

TEST(PageKeeper, AMapIsStoredWholeWithoutBeingBroughtBack) {
  Map map = driveAlong(200);
  const std::string before = encodeMap(map);
  const Scratch scratch;
  PageKeeper keeper((scratch / "pages.db").string(), kTiny, 0, PageKeeper::Patience::kWaits);
  const PageStore store = storeOf(keeper, 30);
  pageOutBeyond(map, store, Vec3::Zero(), {});
  ASSERT_GT(map.pagedOut().size(), 150U);
  const std::string path = (scratch / "map.hgg").string();
  EXPECT_NE(saveMap(map, path), "") << "there is no reader";
  ASSERT_EQ(saveMap(map, path, store.read), "");
  const Result<StoredMap> stored = loadMap(path);
  ASSERT_TRUE(stored) << stored.error;
  EXPECT_TRUE(encodeMap(*stored) == before);
}

TEST(PageKeeper, WhatWasMovedByALoopWhileItWasAwayIsStoredWhereItBelongs) {
  Map map = driveAlong(100), whole = driveAlong(100);
  const Scratch scratch;
  PageKeeper keeper((scratch / "pages.db").string(), kTiny, 0, PageKeeper::Patience::kWaits);
  const PageStore store = storeOf(keeper, 30);
  pageOutBeyond(map, store, Vec3::Zero(), {});
  MapCorrection correction;
  for (KeyframeId k = 50; k < 100; ++k) {
    correction.moved.emplace_back(k, at(5 * k, 0.1 * (k - 50)));
  }
  map.apply(correction), whole.apply(correction);
  EXPECT_GT(map.pagedOutStale().size(), 45U);
  const std::string path = (scratch / "map.hgg").string();
  ASSERT_EQ(saveMap(map, path, store.read), "");
  const Result<StoredMap> stored = loadMap(path);
  ASSERT_TRUE(stored) << stored.error;
  ASSERT_EQ(stored->map.nodes().size(), whole.nodes().size());
  for (const auto& [id, node] : whole.nodes()) {
    EXPECT_LT((stored->map.find(id)->belief.mean - node.belief.mean).norm(), 1e-9) << id;
    EXPECT_EQ(stored->map.find(id)->tile, node.tile) << id;
  }
}

TEST(PageKeeper, PagesGoToAndFroAndStayWhatTheyAre) {
  Map map = driveAlong(200);
  const std::string before = encodeMap(map);
  const Scratch scratch;
  PageKeeper keeper((scratch / "pages.db").string(), kTiny, 0, PageKeeper::Patience::kWaits);
  const PageStore store = storeOf(keeper, 20);
  for (int lap = 0; lap < 3; ++lap) {
    for (int x = 0; x < 1000; x += 10) {
      bringBack(map, store, Vec3(x, 0, 0), 12);
      store.prefetch(map.pagedOutNear(Vec3(x, 0, 0), 40));
      ASSERT_FALSE(map.nearAnywhere(Vec3(x, 4, 0), 1).empty()) << x;
      pageOutBeyond(map, store, Vec3(x, 0, 0), {}, 3);
    }
  }
  bringBack(map, store, Vec3::Zero(), 1e6);
  EXPECT_TRUE(map.isWhole());
  EXPECT_TRUE(encodeMap(map) == before);
}

TEST(PageKeeper, AJournalHoldsTheMapAsItWasHandedOver) {
  Map map = driveAlong(100);
  map.trackChanges();
  const Scratch scratch;
  const std::string path = (scratch / "journal.db").string();
  PageKeeper keeper(path, kTiny, 5, PageKeeper::Patience::kWaits);
  const PageStore store = storeOf(keeper, 30);
  pageOutBeyond(map, store, Vec3::Zero(), {});
  ASSERT_TRUE(keeper.needsAll());
  keeper.write(map.takeChanges(true));
  ASSERT_EQ(keeper.settle(), "");
  EXPECT_FALSE(keeper.needsAll());
  MapUpdate update;
  update.created.push_back(nodeAt(kCar, Vec3(2, 20, 0)));
  update.removed = {1};
  map.apply(std::move(update));
  keeper.write(map.takeChanges(false));
  ASSERT_EQ(keeper.settle(), "");
  const std::string saved = (scratch / "map.hgg").string();
  ASSERT_EQ(saveMap(map, saved, store.read), "");
  const Result<StoredMap> stored = loadMap(saved), journal = loadMap(path);
  ASSERT_TRUE(stored && journal) << journal.error;
  EXPECT_TRUE(encodeMap(*stored) == encodeMap(*journal));
}

TEST(PageKeeper, ADiskThatTakesNothingIsSaidAndDetailGoesOldestFirst) {
  Map map = driveAlong(100, 50);
  const Scratch scratch;
  PageKeeper keeper((scratch / "no" / "such" / "folder.db").string(), kTiny, 0, PageKeeper::Patience::kWaits);
  const PageStore store = storeOf(keeper, 30);
  pageOutBeyond(map, store, Vec3::Zero(), {}, 40);
  keeper.settle();
  EXPECT_FALSE(store.has_room());
  EXPECT_NE(store.trouble(), "");
  const std::size_t leaves = map.leafCount(), nodes = map.nodes().size();
  dropDetailBeyond(map, store, Vec3::Zero(), {}, 0.4, 10);
  EXPECT_LT(map.leafCount(), leaves);
  EXPECT_EQ(map.nodes().size(), nodes);
  bringBack(map, store, Vec3::Zero(), 1e6);
  EXPECT_TRUE(map.isWhole()) << "what could not be written is still in memory";
}

TEST(PageKeeper, AJournalWhosePagesWaitForChangesHasNoRoomButNeitherWaitsForThemNorFails) {
  Map map = driveAlong(100, 50);
  map.trackChanges();
  const Scratch scratch;
  PageKeeper keeper((scratch / "journal.db").string(), kTiny, 5, PageKeeper::Patience::kPrompt);
  const PageStore store = storeOf(keeper, 30);
  keeper.beginToSave();
  pageOutBeyond(map, store, Vec3::Zero(), {});
  EXPECT_FALSE(store.has_room());  // it would hang here
  EXPECT_FALSE(store.is_failing()) << "detail would be given up for good";
  keeper.write(map.takeChanges(true));
  ASSERT_EQ(keeper.settle(), "");
  EXPECT_TRUE(store.has_room());
}

TEST(MapStore, APageThatLeftMemoryAfterTheChangesWereTakenWins) {
  const Scratch scratch;
  auto store = MapStore::open((scratch / "journal.db").string(), MapStore::Safety::kDurable);
  ASSERT_TRUE(store) << store.error;
  Map map = driveAlong(10);
  map.trackChanges();
  const MapChanges changes = map.takeChanges(true);
  ASSERT_FALSE(changes.pages.empty());
  MapPage newer = changes.pages.back();
  ASSERT_FALSE(newer.nodes.empty());
  newer.nodes.front().views += 100;
  ASSERT_EQ(store->write(&changes, {std::make_shared<const MapPage>(newer)}), "");
  const Result<MapPage> kept = store->page(newer.keyframe);
  ASSERT_TRUE(kept) << kept.error;
  EXPECT_EQ(kept->nodes.front().views, newer.nodes.front().views);
}

TEST(PageKeeper, APageThatWasSpoiledOnDiskIsGivenUpAndSaid) {
  Map map = driveAlong(100);
  const Scratch scratch;
  const std::string path = (scratch / "pages.db").string();
  PageKeeper keeper(path, kTiny, 0, PageKeeper::Patience::kWaits);
  const PageStore store = storeOf(keeper, 30);
  pageOutBeyond(map, store, Vec3::Zero(), {});
  ASSERT_EQ(keeper.settle(), "");
  {
    auto other = MapStore::open(path, MapStore::Safety::kDurable);
    ASSERT_TRUE(other) << other.error;
    MapPage wrong;
    wrong.keyframe = 50;
    ASSERT_EQ(other->write(nullptr, {std::make_shared<const MapPage>(wrong)}), "");  // none
  }
  const std::size_t away = map.pagedOut().size();
  bringBack(map, store, Vec3::Zero(), 1e6);
  EXPECT_TRUE(map.isWhole());
  EXPECT_EQ(map.nodes().size(), 198U) << away;
  EXPECT_NE(store.trouble(), "");
}

}  // namespace
}  // namespace hgg::paging_test
