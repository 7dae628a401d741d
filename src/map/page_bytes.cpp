#include "map/page_bytes.h"

#include <zstd.h>

#include <memory>

#include "map/node_bytes.h"

namespace hgg {
namespace {

/// Pages are written while the robot drives: quick, and hardly larger than at the level of a map file.
constexpr int kPageLevel = 1;
/// No page is larger: a keyframe's nodes with a million leaves are 40 MB.
constexpr std::size_t kMostPageBytes = std::size_t{256} << 20;

Result<std::string> pack(const ByteWriter& w) {
  using Packed = Result<std::string>;
  if (!w.finite()) {
    return Packed::fail("it holds numbers that are not finite");
  }
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kPageLevel);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  std::string bytes(ZSTD_compressBound(w.bytes().size()), '\0');
  const std::size_t size =
      ZSTD_compress2(context.get(), bytes.data(), bytes.size(), w.bytes().data(), w.bytes().size());
  if (ZSTD_isError(size) != 0) {
    return Packed::fail("it cannot be compressed (is there memory left?)");
  }
  bytes.resize(size);
  return Packed::ok(std::move(bytes));
}

Result<std::string> unpack(std::string_view bytes) {
  const unsigned long long size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (size > kMostPageBytes) {
    return Result<std::string>::fail("damaged (a block has an impossible size)");
  }
  std::string text(static_cast<std::size_t>(size), '\0');
  if (ZSTD_decompress(text.data(), text.size(), bytes.data(), bytes.size()) != size) {
    return Result<std::string>::fail("damaged (a block fails its checksum)");
  }
  return Result<std::string>::ok(std::move(text));
}

}  // namespace

Result<std::string> encodePage(const MapPage& page) {
  ByteWriter w;
  w.put(kMapVersion);
  w.put(page.keyframe);
  w.put(page.T_map_keyframe);
  w.put(static_cast<std::uint64_t>(page.nodes.size()));
  for (const MapNode& node : page.nodes) {
    putNode(w, node, kMapVersion);
  }
  return pack(w);
}

Result<MapPage> decodePage(std::string_view bytes) {
  const Result<std::string> text = unpack(bytes);
  if (!text) {
    return Result<MapPage>::fail(text.error);
  }
  ByteReader r(*text);
  const auto version = r.get<std::uint32_t>();
  MapPage page;
  page.keyframe = r.get<KeyframeId>();
  page.T_map_keyframe = r.pose();
  r.require(version > kVersionWithoutExpected && version <= kMapVersion);
  page.nodes.resize(r.count(r.get<std::uint64_t>(), kLeastNodeBytes));
  NodeId last = 0;
  for (MapNode& node : page.nodes) {
    node = getNode(r, version);
    r.require(node.id > last && node.anchor == page.keyframe && node.belief.kappa >= 0);
    last = node.id;
  }
  return r.good() && r.atEnd() ? Result<MapPage>::ok(std::move(page))
                               : Result<MapPage>::fail("damaged (a page does not follow the format)");
}

Result<std::string> encodeHead(const MapHead& head) {
  ByteWriter w;
  w.put(kMapVersion);
  w.put(static_cast<std::uint32_t>(head.class_names.size()));
  for (const auto& [id, name] : head.class_names) {
    w.put(id);
    w.put(static_cast<std::uint16_t>(name.size()));
    w.put(std::string_view(name));
  }
  w.put(head.tile_size);
  w.put(head.odometry_delay_us);
  w.put(head.revision);
  w.put(head.next_id);
  w.put(static_cast<std::uint8_t>(head.edges.has_value()));
  if (head.edges) {
    w.put(head.edges->sigma_floor), w.put(head.edges->geometry_share);
  }
  return pack(w);
}

Result<MapHead> decodeHead(std::string_view bytes) {
  const Result<std::string> text = unpack(bytes);
  if (!text) {
    return Result<MapHead>::fail(text.error);
  }
  ByteReader r(*text);
  r.require(r.get<std::uint32_t>() <= kMapVersion);
  MapHead head;
  for (std::size_t n = r.count(r.get<std::uint32_t>(), 4); n > 0; --n) {
    const auto id = r.get<ClassId>();
    head.class_names[id] = std::string(r.take(r.get<std::uint16_t>()));
  }
  head.tile_size = r.get<double>();
  head.odometry_delay_us = r.get<Micros>();
  head.revision = r.get<std::int64_t>();
  head.next_id = r.get<NodeId>();
  if (r.get<std::uint8_t>() != 0) {
    const auto sigma_floor = r.get<double>(), geometry_share = r.get<double>();
    r.require(sigma_floor > 0 && geometry_share >= 0 && geometry_share <= 1);
    head.edges = {sigma_floor, geometry_share};
  }
  return r.good() && r.atEnd() ? Result<MapHead>::ok(std::move(head))
                               : Result<MapHead>::fail("damaged (its head does not follow the format)");
}

}  // namespace hgg
