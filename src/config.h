#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/classes.h"
#include "core/mounting.h"
#include "core/result.h"

namespace hgg {

struct LcmConfig {
  std::string url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";
  std::string odometry = "POSE_ODOM";
  std::string lidar_semantic = "LIDAR_SEMANTIC";
  std::string pose_map = "POSE_MAP";
  std::string map_odom = "MAP_ODOM";
  std::string map_objects = "MAP_OBJECTS";
  std::string status = "HGG_STATUS";
  std::string map_regions = "MAP_REGIONS";
  std::string map_traversability = "MAP_TRAVERSABILITY";
  std::string octomap = "OCTOMAP";
  std::string command = "HGG_COMMAND";
  std::string command_reply = "HGG_COMMAND_REPLY";
  std::string goal_query = "GOAL_QUERY";
  std::string goal_reply = "GOAL_REPLY";
};

struct FrameConfig {
  double range_min = 1.0;
  double range_max = 80.0;
  double min_confidence = 0.0;
  double odometry_wait_ms = 200.0;
  double odometry_gap_s = 3.0;
  bool estimate_delay = true;
  bool deskew = true;
};

/// T_body_lidar of every cloud channel.
struct MountingConfig {
  Mounting lidar_semantic;
};

/// Cameras that label clouds.
struct RigConfig {
  std::string file;  // relative to the config file; empty: clouds come with labels
};

struct CreationConfig {
  double beam_spacing_deg = 0.45;
  double beam_factor = 2.0;
  double tile_size = 10.0;
  int leaf_points = 64;
  double leaf_gap = 2.0;
  double edge_geometry_share = 0.5;
  double sigma_floor = 0.01;
};

struct AlignmentConfig {
  double gate = 3.0;
  double geometry_share = 0.9;
  double leaf_gate = 1.0;
  double leaf_geometry_share = 1.0;
  int max_leaf_pairs = 1500;
  double odometry_drift = 0.03;
  double odometry_turn_deg = 0.2;
  double odometry_jitter = 0.01;
  double odometry_jitter_deg = 0.05;
};

struct MapConfig {
  double leaf_size = 0.4;
  double merge_overlap = 0.5;
  double fragment_share = 0.1;
  double active_radius = 100.0;
  double snapshot_s = 5.0;
};

struct MemoryConfig {
  double budget_mb = 256.0;
};

struct CorrectionConfig {
  bool window = false;
  bool em = true;
  int em_points = 8000;
  bool loop_closure = true;
  double drift_reach = 0.5;
};

/// What a legged robot can walk on, and the grid that says where it can.
struct TraversabilityConfig {
  double resolution = 0.1;
  double step_height = 0.2;
  double max_slope_deg = 30;
  double body_height = 0.7;
  double footprint_radius = 0.25;
  double min_confidence = 0.1;
  double publish_rate = 1;
  double publish_size = 40;
  double octomap_rate = 0;
  double octomap_resolution = 0.2;
};

/// What the cost of a pair of objects is made of; all but the first are ablations.
enum class PairCost : std::uint8_t { kWasserstein, kCentroid, kIou };

/// Weakened variants that an evaluation compares with; not for a robot.
struct AblationConfig {
  bool symmetric_merge = false;
  bool odometry_pose = false;
  bool uniform_weights = false;
  bool blind_to_free_space = false;
  bool single_frames = false;
  bool blind_to_motion = false;
  bool loose_pieces = false;
  PairCost cost = PairCost::kWasserstein;
};

/// Everything a user can set. Defaults live here, their meaning in visitConfig (config.cpp), where the TOML reader, the
/// checks and --print-config all take them from.
struct Config {
  std::string classes;  // path, relative to the config file; empty: the built-in SemanticKITTI table
  LcmConfig lcm;
  FrameConfig frame;
  MountingConfig T_body_lidar;
  RigConfig rig;
  CreationConfig creation;
  AlignmentConfig alignment;
  MapConfig map;
  MemoryConfig memory;
  CorrectionConfig correction;
  TraversabilityConfig traversability;
  AblationConfig ablation;
};

struct LoadedConfig {
  Config config;
  ClassTable classes;
  std::string rig_path;  // of rig.file; empty: there is none
};

/// Reads and checks a config and the class table it names; an empty path gives the defaults. The error lists every
/// unknown key and bad value at once, one a line.
Result<LoadedConfig> loadConfig(const std::string& path);
Result<Config> parseConfig(const std::string& toml_text, const std::string& source_name);
/// The effective config as a commented TOML file.
std::string printConfig(const Config& config);

}  // namespace hgg
