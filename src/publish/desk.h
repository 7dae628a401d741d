#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <optional>
#include <set>
#include <utility>

namespace hgg {

/// Takes requests in. The bus may lose a request or its answer, so a client asks again: what was answered is answered
/// again, and what is at work is left at work. Requests with the same key are one.
template <typename Key, typename Reply>
class Desk {
 public:
  enum class Verdict { kNew, kAtWork, kAnswered, kFull };
  struct Admission {
    Verdict verdict;
    std::optional<Reply> reply;  // of what was answered
  };
  /// What is new is at work until close() is told.
  Admission admit(const Key& key) {
    const auto told = std::ranges::find(told_, key, &Told::first);
    if (told != told_.end()) {
      return {Verdict::kAnswered, told->second};
    }
    if (at_work_.contains(key)) {
      return {Verdict::kAtWork, std::nullopt};
    }
    if (at_work_.size() >= kMostAtWork) {
      return {Verdict::kFull, std::nullopt};
    }
    at_work_.insert(key);
    return {Verdict::kNew, std::nullopt};
  }
  /// Without a reply to remember, the request is new when it comes again.
  void close(const Key& key, const std::optional<Reply>& reply) {
    at_work_.erase(key);
    if (reply) {
      told_.emplace_back(key, *reply);
    }
    if (told_.size() > kMostRemembered) {
      told_.pop_front();
    }
  }

  static constexpr std::size_t kMostAtWork = 8, kMostRemembered = 64;

 private:
  using Told = std::pair<Key, Reply>;

  std::set<Key> at_work_;
  std::deque<Told> told_;
};

}  // namespace hgg
