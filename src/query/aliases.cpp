#include "query/aliases.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cstdlib>

#include "default_aliases.h"

namespace hgg {

void Aliases::add(const Aliases& other) {
  for (const auto& [name, more] : other.words) {
    std::vector<Alias>& mine = words[name];
    mine.insert(mine.end(), more.begin(), more.end());
  }
  senses.insert(other.senses.begin(), other.senses.end());
}

void Aliases::addMissing(const Aliases& other) {
  for (const auto& [name, more] : other.words) {
    if (words.try_emplace(name, more).second && other.senses.contains(name)) {
      senses.insert({name, other.senses.at(name)});
    }
  }
}

Result<Aliases> parseAliases(const std::string& toml_text, const std::string& source_name) {
  const auto fail = [&](const std::string& why) {
    return Result<Aliases>::fail(fmt::format("{}: {}", source_name, why));
  };
  const toml::parse_result parsed = toml::parse(toml_text, source_name);
  if (!parsed) {
    return fail(fmt::format("line {}: {}", parsed.error().source().begin.line, parsed.error().description()));
  }
  Aliases aliases;
  for (const auto& [section, content] : parsed.table()) {
    const toml::table* table = content.as_table();
    if (table == nullptr || (section != "aliases" && section != "senses")) {
      return fail(fmt::format("unknown '{}' (known: [aliases] and [senses])", section.str()));
    }
    for (const auto& [key, value] : *table) {
      const std::string name(key.str());
      if (section == "senses") {
        if (!value.is_string()) {
          return fail(fmt::format("senses: '{}' must be a word in quotes", name));
        }
        aliases.senses[name] = value.value_or(std::string{});
        continue;
      }
      const toml::array* list = value.as_array();
      if (list == nullptr || (!list->empty() && !list->is_homogeneous(toml::node_type::string))) {
        return fail(fmt::format("aliases: '{}' must be a list of words in quotes", name));
      }
      std::vector<Alias>& words = aliases.words[name];
      for (const toml::node& node : *list) {
        const std::string word = node.value_or(std::string{});
        const bool loose = word.starts_with('~');
        words.push_back({word.substr(loose ? 1 : 0), loose ? kLooseShare : 1});
      }
    }
  }
  return Result<Aliases>::ok(std::move(aliases));
}

Aliases builtinAliases(const std::map<ClassId, std::string>& class_names) {
  static const std::vector<Aliases> kSets = [] {
    std::vector<Aliases> sets;
    for (const auto& [source, text] : kDefaultAliases) {
      Result<Aliases> set = parseAliases(text, source);
      if (!set) {
        std::abort();  // a shipped file is broken, which tests/query/lexicon_test.cpp finds
      }
      sets.push_back(std::move(*set));
    }
    return sets;
  }();
  const auto named = [&](const Aliases& set) {
    return std::ranges::count_if(class_names, [&](const auto& entry) { return set.words.contains(entry.second); });
  };
  const auto best = std::ranges::max_element(kSets, {}, named);
  Aliases all = *best;
  for (const Aliases& set : kSets) {
    all.addMissing(set);
  }
  return all;
}

}  // namespace hgg
