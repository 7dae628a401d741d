#pragma once

#include <map>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/types.h"
#include "query/aliases.h"
#include "query/embeddings.h"
#include "query/wordnet.h"

namespace hgg {

/// How readily each class is called by some words: at most 1. Ascending by class.
using ClassFit = std::map<ClassId, double>;

/// Where words are looked up, besides the names of the classes. Each can be left out.
struct LexiconLayers {
  bool aliases = true;                    // those of the label sets
  const Aliases* more_aliases = nullptr;  // those of a user
  bool forms = true;                      // plurals, the last word of a name ("chair" for "office chair")
  bool spelling = true;                   // words with a mistake or two
  const Wordnet* wordnet = &Wordnet::builtin();
  const Embeddings* embeddings = nullptr;
};

/// A noun found among words.
struct Noun {
  std::size_t length = 0;  // words it takes; 0: there is none
  ClassFit classes;        // empty: a thing that no class of the map stands for
};

/// From words to the classes of one map.
class Lexicon {
 public:
  Lexicon(const std::map<ClassId, std::string>& class_names, const LexiconLayers& layers);

  /// The longest noun that begins at words[at].
  Noun nounAt(std::span<const std::string> words, std::size_t at) const;
  /// The classes that a whole phrase may mean, such as "office chair".
  ClassFit classesOf(std::span<const std::string> phrase) const;

 private:
  void addName(ClassId id, const std::string& words, double share, bool with_heads);
  void raise(const std::string& key, ClassId id, double share);
  const ClassFit* find(const std::string& key) const;
  const ClassFit* findRespelled(const std::string& word) const;
  ClassFit byKind(const std::string& noun) const;
  ClassFit byEmbedding(const std::string& phrase) const;
  std::vector<Wordnet::Synset> meaningsOf(const std::string& name) const;

  LexiconLayers layers_;
  Aliases aliases_;
  std::unordered_map<std::string, ClassFit> fits_;  // by words joined (words.h)
  std::vector<std::string> spellings_;              // of the keys that may be misspelled, sorted
  std::map<ClassId, std::string> names_;
  std::set<std::string> own_names_;  // of all classes, joined
  std::map<ClassId, std::vector<Wordnet::Synset>> meanings_;
};

}  // namespace hgg
