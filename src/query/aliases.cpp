#include "query/aliases.h"

#include <fmt/format.h>
#include <toml++/toml.h>

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

const Aliases& builtinAliases() {
  static const Aliases kBuiltin = [] {
    Aliases all;
    for (const auto& [source, text] : kDefaultAliases) {
      const Result<Aliases> set = parseAliases(text, source);
      if (!set) {
        std::abort();  // a shipped file is broken, which tests/query/aliases_test.cpp finds
      }
      all.add(*set);
    }
    return all;
  }();
  return kBuiltin;
}

}  // namespace hgg
