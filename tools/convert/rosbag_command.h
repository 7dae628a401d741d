#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace hgg {

/// Adds `hgg-convert rosbag`; `action` is what it does then, and returns the exit code.
void addRosbag(CLI::App& app, std::function<int()>& action);

}  // namespace hgg
