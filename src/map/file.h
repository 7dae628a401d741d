#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "map/map.h"
#include "map/paging.h"

namespace hgg {

/// The map file, version 6. Little-endian; iN/uN are integers of N bits, f32/f64 IEEE floats.
///
///   file      := magic version frame+
///   magic     := 8 bytes "HGGMAP\r\n"          (a text-mode transfer breaks it visibly)
///   version   := u32, 5, or 6 if a node has looks, or 7 if one has seen_through (5: nodes end before looks;
///                                               4 is read too: no delay;
///                                               3: constraints end with is_loop;
///                                               2: no constraints, no anchors; 1: no classes either)
///   frame     := a zstd frame with content size and content checksum; at most 4 MiB of the payload
///   payload   := classes tile_size delay revision next_id keyframes constraints nodes edges "END."   (frames joined)
///   classes   := u32 count, count x { u16 id, u16 length, length bytes UTF-8 name }        ascending by id
///   tile_size := f64                                                                       m, edge of the stuff tiles
///   delay     := i64                            us, by which odometry lagged
///   revision  := i64
///   next_id   := i64                            the id of the next new node; above every id that was ever given
///   keyframes := u64 count, count x { i64 utime_us, pose T_map_body }
///   constraints := u64 count, count x { i32 a, i32 b, pose T_a_b, f64 sigma (m), f64 sigma_turn (rad), u8 is_loop,
///                f64 expected (m), f64 expected_turn (rad) };
///                a, b: indices of two keyframes; sigma, expected within 1e-6 .. 1e3 m, turns within 1e-7 .. 1e3 rad
///   nodes     := u64 count, count x node                                                   ascending by id
///   node      := i64 id, u16 label, u8 stuff, 3 x i32 tile, belief, pose T_map_object, i32 views, i64 first_us,
///                i64 last_us, i32 anchor (index of a keyframe, -1 for none), u32 count, count x leaf, u16 count,
///                count x { u16 class, f32 views }, looks
///   looks     := u8 bits (1 colour, 2 front, 4 free space), 3 x u8 rgb if bit 1, 3 x f32 front if bit 2: a unit
///                vector, object frame; f32 seen_through, f32 passed if bit 4 (views; core/class_belief.h)
///   belief    := 3 x f64 mean, 6 x f64 covariance (00 11 22 01 02 12), f64 kappa           map frame
///   leaf      := 3 x f32 mean, 6 x f32 covariance (same order), f32 kappa                  object frame
///   pose      := 3 x f64 translation, 9 x f64 rotation matrix (row-major)
///   edges     := u64 count, count x { i64 a, i64 b, f32 weight }                           a < b
///
/// Equal maps give equal bytes.

/// A map as it was stored. The weights of the edges are those it was stored with: what goes on from the map sets its
/// edge model, and has a graph of its own from then on.
struct StoredMap {
  Map map;
  std::vector<Edge> edges;
};

/// The bytes of a map file. Of a map, with the edges of its graph (those it has once it is settled).
std::string encodeMap(const Map& map);
std::string encodeMap(const StoredMap& stored);

/// Writes `map` to `path` by way of a temporary file in the same directory and a rename, so that a reader or a power
/// cut never meets half a map. Returns an error line, empty when done.
/// What is paged out is read by `pages`: it is written without being brought back, a few pages at a time. It is an
/// error if something is paged out and there is no reader, or it fails.
std::string saveMap(const Map& map, const std::string& path, const PageReader& pages = nullptr);

/// Reads the bytes of a map file.
Result<StoredMap> decodeMap(std::string_view bytes);

/// Reads a map file, or what a run has written of its map (map/map_store.h); truncated, corrupted, foreign or newer
/// files are an error, never a crash.
Result<StoredMap> loadMap(const std::string& path);

}  // namespace hgg
