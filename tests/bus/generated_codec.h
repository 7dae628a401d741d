#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace hgg {

/// The bytes of a message and back, by what lcm-gen generated: what another program would send or read.
using Message = std::vector<std::uint8_t>;

template <typename T>
Message encodeGenerated(const T& message) {
  Message bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

template <typename T>
T decodeGenerated(const Message& bytes) {
  T message;
  EXPECT_EQ(message.decode(bytes.data(), 0, static_cast<int>(bytes.size())), static_cast<int>(bytes.size()));
  return message;
}

}  // namespace hgg
