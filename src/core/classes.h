#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/types.h"

namespace hgg {

enum class ClassKind : std::uint8_t { kIgnore, kThing, kStuff };

/// What the mapper knows of a semantic class.
struct ClassInfo {
  ClassId id = 0;
  std::string name;
  ClassKind kind = ClassKind::kIgnore;
  bool dynamic = false;       // members can move by themselves
  double cluster_radius = 0;  // m, things only: points closer than this belong together
  int min_points = 0;         // clusters (or tiles) below this many points are dropped
};

/// Two classes that different segmenters, or one on a bad day, may call the same thing.
struct SimilarClasses {
  std::string a, b;       // names; of this table or of another's
  double similarity = 0;  // above 0, at most 1
};

/// The class of points that nobody has named: stuff, of a rig whose cameras do not see everything.
constexpr ClassId kUnknownClass = 65534;

/// Label id -> class; labels that fold (moving-car -> car) answer with the class they fold into.
class ClassTable {
 public:
  /// nullptr when the label is not in the table.
  const ClassInfo* find(ClassId label) const {
    return by_label_[label] < 0 ? nullptr : &classes_[static_cast<std::size_t>(by_label_[label])];
  }
  const std::vector<ClassInfo>& classes() const { return classes_; }  // in the order of the file
  std::string name(ClassId label) const;                              // "class 17" when unknown
  const std::vector<SimilarClasses>& similar() const { return similar_; }

  /// The same table with kUnknownClass as one more kind of stuff, "unknown". The table must not use its id.
  ClassTable withUnknown() const;

  static Result<ClassTable> parse(const std::string& toml_text, const std::string& source_name);
  static Result<ClassTable> load(const std::string& path);
  /// The shipped SemanticKITTI table.
  static ClassTable builtin();

 private:
  std::vector<ClassInfo> classes_;
  std::vector<SimilarClasses> similar_;
  std::vector<std::int32_t> by_label_ = std::vector<std::int32_t>(65536, -1);
};

}  // namespace hgg
