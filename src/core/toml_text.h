#pragma once

#include <string>

namespace hgg {

// Values as they stand in a TOML file.

/// A basic string, in quotes.
std::string tomlString(const std::string& text);
/// A float: never without a point or an exponent.
std::string tomlFloat(double value);
/// A key: bare where its characters allow.
std::string tomlKey(const std::string& key);

}  // namespace hgg
