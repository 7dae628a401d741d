#include "query/lexicon.h"

#include <algorithm>
#include <cmath>

#include "query/english.h"
#include "query/words.h"

namespace hgg {
namespace {

constexpr std::size_t kLongestNoun = 4;  // words
/// How readily people use a word for a class, where nobody counted: the plural for the singular or the other way round,
/// the general word for a special class ("chair" for "office chair"), a word with spelling mistakes.
/// And a word that is the name of another class of the map: who named the classes tells the two apart.
constexpr double kNameOfAnother = 0.1;
constexpr double kOtherNumber = 0.8, kHeadOfName = 0.35, kRespelled = 0.8;
/// A kind of the class ("spaniel" for "dog") and, a step farther up, each time less; and a word for a group of classes.
constexpr double kKindOfClass = 0.7, kPerStep = 0.85, kGroupOfClasses = 0.5;
constexpr int kMostSteps = 4;
/// Meanings above this depth are too general to say what is meant: artifact, instrumentality, whole.
constexpr int kLeastDepth = 2;
constexpr std::size_t kSenses = 2;                        // that a word is used in: rarer ones mislead
constexpr double kLeastCosine = 0.5, kCosineScale = 0.1;  // of embeddings; another encoder needs another scale

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> words = wordsOf(text);
  std::erase_if(words, [](const std::string& w) { return w == "," || w == "."; });
  return words;
}

std::string singularKey(std::vector<std::string> words) {
  words.back() = singularOf(words.back());
  return joined(words);
}

std::string wordnetForm(std::span<const std::string> words) {
  std::string form;
  for (const std::string& word : words) {
    form += (form.empty() ? "" : "_") + word;
  }
  return form;
}

}  // namespace

Lexicon::Lexicon(const std::map<ClassId, std::string>& class_names, const LexiconLayers& layers)
    : layers_(layers), aliases_(layers.aliases ? builtinAliases(class_names) : Aliases{}), names_(class_names) {
  if (layers.more_aliases != nullptr) {
    aliases_.add(*layers.more_aliases);
  }
  for (const auto& [id, name] : class_names) {
    own_names_.insert(joined(split(name)));
  }
  for (const auto& [id, name] : class_names) {
    addName(id, name, 1, layers.forms);
    const auto aliases = aliases_.words.find(name);
    for (const Alias& alias : aliases != aliases_.words.end() ? aliases->second : std::vector<Alias>{}) {
      const bool is_anothers = own_names_.contains(joined(split(alias.words)));
      addName(id, alias.words, alias.share * (is_anothers ? kNameOfAnother : 1), false);
    }
    if (layers.wordnet != nullptr) {
      meanings_[id] = meaningsOf(name);
    }
  }
  for (const auto& [key, fit] : fits_) {
    spellings_.push_back(key);
  }
  std::ranges::sort(spellings_);
}

void Lexicon::addName(ClassId id, const std::string& words, double share, bool with_heads) {
  const std::vector<std::string> parts = split(words);
  if (parts.empty()) {
    return;
  }
  raise(joined(parts), id, share);
  if (!layers_.forms) {
    return;
  }
  raise(singularKey(parts), id, share * kOtherNumber);
  for (std::size_t k = 1; with_heads && k < parts.size(); ++k) {
    const std::vector<std::string> head(parts.begin() + static_cast<std::ptrdiff_t>(k), parts.end());
    const double of_head = share * kHeadOfName * (own_names_.contains(joined(head)) ? kNameOfAnother : 1);
    raise(joined(head), id, of_head);
    raise(singularKey(head), id, of_head * kOtherNumber);
  }
}

void Lexicon::raise(const std::string& key, ClassId id, double share) {
  double& known = fits_[key][id];
  known = std::max(known, share);
}

const ClassFit* Lexicon::find(const std::string& key) const {
  const auto it = fits_.find(key);
  return it != fits_.end() ? &it->second : nullptr;
}

ClassFit Lexicon::classesOf(std::span<const std::string> phrase) const {
  const std::vector<std::string> words(phrase.begin(), phrase.end());
  ClassFit fit;
  if (const ClassFit* as_written = find(joined(words))) {
    fit = *as_written;
  }
  if (const ClassFit* singular = layers_.forms ? find(singularKey(words)) : nullptr) {
    for (const auto& [id, share] : *singular) {
      double& known = fit[id];
      const double of_form = own_names_.contains(joined(words)) ? kNameOfAnother : kOtherNumber;
      known = std::max(known, share * (joined(words) == singularKey(words) ? 1 : of_form));
    }
  }
  return fit;
}

const ClassFit* Lexicon::findRespelled(const std::string& word) const {
  const int tolerated = toleratedMistakes(word.size());
  const ClassFit* best = nullptr;
  int least = tolerated + 1;
  for (const std::string& known : spellings_) {
    if (known.front() == word.front()) {  // people rarely get the first letter wrong
      if (const int d = spellingDistance(word, known, least - 1); d < least) {
        least = d, best = find(known);
      }
    }
  }
  return best;
}

std::vector<Wordnet::Synset> Lexicon::meaningsOf(const std::string& name) const {
  std::vector<std::string> words = split(name);
  if (words.empty()) {
    return {};
  }
  std::vector<Wordnet::Synset> senses = layers_.wordnet->sensesOf(wordnetForm(words));
  if (senses.empty()) {
    words.back() = singularOf(words.back());
    senses = layers_.wordnet->sensesOf(wordnetForm(words));
  }
  if (const auto pinned = aliases_.senses.find(name); pinned != aliases_.senses.end()) {
    const std::vector<Wordnet::Synset>& roots = layers_.wordnet->sensesOf(pinned->second);
    std::erase_if(senses, [&](Wordnet::Synset s) {
      return std::ranges::none_of(roots, [&](Wordnet::Synset r) { return layers_.wordnet->stepsUp(s, r).has_value(); });
    });
  }
  if (senses.size() > 1) {
    senses.erase(senses.begin() + 1, senses.end());
  }
  return senses;
}

ClassFit Lexicon::byKind(const std::string& noun) const {
  ClassFit fit;
  const std::vector<Wordnet::Synset>& senses = layers_.wordnet->sensesOf(noun);
  for (std::size_t k = 0; k < std::min(senses.size(), kSenses); ++k) {
    for (const auto& [id, meanings] : meanings_) {
      for (const Wordnet::Synset meaning : meanings) {
        double share = 0;
        if (const auto up = layers_.wordnet->stepsUp(senses[k], meaning); up && *up <= kMostSteps) {
          share = kKindOfClass * std::pow(kPerStep, *up);
        } else if (const auto down = layers_.wordnet->stepsUp(meaning, senses[k]);
                   down && *down <= kMostSteps && layers_.wordnet->depthOf(senses[k]) >= kLeastDepth) {
          share = kGroupOfClasses;
        }
        if (share > 0) {
          fit[id] = std::max(fit[id], share);
        }
      }
    }
    if (!fit.empty()) {
      break;  // the more frequent sense has an answer
    }
  }
  return fit;
}

ClassFit Lexicon::byEmbedding(const std::string& phrase) const {
  ClassFit fit;
  for (const auto& [id, name] : names_) {
    if (const double cosine = layers_.embeddings->similarity(phrase, name); cosine > kLeastCosine) {
      fit[id] = std::exp((cosine - 1) / kCosineScale);
    }
  }
  return fit;
}

Noun Lexicon::nounAt(std::span<const std::string> words, std::size_t at) const {
  std::size_t most = 1, longest = 1;  // of plain words; of words
  while (most < kLongestNoun && at + most < words.size() && isPlainWord(words[at + most])) {
    ++most;
  }
  while (longest < kLongestNoun && at + longest < words.size() && words[at + longest] != "," &&
         words[at + longest] != ".") {
    ++longest;
  }
  for (std::size_t n = longest; n > 0; --n) {
    if (ClassFit fit = classesOf(words.subspan(at, n)); !fit.empty()) {
      return {n, std::move(fit)};
    }
  }
  const std::string& word = words[at];
  if (!isPlainWord(word)) {
    return {};
  }
  for (std::size_t n = std::min<std::size_t>(most, 3); layers_.wordnet != nullptr && n > 0; --n) {
    std::vector<std::string> form(words.begin() + static_cast<std::ptrdiff_t>(at),
                                  words.begin() + static_cast<std::ptrdiff_t>(at + n));
    if (!layers_.wordnet->knows(wordnetForm(form))) {
      form.back() = singularOf(form.back());
    }
    if (layers_.wordnet->knows(wordnetForm(form)) && !isRelationNoun(form.back())) {
      return {n, byKind(wordnetForm(form))};
    }
  }
  if (layers_.embeddings != nullptr && layers_.embeddings->find(word) != nullptr) {
    return {1, byEmbedding(word)};
  }
  if (const ClassFit* fit = layers_.spelling ? findRespelled(word) : nullptr) {
    ClassFit shares = *fit;
    for (auto& [id, share] : shares) {
      share *= kRespelled;
    }
    return {1, std::move(shares)};
  }
  return {};
}

}  // namespace hgg
