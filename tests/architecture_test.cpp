// Holds the rule of the house: includes point one way.
//
//   core < config < map < creation < alignment < place < correction < mapper < top (pipeline, run, replay, output, stats, main)
//
// bus, frame, query, traversability and publish hang off the side: they see the core (and the map, or the mapper, to
// report on it) and never each other's insides. What they do share are two headers of plain structs, which any room may
// include: frame/frame.h (what comes in) and publish/messages.h (what goes out). Everything else of those rooms is
// inside; only top-level files, which plug the rooms together, reach for it. LCM's message types stay in bus/codec.cpp,
// LCM itself in bus/.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace hgg {
namespace {

namespace fs = std::filesystem;

struct SourceFile {
  std::string path;  // relative to src/
  std::vector<std::string> lines;
  std::vector<std::string> own_includes, system_includes;
};

SourceFile readSource(const fs::path& file, const fs::path& root) {
  static const std::regex kInclude(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  SourceFile source;
  source.path = fs::relative(file, root).generic_string();
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (std::smatch match; std::regex_search(line, match, kInclude)) {
      (match[1] == "\"" ? source.own_includes : source.system_includes).push_back(match[2]);
    }
    source.lines.push_back(std::move(line));
  }
  return source;
}

const std::vector<SourceFile>& sources() {
  static const std::vector<SourceFile> kSources = [] {
    const fs::path root = fs::path(HGG_SOURCE_DIR) / "src";
    std::vector<SourceFile> all;
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp") {
        all.push_back(readSource(entry.path(), root));
      }
    }
    std::sort(all.begin(), all.end(), [](const SourceFile& a, const SourceFile& b) { return a.path < b.path; });
    return all;
  }();
  return kSources;
}

/// The room of a file: its folder; the top-level files config and mapper are rooms of their own.
std::string roomOf(const std::string& path) {
  if (const auto slash = path.find('/'); slash != std::string::npos) {
    return path.substr(0, slash);
  }
  const std::string stem = fs::path(path).stem().string();
  return stem == "config" || stem == "mapper" ? stem : stem == "default_classes" ? "core" : "top";
}

const std::set<std::string> kPlainStructs{"frame/frame.h", "frame/image.h", "publish/messages.h"};

/// Which rooms each room may look into, beside itself and the plain structs.
const std::map<std::string, std::set<std::string>> kMayInclude{
    {"core", {}},
    {"config", {"core"}},
    {"map", {"core", "config"}},
    {"creation", {"core", "config", "map"}},
    {"alignment",
     {"core", "config", "map", "creation"}},  // compares the map's graph, built by creation's rule, with the frame's
    {"place", {"core", "config", "map", "alignment"}},
    {"correction", {"core", "config", "map", "creation", "alignment", "place"}},
    {"mapper", {"core", "config", "map", "creation", "alignment", "place", "correction"}},
    {"bus", {"core", "config"}},
    {"frame", {"core", "config"}},
    {"query", {"core", "config", "map"}},
    {"traversability", {"core", "config", "map"}},
    {"publish", {"core", "config", "map", "mapper"}},
};

TEST(Architecture, IncludesPointOneWay) {
  ASSERT_GE(sources().size(), 40U);
  for (const SourceFile& source : sources()) {
    const std::string room = roomOf(source.path);
    if (room == "top") {
      continue;
    }
    ASSERT_TRUE(kMayInclude.contains(room)) << source.path << ": a new room; say here what it may include";
    for (const std::string& header : source.own_includes) {
      const std::string other = roomOf(header);
      EXPECT_TRUE(other == room || kMayInclude.at(room).contains(other) || kPlainStructs.contains(header))
          << source.path << " must not include " << header;
    }
  }
}

TEST(Architecture, SharedStructsArePlain) {
  for (const SourceFile& source : sources()) {
    if (kPlainStructs.contains(source.path)) {
      for (const std::string& header : source.own_includes) {
        EXPECT_TRUE(roomOf(header) == "core" || header == "map/node.h") << source.path << " includes " << header;
      }
      EXPECT_FALSE(fs::exists(fs::path(HGG_SOURCE_DIR) / "src" / fs::path(source.path).replace_extension(".cpp")))
          << source.path << " has code behind it";
    }
  }
}

TEST(Architecture, EveryIncludedHeaderExistsAndNoneIncludesItself) {
  std::map<std::string, const SourceFile*> by_path;
  for (const SourceFile& source : sources()) {
    by_path[source.path] = &source;
  }
  for (const SourceFile& source : sources()) {
    std::set<std::string> reached;
    std::vector<std::string> frontier = source.own_includes;
    while (!frontier.empty()) {
      const std::string header = frontier.back();
      frontier.pop_back();
      if (header == "default_classes.h" || !reached.insert(header).second) {
        continue;  // the former is generated
      }
      ASSERT_TRUE(by_path.contains(header)) << source.path << " reaches " << header << ", which is not in src/";
      const std::vector<std::string>& next = by_path[header]->own_includes;
      frontier.insert(frontier.end(), next.begin(), next.end());
    }
    EXPECT_FALSE(reached.contains(source.path)) << source.path << " includes itself in a circle";
  }
}

TEST(Architecture, LcmStaysOnTheBus) {
  const std::regex message(R"(^(bot_core|hgg|octomap)/\w+_t\.hpp$)"), lcm(R"(^lcm/)");
  std::size_t messages = 0;
  for (const SourceFile& source : sources()) {
    for (const std::string& header : source.system_includes) {
      if (std::regex_search(header, message)) {
        ++messages;
        EXPECT_EQ(source.path, "bus/codec.cpp") << "includes " << header;
      }
      EXPECT_TRUE(!std::regex_search(header, lcm) || roomOf(source.path) == "bus")
          << source.path << " includes " << header;
    }
  }
  EXPECT_GT(messages, 0U);
}

TEST(Architecture, LibraryCodeNeitherPrintsNorExits) {
  const std::regex noise(R"(\bstd::(cout|cerr|clog)\b|\bprintf\(|\bfmt::print\(|\bspdlog::|\b_?exit\()");
  for (const SourceFile& source : sources()) {
    if (roomOf(source.path) == "top") {
      continue;  // run and main log, the progress bar draws
    }
    for (std::size_t k = 0; k < source.lines.size(); ++k) {
      EXPECT_FALSE(std::regex_search(source.lines[k], noise)) << source.path << ":" << k + 1 << ": " << source.lines[k];
    }
  }
}

TEST(Architecture, HeadersBeginWithPragmaOnce) {
  for (const SourceFile& source : sources()) {
    if (source.path.ends_with(".h")) {
      ASSERT_FALSE(source.lines.empty()) << source.path;
      EXPECT_EQ(source.lines[0], "#pragma once") << source.path;
    }
  }
}

TEST(Architecture, SourcesIncludeTheirOwnHeaderFirst) {
  for (const SourceFile& source : sources()) {
    const std::string header = fs::path(source.path).replace_extension(".h").generic_string();
    const bool has_header =
        std::any_of(sources().begin(), sources().end(), [&](const SourceFile& s) { return s.path == header; });
    if (source.path.ends_with(".cpp") && has_header) {
      EXPECT_EQ(source.lines[0], "#include \"" + header + "\"") << source.path;
    }
  }
}

}  // namespace
}  // namespace hgg
