// The cell around a robot as its file states it (sagitta/cell/1), SI inside: what a pose that is to be measured must
// keep to. Whatever is not stated is not checked. Boxes, floor and directions are in the robot's base frame.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "models/geometry.h"

namespace sagitta {

// Narrower than the joint's own limits; or the only values that it may have (rad or m).
struct JointRange {
  std::optional<double> min, max;
  std::vector<double> levels;
};

// A box; its faces belong to it.
struct CellBox {
  std::string name;
  Pose<double> base_from_box;  // its centre and edges
  Vector3<double> half_size = Vector3<double>::Zero();

  bool Contains(const Vector3<double>& point_in_base) const {
    const Vector3<double> own =
        base_from_box.rotation.transpose() * Vector3<double>(point_in_base - base_from_box.translation);
    return (own.cwiseAbs() - half_size).maxCoeff() <= 0.0;
  }
};

// A body of the arm: all points within `radius` of a line. It rides on the base, the flange or the frame right after a
// joint, in whose coordinates the line's ends are.
struct LinkCapsule {
  static constexpr int kBase = -1, kFlange = -2;
  std::string name;
  int on = kFlange;  // joint index, or one of the above
  Vector3<double> from = Vector3<double>::Zero(), to = Vector3<double>::Zero();
  double radius = 0.0;
};

// An axis that must stay within an angle of a direction.
struct DirectionCone {
  Vector3<double> axis;       // unit, in the frame of what carries it
  double half_angle = 0.0;    // rad
  Vector3<double> direction;  // unit, base frame; of the tool only: a reflector's is that to the instrument
};

// What an instrument reads: between two distances and two elevations (of the measurement frame, z up).
struct SightRange {
  double min_range = 0.0, max_range = 1e9;           // m; not stated: whatever it is
  double min_elevation = -1.6, max_elevation = 1.6;  // rad; not stated: beyond a right angle, whatever it is
};

// What poses must keep to.
struct Cell {
  std::string file;
  std::vector<JointRange> joints;  // one per joint of the robot
  std::optional<double> floor;     // m, z
  std::vector<CellBox> stay_in, keep_out;
  std::vector<LinkCapsule> capsules;
  std::vector<std::array<int, 2>> may_touch;  // capsules
  std::vector<std::string> without_body;      // what is not compared, in words
  double clearance = 0.0;                     // m, of capsules to one another, to boxes and to the floor
  std::optional<DirectionCone> tool;
  std::vector<std::pair<std::string, SightRange>> sights;         // by station: those whose lines of sight count
  std::vector<std::pair<std::string, DirectionCone>> reflectors;  // by marker, axis in the frame the marker is on
  double beam_radius = 0.0;                                       // m
  double beam_end = 0.1;  // m before the reflector where the beam is assumed to end: its mount is no obstacle
};

}  // namespace sagitta
