#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/result.h"

namespace hgg {

/// A table of text embeddings, made beforehand by the user's own encoder: one line a phrase, the phrase, a tab, then
/// its numbers with a space between two. All lines have as many numbers. Vectors are scaled to unit length.
class Embeddings {
 public:
  static Result<Embeddings> parse(const std::string& text, const std::string& source_name);

  bool empty() const { return vectors_.empty(); }
  /// nullptr for a phrase that is not in the table.
  const std::vector<float>* find(const std::string& phrase) const;
  /// Cosine of the angle between two phrases' vectors; 0 when one of them is not in the table.
  double similarity(const std::string& a, const std::string& b) const;

 private:
  std::map<std::string, std::vector<float>> vectors_;
};

}  // namespace hgg
