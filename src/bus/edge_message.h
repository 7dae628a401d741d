#pragma once

#include <hgg/edge_t.hpp>

#include "publish/messages.h"

namespace hgg {

/// An edge as MAP_OBJECTS and MAP_REGIONS send it. Only bus/codec_*.cpp include this.
inline hgg::edge_t makeEdge(const Edge& edge) {
  hgg::edge_t out;
  out.a = edge.a;
  out.b = edge.b;
  out.weight = edge.weight;
  return out;
}

}  // namespace hgg
