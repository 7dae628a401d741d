// Holds the rule of the house: includes point one way.
//
//   core < config < map < creation < alignment < place < correction < mapper < stats < top < cli
//
// traversability, query and region stand on map, and the latter two on traversability. bus, frame and publish hang off
// the side: they see the core (publish also the map, the mapper, the stats and traversability, to report on them) and
// never each other's insides. What they do share are headers of plain structs, which any room may include: what comes
// in (frame/frame.h, frame/image.h, frame/rig_counts.h), and what goes out with the sinks that take it
// (publish/messages.h). Everything else of those rooms is inside; only the top-level files, which plug the rooms
// together (pipeline, run, replay, output, log_sink), and the commands in cli/ reach for it. LCM's message types stay
// in bus/codec_*.cpp, LCM itself in bus/. The command line stays in cli/ and main.
//
// And that code stays readable by the screen: no function over 60 lines, no file over 400.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace hgg::architecture_test {
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

/// The room of a file: its folder; the top-level files config, mapper and stats are rooms of their own.
std::string roomOf(const std::string& path) {
  if (const auto slash = path.find('/'); slash != std::string::npos) {
    return path.substr(0, slash);
  }
  static const std::set<std::string> kRooms{"config", "mapper", "stats"};
  const std::string stem = fs::path(path).stem().string();
  return kRooms.contains(stem)                                    ? stem
         : stem == "config_keys"                                  ? "config"
         : stem == "default_classes" || stem == "default_aliases" ? "core"
                                                                  : "top";
}

/// Rooms that plug the others together: they may include anything, log, and talk to the user.
bool isOutermost(const std::string& room) { return room == "top" || room == "cli"; }

const std::set<std::string> kPlainStructs{"frame/frame.h", "frame/image.h", "frame/rig_counts.h", "publish/messages.h"};

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
    {"stats", {"core", "config", "map", "correction", "mapper"}},
    {"bus", {"core", "config"}},
    {"frame", {"core", "config"}},
    {"traversability", {"core", "config", "map"}},
    {"query", {"core", "config", "map", "traversability"}},
    {"region", {"core", "config", "map", "traversability"}},
    {"publish", {"core", "config", "map", "mapper", "stats", "traversability", "query", "region"}},
};

TEST(Architecture, IncludesPointOneWay) {
  ASSERT_GE(sources().size(), 40U);
  for (const SourceFile& source : sources()) {
    const std::string room = roomOf(source.path);
    if (isOutermost(room)) {
      for (const std::string& header : source.own_includes) {
        EXPECT_TRUE(room == "cli" || roomOf(header) != "cli" || source.path == "main.cpp")
            << source.path << " must not include " << header;
      }
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
        EXPECT_TRUE(roomOf(header) == "core" || header == "map/node.h" || header == "map/region.h")
            << source.path << " includes " << header;
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
      if (header == "default_classes.h" || header == "default_aliases.h" || !reached.insert(header).second) {
        continue;  // those are generated
      }
      ASSERT_TRUE(by_path.contains(header)) << source.path << " reaches " << header << ", which is not in src/";
      const std::vector<std::string>& next = by_path[header]->own_includes;
      frontier.insert(frontier.end(), next.begin(), next.end());
    }
    EXPECT_FALSE(reached.contains(source.path)) << source.path << " includes itself in a circle";
  }
}

TEST(Architecture, LcmStaysOnTheBus) {
  const std::regex message(R"(^(bot_core|hgg|octomap)/\w+_t\.hpp$)"), lcm(R"(^lcm/)"), codec(R"(^bus/codec_\w+\.cpp$)");
  std::size_t messages = 0;
  for (const SourceFile& source : sources()) {
    for (const std::string& header : source.system_includes) {
      if (std::regex_search(header, message)) {
        ++messages;
        EXPECT_TRUE(std::regex_search(source.path, codec)) << source.path << " includes " << header;
      }
      EXPECT_TRUE(!std::regex_search(header, lcm) || roomOf(source.path) == "bus")
          << source.path << " includes " << header;
    }
  }
  EXPECT_GT(messages, 0U);
}

TEST(Architecture, TheCommandLineStaysInCli) {
  for (const SourceFile& source : sources()) {
    for (const std::string& header : source.system_includes) {
      EXPECT_TRUE(!header.starts_with("CLI/") || roomOf(source.path) == "cli" || source.path == "main.cpp")
          << source.path << " includes " << header;
    }
  }
}

/// Geometry may be out of memory: rooms read it through leavesOf() or Map::geometry(), which say so, and hand in new
/// blocks by assignment.
TEST(Architecture, OnlyTheMapReachesIntoTheGeometryOfItsNodes) {
  const std::regex read(R"((\.|->)geometry\b(?!\s*(=[^=]|\()))");
  std::size_t looked_at = 0;
  for (const SourceFile& source : sources()) {
    if (roomOf(source.path) == "map") {
      continue;
    }
    ++looked_at;
    for (std::size_t k = 0; k < source.lines.size(); ++k) {
      EXPECT_FALSE(std::regex_search(source.lines[k], read)) << source.path << ":" << k + 1 << ": " << source.lines[k];
    }
  }
  EXPECT_GT(looked_at, 50U);
  EXPECT_TRUE(std::regex_search(std::string("for (const Leaf& leaf : *node.geometry) {"), read));
}

TEST(Architecture, LibraryCodeNeitherPrintsNorExits) {
  const std::regex noise(R"(\bstd::(cout|cerr|clog)\b|\bprintf\(|\bfmt::print\(|\bspdlog::|\b_?exit\()");
  for (const SourceFile& source : sources()) {
    if (isOutermost(roomOf(source.path))) {
      continue;  // run and log_sink log, the commands print
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

/// The library and the tools are linked into one program. To the linker two types of one name are one, and it takes the
/// copy, destructor or container of either for both.
TEST(Architecture, NoTwoHeadersDefineTypesOfOneName) {
  static const std::regex kType(R"(^(?:struct|class|enum class) (\w+)(?: : [^{]*)? *\{)");
  std::map<std::string, std::string> header_of;
  for (const char* folder : {"src", "tools"}) {
    const fs::path root = fs::path(HGG_SOURCE_DIR) / folder;
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      if (entry.path().extension() != ".h") {
        continue;
      }
      for (const std::string& line : readSource(entry.path(), root).lines) {
        if (std::smatch match; std::regex_search(line, match, kType)) {
          const auto [known, is_new] = header_of.try_emplace(match[1], entry.path().string());
          EXPECT_TRUE(is_new) << match[1] << " is defined in " << known->second << " and in " << entry.path();
        }
      }
    }
  }
  EXPECT_TRUE(header_of.contains("Map") && header_of.contains("WalkGrid"));
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

// ---------------------------------------------------------------------------------------------------- length

constexpr std::size_t kMaxFileLines = 400, kMaxFunctionLines = 60;

/// The code of a file: what stands in comments, strings and character literals is blanked, lines stay lines.
std::string codeOf(const SourceFile& source) {
  std::string text;
  for (const std::string& line : source.lines) {
    text += (line.starts_with('#') ? "" : line) + "\n";
  }
  static const std::regex kNotCode(
      R"re(//[^\n]*|/\*[^]*?\*/|R"(\w*)\([^]*?\)\1"|"(?:[^"\\\n]|\\.)*"|\b\d[\d']*|'(?:[^'\\\n]|\\.)+')re");
  std::string code;
  auto from = text.cbegin();
  for (std::sregex_iterator it(text.begin(), text.end(), kNotCode), end; it != end; ++it) {
    code.append(from, text.cbegin() + it->position());
    code.append(static_cast<std::size_t>(std::count((*it)[0].first, (*it)[0].second, '\n')), '\n');
    from = (*it)[0].second;
  }
  return code.append(from, text.cend());
}

struct Function {
  std::size_t line = 0, lines = 0;  // first line, from 1; lines from there to the closing brace
};

/// Function bodies by their braces: one that opens in a namespace or a type, behind something with parentheses.
std::vector<Function> functionsOf(const std::string& code) {
  enum class Scope { kNamespace, kType, kFunction, kOther };
  struct Open {
    Scope scope;
    std::size_t line;
  };
  static const std::regex kNamespace(R"(\bnamespace\b|\bextern\b)"), kType(R"(\b(class|struct|enum|union)\b)");
  std::vector<Open> open{{Scope::kNamespace, 0}};
  std::vector<Function> functions;
  std::string head;  // what stands before a brace
  std::size_t line = 1, head_line = 1;
  for (const char c : code) {
    line += c == '\n' ? 1 : 0;
    if (c == '{') {
      const bool outside = open.back().scope == Scope::kNamespace || open.back().scope == Scope::kType;
      const bool has_parameters = head.find('(') != std::string::npos;
      const Scope scope = !outside                              ? Scope::kOther
                          : std::regex_search(head, kNamespace) ? Scope::kNamespace
                          : has_parameters                      ? Scope::kFunction
                          : std::regex_search(head, kType)      ? Scope::kType
                                                                : Scope::kOther;
      open.push_back({scope, head_line});
    } else if (c == '}' && open.size() > 1) {
      if (open.back().scope == Scope::kFunction) {
        functions.push_back({open.back().line, line - open.back().line + 1});
      }
      open.pop_back();
    }
    if (c == '{' || c == '}' || c == ';') {
      head.clear();
    } else if (!head.empty() || std::isspace(static_cast<unsigned char>(c)) == 0) {
      head_line = head.empty() ? line : head_line;
      head += c;
    }
  }
  EXPECT_EQ(open.size(), 1U) << "braces do not match";
  return functions;
}

TEST(Architecture, FunctionsAreFoundByTheirBraces) {
  const SourceFile source{"x.cpp",
                          {"namespace a {", "// not { this", "struct S {", "  int one() const {", "    if (x) {",
                           "      return '{';", "    }", "  }", "  int big = 1'000;", "};", "template <typename T>",
                           "int two(int a,", "        int b) {", R"(  return "}{";)", "}", "}"},
                          {},
                          {}};
  const std::vector<Function> found = functionsOf(codeOf(source));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].line, 4U);
  EXPECT_EQ(found[0].lines, 5U);
  EXPECT_EQ(found[1].line, 11U);
  EXPECT_EQ(found[1].lines, 5U);
}

TEST(Architecture, FilesAndFunctionsAreShort) {
  std::size_t functions = 0;
  for (const SourceFile& source : sources()) {
    EXPECT_LE(source.lines.size(), kMaxFileLines) << source.path;
    for (const Function& function : functionsOf(codeOf(source))) {
      ++functions;
      EXPECT_LE(function.lines, kMaxFunctionLines) << source.path << ":" << function.line;
    }
  }
  EXPECT_GE(functions, 500U);
}

}  // namespace
}  // namespace hgg::architecture_test
