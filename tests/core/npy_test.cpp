#include "core/npy.h"

#include <gtest/gtest.h>

#include <array>

namespace hgg::npy_test {
namespace {

// As numpy.save writes it: the text is filled up with blanks so that the data begin at a multiple of 64 bytes.
std::string byNumPy(const std::string& text, const std::string& data) {
  std::string head = text + std::string(117 - text.size(), ' ') + "\n";
  return std::string("\x93NUMPY\x01\x00\x76\x00", 10) + head + data;
}

TEST(NpyFile, HasTheBytesThatNumPyWrites) {
  EXPECT_EQ(npyFile("|u1", std::array<std::size_t, 1>{3}, "abc"),
            byNumPy("{'descr': '|u1', 'fortran_order': False, 'shape': (3,), }", "abc"));
  EXPECT_EQ(npyFile("<f4", std::array<std::size_t, 3>{2, 1, 1}, "01234567"),
            byNumPy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 1, 1), }", "01234567"));
}

}  // namespace
}  // namespace hgg::npy_test
