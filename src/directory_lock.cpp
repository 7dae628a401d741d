#include "directory_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace hgg {

Result<DirectoryLock> DirectoryLock::take(const std::string& directory) {
  using Taken = Result<DirectoryLock>;
  constexpr int kMode = 0644;
  const std::string path = directory + "/.lock";
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kMode);
  if (file < 0) {
    return Taken::fail(
        fmt::format("{}: cannot write into the output directory (--out): {}", directory, std::strerror(errno)));
  }
  DirectoryLock lock(file);
  if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
    std::string holder;
    std::ifstream(path) >> holder;
    return Taken::fail(fmt::format("{}: another hggmap writes there{}; name another directory (--out)", directory,
                                   holder.empty() ? "" : fmt::format(" (process {})", holder)));
  }
  // Who it is helps whoever is refused; the lock holds without it.
  const std::string text = fmt::format("{}\n", ::getpid());
  [[maybe_unused]] const bool is_named =
      ::ftruncate(file, 0) == 0 && ::pwrite(file, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size());
  return Taken::ok(std::move(lock));
}

DirectoryLock::~DirectoryLock() {
  if (file_ >= 0) {
    ::close(file_);
  }
}

}  // namespace hgg
