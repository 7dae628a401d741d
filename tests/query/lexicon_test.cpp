#include "query/lexicon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "core/classes.h"
#include "query/words.h"

namespace hgg::lexicon_test {
namespace {

std::map<ClassId, std::string> classesOfSet(const std::string& set) {
  const Result<ClassTable> table =
      ClassTable::load(std::string(HGG_SOURCE_DIR) + "/firmware_cfg/" + set + "/classes.toml");
  EXPECT_TRUE(table) << table.error;
  std::map<ClassId, std::string> names;
  for (const ClassInfo& info : table->classes()) {
    if (info.kind != ClassKind::kIgnore) {
      names[info.id] = info.name;
    }
  }
  return names;
}

/// The names of the classes that fit best; all that tie.
std::set<std::string> bestOf(const Lexicon& lexicon, const std::map<ClassId, std::string>& names,
                             const std::string& phrase) {
  const std::vector<std::string> words = wordsOf(phrase);
  ClassFit fit;
  for (std::size_t at = 0; at < words.size();) {  // as in a sentence, the last noun is the head
    const Noun noun = lexicon.nounAt(words, at);
    fit = noun.length > 0 && !noun.classes.empty() ? noun.classes : fit;
    at += std::max<std::size_t>(noun.length, 1);
  }
  double most = 0;
  for (const auto& [id, share] : fit) {
    most = std::max(most, share);
  }
  std::set<std::string> best;
  for (const auto& [id, share] : fit) {
    if (share == most) {
      best.insert(names.at(id));
    }
  }
  return best;
}

struct Probe {
  std::string set, words;
  std::set<std::string> expected;  // empty: nothing
};

std::vector<Probe> probes() {
  std::ifstream file(std::string(HGG_SOURCE_DIR) + "/tests/query/words.txt");
  std::vector<Probe> all;
  const auto trim = [](std::string text) {
    text.erase(0, text.find_first_not_of(' '));
    return text.substr(0, text.find_last_not_of(' ') + 1);
  };
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') {
      continue;
    }
    std::istringstream parts(line);
    Probe probe;
    std::string classes;
    std::getline(parts, probe.set, '|'), std::getline(parts, probe.words, '|'), std::getline(parts, classes);
    probe.set = trim(probe.set), probe.words = trim(probe.words);
    std::istringstream list(classes);
    for (std::string name; std::getline(list, name, ',');) {
      if (trim(name) != "-") {
        probe.expected.insert(trim(name));
      }
    }
    all.push_back(probe);
  }
  return all;
}

TEST(Lexicon, KnowsEverydayWordsAndWhatItDoesNotKnow) {
  std::map<std::string, std::map<ClassId, std::string>> names;
  std::map<std::string, Lexicon> lexicons;
  int inside = 0, inside_right = 0, outside = 0, outside_right = 0;
  std::string wrong;
  for (const Probe& probe : probes()) {
    if (!lexicons.contains(probe.set)) {
      names[probe.set] = classesOfSet(probe.set);
      lexicons.emplace(probe.set, Lexicon(names[probe.set], {}));
    }
    const std::set<std::string> best = bestOf(lexicons.at(probe.set), names[probe.set], probe.words);
    const bool is_right =
        probe.expected.empty() ? best.empty() : !best.empty() && std::ranges::all_of(best, [&](const auto& name) {
          return probe.expected.contains(name);
        });
    (probe.expected.empty() ? outside : inside) += 1;
    (probe.expected.empty() ? outside_right : inside_right) += is_right ? 1 : 0;
    if (!is_right) {
      wrong += probe.set + ": " + probe.words + " ->";
      for (const std::string& name : best) {
        wrong += " " + name + ",";
      }
      wrong += "\n";
    }
  }
  RecordProperty("right", inside_right), RecordProperty("of", inside);
  RecordProperty("outside_right", outside_right), RecordProperty("outside_of", outside);
  EXPECT_GE(inside, 150);
  EXPECT_GE(inside_right, 0.88 * inside) << wrong;
  EXPECT_GE(outside_right, 0.92 * outside) << wrong;
}

const std::map<ClassId, std::string> kRoom{{1, "chair"}, {2, "office chair"}, {3, "table"}, {4, "trash can"}};

ClassFit fitOf(const std::string& text, const LexiconLayers& layers,
               const std::map<ClassId, std::string>& names = kRoom) {
  return Lexicon(names, layers).nounAt(wordsOf(text), 0).classes;
}

constexpr const Wordnet* kNoWordnet = nullptr;
const LexiconLayers kBare{false, nullptr, false, false, kNoWordnet, nullptr};

TEST(Lexicon, EachLayerCanBeLeftOut) {
  EXPECT_TRUE(fitOf("chair", kBare).contains(1));
  EXPECT_TRUE(fitOf("chairs", kBare).empty());
  LexiconLayers layers = kBare;
  layers.forms = true;
  EXPECT_TRUE(fitOf("chairs", layers).contains(1));
  EXPECT_TRUE(fitOf("cahir", layers).empty());
  layers.spelling = true;
  EXPECT_TRUE(fitOf("cahir", layers).contains(1));
  EXPECT_TRUE(fitOf("garbage can", layers).empty());
  layers.aliases = true;
  EXPECT_TRUE(fitOf("garbage can", layers).contains(4));
}

TEST(Lexicon, WritesWordsTogetherOrApart) {
  EXPECT_TRUE(fitOf("trashcan", {}).contains(4));
  EXPECT_TRUE(fitOf("trash-can", {}).contains(4));
}

TEST(Lexicon, PrefersTheClassThatIsCalledSo) {
  const ClassFit fit = fitOf("chair", {});
  EXPECT_GT(fit.at(1), 3 * fit.at(2));
  EXPECT_FALSE(fitOf("office chair", {}).contains(3));
  EXPECT_GT(fitOf("office chair", {}).at(2), 0.9);
}

TEST(Lexicon, UsesATableOfEmbeddingsWhereThereIsOne) {
  const Result<Embeddings> table = Embeddings::parse("chair\t1 0\ntable\t0 1\nthrone\t0.9 0.1\n", "table.tsv");
  ASSERT_TRUE(table) << table.error;
  LexiconLayers layers = kBare;
  EXPECT_TRUE(fitOf("throne", layers).empty());
  layers.embeddings = &*table;
  const ClassFit fit = fitOf("throne", layers);
  EXPECT_TRUE(fit.contains(1));
  EXPECT_FALSE(fit.contains(3));
}

TEST(Embeddings, RefuseLinesOfAnotherLength) {
  EXPECT_FALSE(Embeddings::parse("a\t1 2\nb\t1\n", "t"));
  EXPECT_FALSE(Embeddings::parse("a 1 2\n", "t"));
  EXPECT_FALSE(Embeddings::parse("a\t1 x\n", "t"));
  EXPECT_FALSE(Embeddings::parse("a\t0 0\n", "t"));
}

TEST(Aliases, OfAllShippedSetsNameClassesOfTheirSet) {
  for (const std::string set : {"indoor", "semantickitti", "scannet"}) {
    std::ifstream file(std::string(HGG_SOURCE_DIR) + "/firmware_cfg/" + set + "/aliases.toml");
    std::ostringstream text;
    text << file.rdbuf();
    const Result<Aliases> aliases = parseAliases(text.str(), set);
    ASSERT_TRUE(aliases) << aliases.error;
    EXPECT_GT(aliases->words.size(), 15U);
    if (set == "scannet") {
      continue;  // annotators named freely: more names than the table has
    }
    std::set<std::string> names;
    for (const auto& [id, name] : classesOfSet(set)) {
      names.insert(name);
    }
    for (const auto& [name, words] : aliases->words) {
      EXPECT_TRUE(names.contains(name)) << set << " has no class " << name;
    }
  }
}

TEST(Aliases, SayWhatIsWrongWithAFile) {
  EXPECT_NE(parseAliases("[aliases]\nchair = 3\n", "f").error.find("chair"), std::string::npos);
  EXPECT_NE(parseAliases("[alias]\n", "f").error.find("alias"), std::string::npos);
  EXPECT_NE(parseAliases("[aliases\n", "f").error.find("line 1"), std::string::npos);
  EXPECT_DOUBLE_EQ(parseAliases("[aliases]\nchair = [\"~seat\"]\n", "f")->words.at("chair")[0].share, kLooseShare);
}

}  // namespace
}  // namespace hgg::lexicon_test
