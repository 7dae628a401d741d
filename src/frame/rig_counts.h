#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace hgg {

/// What became of points: of those a camera has in its image, a point in two images counts twice.
struct LabelCounts {
  std::int64_t points = 0, labelled = 0;  // of the cloud; of them those with a class
  std::int64_t seen = 0;                  // in an image
  std::int64_t hidden = 0;                // behind something nearer
  std::int64_t border = 0, regained = 0;  // near the border of a mask; of them those whose depth gave another label
  std::int64_t unsure = 0;                // on pixels of too little confidence
  std::int64_t no_class = 0;              // on pixels without a class
  std::int64_t foreign = 0;               // on pixels with a number outside the label set

  LabelCounts& operator+=(const LabelCounts& other) {
    points += other.points, labelled += other.labelled, seen += other.seen, hidden += other.hidden;
    border += other.border, regained += other.regained, unsure += other.unsure;
    no_class += other.no_class, foreign += other.foreign;
    return *this;
  }
};

/// What is wrong with a sensor of a rig at present.
struct SensorTrouble {
  std::string sensor, code, text;
};

/// What the clouds and images of a rig came to. Reasons are a fixed set of texts, with the sensor's name before them.
struct RigCounts {
  LabelCounts labels;
  std::map<std::string, std::int64_t> troubles;  // "front: no image in time" -> frames or messages
  std::vector<SensorTrouble> standing;           // what is wrong at present, one a sensor at most
};

}  // namespace hgg
