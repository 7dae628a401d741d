#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/types.h"

namespace hgg {

/// Another word for a class, and how readily people use it for that class, above 0, at most 1.
struct Alias {
  std::string words;  // as they are written, one space between two
  double share = 1;
};

/// What the alias files of label sets (firmware_cfg/<set>/aliases.toml) say of classes, by class name.
struct Aliases {
  std::map<std::string, std::vector<Alias>> words;
  /// WordNet's word above the meaning of a class name, where its first meaning is not the one meant: a "bin" is a
  /// container, not a bin in a histogram. Empty: WordNet is not asked.
  std::map<std::string, std::string> senses;

  /// Adds what another set says. Of a class that both name, all of both.
  void add(const Aliases& other);
  /// Adds what another set says of classes that this one does not name.
  void addMissing(const Aliases& other);
};

/// Share of a word that the file marks with "~": it means the class at times.
inline constexpr double kLooseShare = 0.25;

Result<Aliases> parseAliases(const std::string& toml_text, const std::string& source_name);

/// The shipped words for a map with these class names: those of the label set that names most of them, and those of the
/// others for the classes that it does not name. What a set calls a shelf can be a bookshelf in another.
Aliases builtinAliases(const std::map<ClassId, std::string>& class_names);

}  // namespace hgg
