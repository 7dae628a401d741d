#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace hgg {

/// What kinds of things there are, and which is a kind of which: the nouns of WordNet for what one can touch
/// (cmake/bake_wordnet.py). Words are in lower case and the singular, several with an underscore between them.
class Wordnet {
 public:
  using Synset = std::int32_t;  // one meaning, shared by its words

  /// Reads the baked text, which may be empty.
  explicit Wordnet(std::string_view text);
  /// The one that was baked into the library.
  static const Wordnet& builtin();

  bool empty() const { return senses_.empty(); }
  bool knows(const std::string& word) const { return senses_.contains(word); }
  /// The meanings of a word, the most frequent first; none for a word that is not known.
  const std::vector<Synset>& sensesOf(const std::string& word) const;
  /// Steps from a meaning up to another that it is a kind of: 0 for itself; nothing when it is no kind of it.
  std::optional<int> stepsUp(Synset from, Synset to) const;
  /// How far a meaning is from the most general one above it: small for "thing", large for "bar stool".
  int depthOf(Synset synset) const;

 private:
  std::unordered_map<std::string, std::vector<Synset>> senses_;
  std::vector<std::vector<Synset>> above_;
};

}  // namespace hgg
