#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "map/map.h"

struct sqlite3;

namespace hgg {

/// A map on disk that parts of are written and read: an SQLite file. What is written in one go is there as a whole or
/// not at all, whenever the program or the machine stops.
///
///   head       (one row)         class names, tile size, delay, revision, next id, edge model
///   keyframe   (id, bytes)       time and pose
///   tie        (id, bytes)       between constraint, numbered as in the keyframe graph
///   page       (keyframe, bytes) what is anchored to a keyframe (-1: to none), where the keyframe was when it was
///                                written: the nodes have moved with it since. None without nodes.
///
/// Bytes of pages and the head are zstd frames with a checksum, of the newest layout of map/file.h.
class MapStore {
 public:
  enum class Safety : std::uint8_t {
    kScratch,  // for this run: nothing is left of it when it ends, and a power cut may spoil it
    kDurable,  // what is written outlives a power cut
  };
  /// Opens or begins a file. A scratch file begins empty, whatever there was.
  static Result<MapStore> open(const std::string& path, Safety safety);
  /// Opens a file to be read while another writes it.
  static Result<MapStore> openToRead(const std::string& path);
  MapStore(MapStore&&) noexcept;
  MapStore& operator=(MapStore&&) noexcept;
  ~MapStore();

  /// Writes pages, and changes that were made since if there are any, in one go; an error line, empty when done. After
  /// an error nothing is written.
  std::string write(const MapChanges* changes, const std::vector<std::shared_ptr<const MapPage>>& pages);
  /// What is anchored to a keyframe. The error: there is none, or it cannot be read.
  Result<MapPage> page(KeyframeId id);
  /// All of the map.
  Result<Map> load();

 private:
  struct Closer {
    void operator()(sqlite3* db) const;
  };
  explicit MapStore(sqlite3* db) : db_(db) {}
  std::string whyNot() const;
  bool run(const char* sql);
  bool put(const MapPage& page);
  bool put(const MapChanges& changes);
  bool put(const char* sql, std::int64_t id, const std::string& bytes);

  std::unique_ptr<sqlite3, Closer> db_;
};

/// Whether the bytes of a file begin as those of a map store.
bool isMapStore(const std::string& path);
/// Reads all of a map store that a run has left.
Result<Map> loadMapStore(const std::string& path);
/// Whether nothing was written to a map store yet. One that cannot be read is not empty.
bool isEmptyMapStore(const std::string& path);
/// Removes a map store with what SQLite keeps beside it.
void removeMapStore(const std::string& path);
/// Gives it another name; an error line, empty when done.
std::string moveMapStore(const std::string& from, const std::string& to);

}  // namespace hgg
