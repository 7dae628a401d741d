#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hgg {

/// Longest text that is read: a request is a sentence or a few.
inline constexpr std::size_t kMostTextBytes = 2'000;

/// Whether the bytes are UTF-8.
bool isUtf8(std::string_view text);

/// The words of a text in lower case, with "," and "." standing for what separates phrases and sentences. Hyphens and
/// slashes separate words; contractions are written out ("it's" is "it is").
std::vector<std::string> wordsOf(std::string_view text);

/// The singular of a noun, by the rules of English spelling; a word that is none comes back as it was, or nearly.
std::string singularOf(const std::string& noun);

/// Number of insertions, deletions, changes and swaps of neighbours from one word to the other (optimal string
/// alignment), or `limit` + 1 where it is above `limit`.
int spellingDistance(std::string_view a, std::string_view b, int limit);

/// How many mistakes a word of this length may have and still be recognised.
int toleratedMistakes(std::size_t length);

/// The words without anything between them, so that "trash can" and "trashcan" are the same.
std::string joined(const std::vector<std::string>& words);

}  // namespace hgg
