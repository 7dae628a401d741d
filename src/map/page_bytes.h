#pragma once

#include <string>
#include <string_view>

#include "core/result.h"
#include "map/map_changes.h"

namespace hgg {

/// A page as bytes: a zstd frame with a checksum around the layout of map/file.h. The error: damaged, or not finite.
Result<std::string> encodePage(const MapPage& page);
Result<MapPage> decodePage(std::string_view bytes);

/// The same of a head.
Result<std::string> encodeHead(const MapHead& head);
Result<MapHead> decodeHead(std::string_view bytes);

}  // namespace hgg
