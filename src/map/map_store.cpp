#include "map/map_store.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "core/se3.h"
#include "map/node_bytes.h"
#include "map/page_bytes.h"

namespace hgg {
namespace {

constexpr char kStoreMagic[] = "SQLite format 3";
constexpr int kStoreVersion = 1;
/// What SQLite keeps beside a file, and the file.
constexpr const char* kParts[] = {"", "-wal", "-shm"};
/// How long a reader waits where another connection has the file for itself, ms.
constexpr int kBusy = 2000;

constexpr char kTables[] =
    "CREATE TABLE IF NOT EXISTS head (id INTEGER PRIMARY KEY, bytes BLOB NOT NULL);"
    "CREATE TABLE IF NOT EXISTS keyframe (id INTEGER PRIMARY KEY, bytes BLOB NOT NULL);"
    "CREATE TABLE IF NOT EXISTS tie (id INTEGER PRIMARY KEY, bytes BLOB NOT NULL);"
    "CREATE TABLE IF NOT EXISTS page (id INTEGER PRIMARY KEY, bytes BLOB NOT NULL);";

/// A prepared statement.
using Statement = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

Statement prepare(sqlite3* db, const char* sql) {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(db, sql, -1, &statement, nullptr);
  return {statement, sqlite3_finalize};
}

std::string_view bytesOf(sqlite3_stmt* row, int column) {
  return {static_cast<const char*>(sqlite3_column_blob(row, column)),
          static_cast<std::size_t>(sqlite3_column_bytes(row, column))};
}

template <typename Put>
std::string bytesOf(Put put) {
  ByteWriter w;
  put(w);
  return w.bytes();
}

/// Calls take(id, bytes) for each row, ascending; false when the file cannot be read or take() refuses one.
template <typename Take>
bool forEachRow(sqlite3* db, const char* sql, Take take) {
  const Statement rows = prepare(db, sql);
  int code = rows ? sqlite3_step(rows.get()) : SQLITE_ERROR;
  for (; code == SQLITE_ROW; code = sqlite3_step(rows.get())) {
    if (!take(sqlite3_column_int64(rows.get(), 0), bytesOf(rows.get(), 1))) {
      return false;
    }
  }
  return code == SQLITE_DONE;
}

/// Keyframes with their constraints; nullopt where they do not make sense.
std::optional<KeyframeGraph> keyframesOf(sqlite3* db) {
  KeyframeGraph keyframes;
  const bool has_poses = forEachRow(db, "SELECT id, bytes FROM keyframe ORDER BY id", [&](auto id, auto bytes) {
    ByteReader r(bytes);
    const auto utime_us = r.get<Micros>();
    const Pose T_map_body = r.pose();
    return r.good() && r.atEnd() && keyframes.add({utime_us, T_map_body}) == id;
  });
  std::int64_t next = 0;
  const bool has_ties = has_poses && forEachRow(db, "SELECT id, bytes FROM tie ORDER BY id", [&](auto id, auto bytes) {
                          ByteReader r(bytes);
                          const BetweenConstraint e = getConstraint(r, kMapVersion);
                          const bool is_good = r.good() && r.atEnd() && id == next++ && e.a <= keyframes.last() &&
                                               e.b <= keyframes.last();
                          if (is_good) {
                            keyframes.connect(e);
                          }
                          return is_good;
                        });
  return has_ties ? std::optional(std::move(keyframes)) : std::nullopt;
}

}  // namespace

void MapStore::Closer::operator()(sqlite3* db) const { sqlite3_close_v2(db); }

MapStore::MapStore(MapStore&&) noexcept = default;
MapStore& MapStore::operator=(MapStore&&) noexcept = default;
MapStore::~MapStore() = default;

Result<MapStore> MapStore::open(const std::string& path, Safety safety) {
  if (safety == Safety::kScratch) {
    removeMapStore(path);
  }
  sqlite3* db = nullptr;
  const int code =
      sqlite3_open_v2(path.c_str(), &db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
  MapStore store(db);
  // A write-ahead log: readers go on while another connection writes. It is synced at every write where that counts.
  const bool is_open =
      code == SQLITE_OK && store.run("PRAGMA journal_mode = WAL") &&
      store.run(safety == Safety::kDurable ? "PRAGMA synchronous = FULL" : "PRAGMA synchronous = OFF") &&
      store.run("PRAGMA cache_size = -1024") && store.run(kTables) &&
      store.run(fmt::format("PRAGMA user_version = {}", kStoreVersion).c_str());
  sqlite3_busy_timeout(db, kBusy);
  return is_open ? Result<MapStore>::ok(std::move(store))
                 : Result<MapStore>::fail(fmt::format("{}: {}", path, store.whyNot()));
}

Result<MapStore> MapStore::openToRead(const std::string& path) {
  sqlite3* db = nullptr;
  // To read the log of a killed run SQLite has to be allowed to write.
  const int code = sqlite3_open_v2(path.c_str(), &db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
  MapStore store(db);
  sqlite3_busy_timeout(db, kBusy);
  if (code != SQLITE_OK || !store.run("PRAGMA cache_size = -256")) {
    return Result<MapStore>::fail(fmt::format("{}: {}", path, store.whyNot()));
  }
  return Result<MapStore>::ok(std::move(store));
}

std::string MapStore::whyNot() const {
  return db_ == nullptr ? std::string("no memory left") : std::string(sqlite3_errmsg(db_.get()));
}

bool MapStore::run(const char* sql) { return sqlite3_exec(db_.get(), sql, nullptr, nullptr, nullptr) == SQLITE_OK; }

bool MapStore::put(const char* sql, std::int64_t id, const std::string& bytes) {
  const Statement statement = prepare(db_.get(), sql);
  return statement && sqlite3_bind_int64(statement.get(), 1, id) == SQLITE_OK &&
         sqlite3_bind_blob64(statement.get(), 2, bytes.data(), bytes.size(), SQLITE_STATIC) == SQLITE_OK &&
         sqlite3_step(statement.get()) == SQLITE_DONE;
}

bool MapStore::put(const MapPage& page) {
  if (page.nodes.empty()) {
    return run(fmt::format("DELETE FROM page WHERE id = {}", page.keyframe).c_str());
  }
  const Result<std::string> bytes = encodePage(page);
  return bytes && put("REPLACE INTO page VALUES (?, ?)", page.keyframe, *bytes);
}

bool MapStore::put(const MapChanges& changes) {
  const Result<std::string> head = encodeHead(changes.head);
  bool is_good = head && put("REPLACE INTO head VALUES (?, ?)", 1, *head);
  for (const auto& [id, keyframe] : changes.keyframes) {
    const std::string bytes = bytesOf([&, &k = keyframe](ByteWriter& w) {
      w.put(k.utime_us);
      w.put(k.T_map_body);
    });
    is_good = is_good && put("REPLACE INTO keyframe VALUES (?, ?)", id, bytes);
  }
  for (std::size_t k = 0; k < changes.constraints.size(); ++k) {
    const std::string bytes = bytesOf([&](ByteWriter& w) { putConstraint(w, changes.constraints[k]); });
    const auto id = static_cast<std::int64_t>(changes.first_constraint + k);
    is_good = is_good && put("REPLACE INTO tie VALUES (?, ?)", id, bytes);
  }
  return is_good && std::ranges::all_of(changes.pages, [&](const MapPage& page) { return put(page); });
}

std::string MapStore::write(const MapChanges* changes, const std::vector<std::shared_ptr<const MapPage>>& pages) {
  // A page that is in both left memory after the changes were taken: it is the newer one.
  const bool is_good = run("BEGIN IMMEDIATE") && (changes == nullptr || put(*changes)) &&
                       std::ranges::all_of(pages, [&](const auto& page) { return put(*page); }) && run("COMMIT");
  if (is_good) {
    return {};
  }
  std::string why = whyNot();
  run("ROLLBACK");
  return why;
}

Result<MapPage> MapStore::page(KeyframeId id) {
  const Statement row = prepare(db_.get(), "SELECT bytes FROM page WHERE id = ?");
  if (!row || sqlite3_bind_int64(row.get(), 1, id) != SQLITE_OK || sqlite3_step(row.get()) != SQLITE_ROW) {
    return Result<MapPage>::fail(fmt::format("page {}: {}", id, whyNot()));
  }
  Result<MapPage> page = decodePage(bytesOf(row.get(), 0));
  return page && page->keyframe != id ? Result<MapPage>::fail("damaged (a page of another keyframe)") : std::move(page);
}

Result<Map> MapStore::load() {
  std::optional<MapHead> head;
  std::string why = "it holds no map";
  forEachRow(db_.get(), "SELECT id, bytes FROM head", [&](auto, auto bytes) {
    Result<MapHead> read = decodeHead(bytes);
    why = read.error;
    head = std::move(read.value);
    return true;
  });
  std::optional<KeyframeGraph> keyframes = keyframesOf(db_.get());
  if (!head || !keyframes) {
    return Result<Map>::fail(head ? "damaged (its keyframes)" : why);
  }
  std::vector<MapNode> nodes;
  std::map<KeyframeId, Pose> moves;
  const bool has_pages = forEachRow(db_.get(), "SELECT id, bytes FROM page ORDER BY id", [&](auto id, auto bytes) {
    Result<MapPage> page = decodePage(bytes);
    if (!page || page->keyframe != id || page->keyframe > keyframes->last()) {
      why = page ? "damaged (a page of no keyframe)" : page.error;
      return false;
    }
    if (page->keyframe >= 0) {
      const Pose& T_map_keyframe = keyframes->poses()[static_cast<std::size_t>(page->keyframe)].T_map_body;
      if (T_map_keyframe.matrix() != page->T_map_keyframe.matrix()) {
        const Pose move = orthonormalized(T_map_keyframe * page->T_map_keyframe.inverse());
        for (MapNode& node : page->nodes) {
          moveBy(move, head->tile_size, node);
        }
      }
    }
    std::move(page->nodes.begin(), page->nodes.end(), std::back_inserter(nodes));
    return true;
  });
  if (!has_pages) {
    return Result<Map>::fail(why.empty() ? "damaged" : why);
  }
  std::ranges::sort(nodes, {}, &MapNode::id);
  if (std::ranges::adjacent_find(nodes, {}, &MapNode::id) != nodes.end()) {
    return Result<Map>::fail("damaged (an object twice)");
  }
  Map map = Map::restore(std::move(nodes), std::move(*keyframes), head->class_names, head->revision, head->next_id);
  map.setTileSize(head->tile_size);
  map.setOdometryDelay(head->odometry_delay_us);
  if (head->edges) {
    map.setEdgeModel(*head->edges);
  }
  return Result<Map>::ok(std::move(map));
}

bool isMapStore(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, sizeof(kStoreMagic)> magic{};
  file.read(magic.data(), magic.size());
  return file && std::memcmp(magic.data(), kStoreMagic, magic.size()) == 0;
}

Result<Map> loadMapStore(const std::string& path) {
  Result<MapStore> store = MapStore::openToRead(path);
  if (!store) {
    return Result<Map>::fail(store.error);
  }
  Result<Map> map = store->load();
  return map ? std::move(map) : Result<Map>::fail(fmt::format("{}: {}", path, map.error));
}

bool isEmptyMapStore(const std::string& path) {
  std::error_code error;
  if (std::filesystem::file_size(path, error) == 0) {
    return true;
  }
  sqlite3* opened = nullptr;
  sqlite3_open_v2(path.c_str(), &opened, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
  const std::unique_ptr<sqlite3, decltype(&sqlite3_close_v2)> db(opened, sqlite3_close_v2);
  const Statement tables = prepare(db.get(), "SELECT count(*) FROM sqlite_master");
  if (!tables || sqlite3_step(tables.get()) != SQLITE_ROW) {
    return false;
  }
  const Statement heads = prepare(db.get(), "SELECT count(*) FROM head");
  return sqlite3_column_int64(tables.get(), 0) == 0 ||
         (heads && sqlite3_step(heads.get()) == SQLITE_ROW && sqlite3_column_int64(heads.get(), 0) == 0);
}

void removeMapStore(const std::string& path) {
  std::error_code error;
  for (const char* suffix : kParts) {
    std::filesystem::remove(path + suffix, error);
  }
}

std::string moveMapStore(const std::string& from, const std::string& to) {
  std::error_code error, none;
  for (const char* suffix : kParts) {
    if (std::filesystem::exists(from + suffix, none) && !error) {
      std::filesystem::rename(from + suffix, to + suffix, error);
    }
  }
  return error ? fmt::format("{}: {}", to, error.message()) : std::string();
}

}  // namespace hgg
