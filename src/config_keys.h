#pragma once

#include "config.h"

namespace hgg {

/// Meaning of a key: allowed range (numbers only), unit, one line of text.
struct KeyDoc {
  double min = 0, max = 0;
  const char* unit = "";
  const char* text = "";
};

// The one list of keys, by section. `visit(section, key, member, doc)` is called in the order of the printed file.

template <typename Section, typename Visitor>
void visitLcm(Section& c, Visitor& visit) {
  visit("lcm", "url", c.url,
        KeyDoc{0, 0, "", "LCM provider; ttl=0 stays on this machine, recv_buf_size must hold two clouds"});
  visit("lcm", "odometry", c.odometry, KeyDoc{0, 0, "channel", "in: bot_core.pose_t, T_odom_body"});
  visit("lcm", "lidar_semantic", c.lidar_semantic,
        KeyDoc{0, 0, "channel", "in: bot_core.pointcloud2_t with x, y, z, label"});
  visit("lcm", "pose_map", c.pose_map, KeyDoc{0, 0, "channel", "out: bot_core.pose_t, corrected T_map_body"});
  visit("lcm", "map_odom", c.map_odom, KeyDoc{0, 0, "channel", "out: bot_core.rigid_transform_t, T_map_odom"});
  visit("lcm", "map_objects", c.map_objects, KeyDoc{0, 0, "channel", "out: hgg.graph_update_t"});
  visit("lcm", "status", c.status, KeyDoc{0, 0, "channel", "out: hgg.status_t, 1 Hz"});
  visit("lcm", "map_regions", c.map_regions, KeyDoc{0, 0, "channel", "out: hgg.regions_t"});
  visit("lcm", "map_traversability", c.map_traversability, KeyDoc{0, 0, "channel", "out: hgg.traversability_t"});
  visit("lcm", "octomap", c.octomap, KeyDoc{0, 0, "channel", "out: octomap.raw_t"});
  visit("lcm", "command", c.command, KeyDoc{0, 0, "channel", "in: hgg.command_t"});
  visit("lcm", "command_reply", c.command_reply, KeyDoc{0, 0, "channel", "out: hgg.command_reply_t"});
  visit("lcm", "goal_query", c.goal_query, KeyDoc{0, 0, "channel", "in: hgg.goal_query_t, a thing in words"});
  visit("lcm", "goal_reply", c.goal_reply, KeyDoc{0, 0, "channel", "out: hgg.goal_reply_t"});
}

template <typename Section, typename Visitor>
void visitFrame(Section& c, Visitor& visit) {
  visit("frame", "range_min", c.range_min, KeyDoc{0, 100, "m", "nearer points are dropped (the robot itself)"});
  visit("frame", "range_max", c.range_max, KeyDoc{1, 1000, "m", "farther points are dropped"});
  visit("frame", "min_confidence", c.min_confidence, KeyDoc{0, 1, "", "points the segmenter trusts less are dropped"});
  visit("frame", "odometry_wait_ms", c.odometry_wait_ms,
        KeyDoc{0, 10000, "ms",
               "how long a cloud waits for odometry of its time before it is dropped (run; replay waits)"});
  visit("frame", "odometry_gap_s", c.odometry_gap_s,
        KeyDoc{0.01, 10, "s",
               "between odometry samples farther apart no pose is interpolated: clouds there are dropped"});
  visit("frame", "estimate_delay", c.estimate_delay,
        KeyDoc{0, 1, "", "find out from the turns by how much odometry's stamps lag behind the clouds', and undo it"});
  visit("frame", "deskew", c.deskew,
        KeyDoc{0, 1, "", "where points come with a time, take each to where it was at the cloud's"});
}

template <typename Section, typename Visitor>
void visitRig(Section& c, Visitor& visit) {
  visit("rig", "file", c.file,
        KeyDoc{0, 0, "path",
               "rig file, relative to this one: clouds without labels, labelled through cameras; empty: clouds on "
               "lcm.lidar_semantic"});
}

/// A key for each cloud channel, named as the channel is.
template <typename ConfigType, typename Visitor>
void visitMountings(ConfigType& c, Visitor& visit) {
  visit("T_body_lidar", c.lcm.lidar_semantic.c_str(), c.T_body_lidar.lidar_semantic,
        KeyDoc{-1000, 1000, "m, deg",
               "how the sensor is mounted: x, y, z, roll, pitch, yaw; zeros: clouds are in the body frame"});
}

template <typename Section, typename Visitor>
void visitCreation(Section& c, Visitor& visit) {
  visit("creation", "beam_spacing_deg", c.beam_spacing_deg,
        KeyDoc{0, 3, "deg", "vertical angle between LiDAR beams; 0 for depth cameras"});
  visit("creation", "beam_factor", c.beam_factor,
        KeyDoc{0, 2.5, "", "clusters bridge gaps of this many beam spacings at any range"});
  visit("creation", "tile_size", c.tile_size, KeyDoc{0.5, 100, "m", "edge of the map tiles that bound stuff nodes"});
  visit("creation", "leaf_points", c.leaf_points,
        KeyDoc{4, 100000, "points", "most points in a leaf of a frame's geometry graph"});
  visit("creation", "leaf_gap", c.leaf_gap,
        KeyDoc{0.02, 100, "m", "no leaf bridges a wider gap (grows with range like clusters do)"});
  visit("creation", "edge_geometry_share", c.edge_geometry_share,
        KeyDoc{0, 1, "", "c of the edge weight: geometry against class agreement"});
  visit("creation", "sigma_floor", c.sigma_floor, KeyDoc{0.0001, 1, "m", "sensor noise; floor under flat extents"});
}

template <typename Section, typename Visitor>
void visitAlignment(Section& c, Visitor& visit) {
  visit("alignment", "gate", c.gate, KeyDoc{0.05, 100, "m", "pairs costlier than this stay unmatched"});
  visit("alignment", "geometry_share", c.geometry_share,
        KeyDoc{0, 1, "", "alpha_c of the pair cost: Wasserstein distance against neighbour histogram"});
  visit("alignment", "leaf_gate", c.leaf_gate, KeyDoc{0.02, 10, "m", "leaves farther apart than this are no pair"});
  visit("alignment", "leaf_geometry_share", c.leaf_geometry_share,
        KeyDoc{0, 1, "", "alpha_r of the leaf cost: distance against Weisfeiler-Lehman features; below 1 is slow"});
  visit("alignment", "max_leaf_pairs", c.max_leaf_pairs,
        KeyDoc{10, 100000, "leaves", "of a frame that take part in fine alignment, spread evenly over it"});
  visit("alignment", "odometry_drift", c.odometry_drift,
        KeyDoc{0, 1, "", "odometry's error as a share of the way and of the turn, one standard deviation"});
  visit("alignment", "odometry_turn_deg", c.odometry_turn_deg,
        KeyDoc{0, 10, "deg", "odometry's error of the heading per metre, one standard deviation"});
  visit("alignment", "odometry_jitter", c.odometry_jitter,
        KeyDoc{0.0001, 1, "m", "odometry's error between two frames whatever the way, one standard deviation"});
  visit("alignment", "odometry_jitter_deg", c.odometry_jitter_deg,
        KeyDoc{0.001, 10, "deg", "odometry's error of the attitude between two frames, one standard deviation"});
}

template <typename Section, typename Visitor>
void visitMap(Section& c, Visitor& visit) {
  visit("map", "leaf_size", c.leaf_size, KeyDoc{0.05, 10, "m", "cell of the finest leaves: one leaf each"});
  visit("map", "merge_overlap", c.merge_overlap,
        KeyDoc{0.01, 1, "", "same-class things whose extents overlap more (Bhattacharyya coefficient) are one object"});
  visit(
      "map", "fragment_share", c.fragment_share,
      {0, 1, "", "a thing with less than this share of the evidence of a same-class thing beside it is a piece of it"});
  visit("map", "active_radius", c.active_radius,
        KeyDoc{1, 10000, "m", "map nodes farther from the robot are left alone"});
  visit("map", "snapshot_s", c.snapshot_s,
        KeyDoc{0, 86400, "s", "run: the map is written this often, so that a killed run loses no more; 0: never"});
}

template <typename Section, typename Visitor>
void visitMemory(Section& c, Visitor& visit) {
  visit("memory", "budget_mb", c.budget_mb,
        KeyDoc{1, 1000000, "MB", "memory of the map: when it would take more, far parts go to disk"});
}

template <typename Section, typename Visitor>
void visitCorrection(Section& c, Visitor& visit) {
  visit("correction", "window", c.window,
        KeyDoc{0, 0, "", "refine the poses of the last keyframes by the objects seen from them"});
  visit("correction", "em", c.em, KeyDoc{0, 0, "", "refine the leaves of objects by the points of the last keyframes"});
  visit("correction", "em_points", c.em_points,
        KeyDoc{100, 10000000, "points", "most that one keyframe's refinement of leaves looks at"});
  visit("correction", "loop_closure", c.loop_closure,
        KeyDoc{0, 0, "", "find places again and spread what had drifted over the way"});
  visit("correction", "drift_reach", c.drift_reach,
        KeyDoc{0.01, 1000, "m", "parts of the map that may have drifted farther from the robot wait for a loop"});
}

template <typename Section, typename Visitor>
void visitTraversability(Section& c, Visitor& visit) {
  visit("traversability", "resolution", c.resolution, KeyDoc{0.02, 2, "m", "edge of a cell of the cost grid"});
  visit("traversability", "step_height", c.step_height,
        KeyDoc{0.02, 1, "m", "highest step the robot takes, up or down"});
  visit("traversability", "max_slope_deg", c.max_slope_deg, KeyDoc{1, 50, "deg", "steepest ground it walks on"});
  visit("traversability", "body_height", c.body_height, KeyDoc{0.05, 5, "m", "free height it needs above the ground"});
  visit("traversability", "footprint_radius", c.footprint_radius,
        KeyDoc{0, 2, "m", "its centre stays this far from what it cannot walk on: half its width"});
  visit("traversability", "min_confidence", c.min_confidence,
        KeyDoc{0, 1, "", "ground known less well than this is unknown"});
  visit("traversability", "publish_rate", c.publish_rate,
        KeyDoc{0, 10, "Hz", "how often the grid around the robot is published; 0: on command only"});
  visit("traversability", "publish_size", c.publish_size, KeyDoc{2, 200, "m", "edge of that grid"});
  visit("traversability", "octomap_rate", c.octomap_rate,
        KeyDoc{0, 10, "Hz", "how often an OctoMap of the same square is published; 0: on command only"});
  visit("traversability", "octomap_resolution", c.octomap_resolution,
        KeyDoc{0.05, 2, "m", "edge of its voxels, and of those of a command that names none"});
}

template <typename Section, typename Visitor>
void visitAblation(Section& c, Visitor& visit) {
  visit("ablation", "symmetric_merge", c.symmetric_merge,
        KeyDoc{0, 0, "", "for evaluation only: merge beliefs half and half, blind to their evidence"});
  visit("ablation", "odometry_pose", c.odometry_pose,
        KeyDoc{0, 0, "", "for evaluation only: poses are odometry's, the map is not asked"});
  visit("ablation", "uniform_weights", c.uniform_weights,
        KeyDoc{0, 0, "", "for evaluation only: factors of the window weigh the same, whatever was seen"});
  visit("ablation", "blind_to_free_space", c.blind_to_free_space,
        KeyDoc{0, 0, "", "for evaluation only: what beams pass through does not speak against things"});
  visit("ablation", "single_frames", c.single_frames,
        KeyDoc{0, 0, "", "for evaluation only: clusters below min_points are dropped, not gathered over frames"});
  visit("ablation", "blind_to_motion", c.blind_to_motion,
        KeyDoc{0, 0, "", "for evaluation only: what moves is taken to be part of the map"});
  visit("ablation", "loose_pieces", c.loose_pieces,
        KeyDoc{0, 0, "",
               "for evaluation only: parts of a thing that touch, and other names for it, stay things of their own"});
  visit("ablation", "cost", c.cost,
        KeyDoc{0, 0, "", "for evaluation only: geometric cost of a pair of things; wasserstein, centroid or iou"});
}

template <typename ConfigType, typename Visitor>
void visitConfig(ConfigType& c, Visitor&& visit) {
  visit("", "classes", c.classes,
        KeyDoc{0, 0, "path", "class table, relative to this file; empty: the built-in SemanticKITTI table"});
  visitLcm(c.lcm, visit);
  visitFrame(c.frame, visit);
  visitMountings(c, visit);
  visitRig(c.rig, visit);
  visitCreation(c.creation, visit);
  visitAlignment(c.alignment, visit);
  visitMap(c.map, visit);
  visitMemory(c.memory, visit);
  visitCorrection(c.correction, visit);
  visitTraversability(c.traversability, visit);
  visitAblation(c.ablation, visit);
}

}  // namespace hgg
