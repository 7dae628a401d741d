#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include "bag/bag.h"

namespace hgg {
namespace {

namespace fs = std::filesystem;

struct Closer {
  void operator()(sqlite3* db) const { sqlite3_close(db); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, Closer>;
using Statement = std::unique_ptr<sqlite3_stmt, Closer>;

std::string textOf(sqlite3_stmt* row, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text != nullptr ? text : "";
}

/// Files of the bag in the order they were recorded: rosbag2 numbers them.
Result<std::vector<fs::path>> filesOf(const fs::path& path) {
  using Files = Result<std::vector<fs::path>>;
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    return Files::ok({path});
  }
  std::vector<fs::path> files;
  bool is_packed = false, is_mcap = false;
  for (fs::directory_iterator it(path, error), end; !error && it != end; it.increment(error)) {
    is_packed = is_packed || it->path().extension() == ".zstd";
    is_mcap = is_mcap || it->path().extension() == ".mcap";
    if (it->path().extension() == ".db3") {
      files.push_back(it->path());
    }
  }
  const auto number = [](const fs::path& file) {
    const std::string stem = file.stem().string();
    const std::size_t underscore = stem.rfind('_');
    const std::string digits = underscore == std::string::npos ? "" : stem.substr(underscore + 1);
    return std::pair(digits.size(), digits);
  };
  std::ranges::sort(files, {}, number);
  if (files.empty()) {
    return Files::fail(path.string() + (is_packed ? " holds compressed files: unpack them first, `unzstd *.zstd`"
                                        : is_mcap
                                            ? " holds MCAP, which is not read (docs/rosbags.md says how to convert it)"
                                            : " holds no *.db3"));
  }
  return Files::ok(std::move(files));
}

/// ROS 2 says sensor_msgs/msg/PointCloud2 where ROS 1 says sensor_msgs/PointCloud2.
std::string withoutMsg(std::string type) {
  if (const std::size_t at = type.find("/msg/"); at != std::string::npos) {
    type.erase(at, 4);
  }
  return type;
}

struct Topic {
  std::string name, type, format;
};

/// False when the visitor has had enough.
bool readFile(const fs::path& path, const BagVisitor& visit, const std::function<void(double)>& progress, BagEnd& end) {
  const auto damaged = [&](sqlite3* db) {
    end.damage = path.filename().string() + ": " + (db != nullptr ? sqlite3_errmsg(db) : "cannot be opened");
    return true;
  };
  sqlite3* raw = nullptr;
  const int opened = sqlite3_open_v2(path.c_str(), &raw, SQLITE_OPEN_READONLY, nullptr);
  const Database db(raw);
  if (opened != SQLITE_OK) {
    return damaged(db.get());
  }
  const auto prepare = [&](const char* query) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(db.get(), query, -1, &statement, nullptr);
    return Statement(statement);
  };
  const Statement topic = prepare("SELECT id, name, type, serialization_format FROM topics");
  const Statement count = prepare("SELECT COUNT(*) FROM messages");
  const Statement message = prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id");
  if (!topic || !count || !message) {
    return damaged(db.get());
  }
  std::map<std::int64_t, Topic> topics;
  while (sqlite3_step(topic.get()) == SQLITE_ROW) {
    topics[sqlite3_column_int64(topic.get(), 0)] = {textOf(topic.get(), 1), withoutMsg(textOf(topic.get(), 2)),
                                                    textOf(topic.get(), 3)};
  }
  const double all = sqlite3_step(count.get()) == SQLITE_ROW ? sqlite3_column_double(count.get(), 0) : 1;
  double done = 0;
  int state = SQLITE_ROW;
  for (; (state = sqlite3_step(message.get())) == SQLITE_ROW;) {
    const Topic& of = topics[sqlite3_column_int64(message.get(), 0)];
    if (of.format != "cdr") {
      continue;
    }
    const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(message.get(), 2));
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(message.get(), 2));
    ++end.messages;
    if (!visit({of.name, of.type, sqlite3_column_int64(message.get(), 1), BagWire::kCdr, {data, size}})) {
      return false;
    }
    progress(++done / std::max(1.0, all));
  }
  return state == SQLITE_DONE || damaged(db.get());
}

}  // namespace

Result<BagEnd> readRos2Bag(const fs::path& path, const BagVisitor& visit, const BagProgress& progress) {
  const Result<std::vector<fs::path>> files = filesOf(path);
  if (!files) {
    return Result<BagEnd>::fail(files.error);
  }
  BagEnd end;
  for (std::size_t k = 0; k < files->size(); ++k) {
    const auto part = [&](double share) {
      if (progress) {
        progress((static_cast<double>(k) + share) / static_cast<double>(files->size()));
      }
    };
    if (!readFile((*files)[k], visit, part, end)) {
      break;
    }
  }
  if (end.messages == 0 && !end.damage.empty()) {
    return Result<BagEnd>::fail(path.string() + " is no ROS 2 bag in SQLite storage: " + end.damage);
  }
  return Result<BagEnd>::ok(std::move(end));
}

}  // namespace hgg
