#pragma once

#include <string>
#include <utility>

#include "core/result.h"

namespace hgg {

/// Holds a directory for one process: another one that wants it is refused until this one ends, in whatever way it
/// ends.
class DirectoryLock {
 public:
  /// Takes `directory`, which exists, by a lock on the file `.lock` in it. The error names who holds it.
  static Result<DirectoryLock> take(const std::string& directory);

  DirectoryLock(DirectoryLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  DirectoryLock& operator=(DirectoryLock&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;
  ~DirectoryLock();

 private:
  explicit DirectoryLock(int file) : file_(file) {}

  int file_;  // descriptor; -1: none
};

}  // namespace hgg
