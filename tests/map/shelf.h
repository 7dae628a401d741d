#pragma once

#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "map/paging.h"

namespace hgg {

/// A page store in memory that counts what goes through it. It must outlive the stores it gives.
struct Shelf {
  std::map<KeyframeId, MapPage> pages;
  int put = 0, taken = 0;

  PageStore store(double keep_radius) {
    PageStore store;
    store.put = [this](MapPage page) {
      ++put;
      const KeyframeId id = page.keyframe;
      EXPECT_TRUE(pages.emplace(id, std::move(page)).second) << "put twice: " << id;
    };
    store.take = [this](KeyframeId id) {
      ++taken;
      TakenPage page{std::move(pages.at(id))};
      pages.erase(id);
      return page;
    };
    store.keep_radius = keep_radius;
    return store;
  }
};

}  // namespace hgg
