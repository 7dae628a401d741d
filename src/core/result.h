#pragma once

#include <optional>
#include <string>
#include <utility>

namespace hgg {

/// A value, or one clear line on what was wrong with the outside world and what to do about it.
/// Errors of our own making abort; they are never a Result.
template <typename T>
struct Result {
  std::optional<T> value;
  std::string error;

  explicit operator bool() const { return value.has_value(); }
  T& operator*() { return *value; }
  const T& operator*() const { return *value; }
  T* operator->() { return &*value; }
  const T* operator->() const { return &*value; }

  static Result ok(T v) { return {std::move(v), {}}; }
  static Result fail(std::string why) { return {std::nullopt, std::move(why)}; }
};

}  // namespace hgg
